//! What must hold whatever happens, looked for from the outside: in the ledger, in the folders and in the bytes of the
//! files. Changes nothing.
//!
//! - I1: every file that ever left the hot folder is in exactly one of work, store, error and archive; byte-identical.
//! - I2: each copy of a part is in at most one published build, and in exactly one once its batch is done.
//! - I3: a build file that is visible in a queue folder is complete, proved, and has its row.
//! - I4: the daemon deletes nothing but its own temporary files and what is past its retention.

mod builds;
mod files;
mod folders;

use std::{collections::BTreeMap, fmt, path::PathBuf};

use anyhow::{Context, Result};

use crate::{ledger::Ledger, settings::Settings};

/// Which of the invariants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Invariant {
    /// No file is lost.
    I1,
    /// No copy is lost or doubled.
    I2,
    /// What is visible in a queue is whole.
    I3,
    /// Nothing of others is deleted.
    I4,
}

/// An invariant that does not hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// Which one.
    pub invariant: Invariant,
    /// What was found.
    pub text: String,
    /// What to do about it.
    pub remedy: String,
    /// People may have done it on purpose (emptied an archive, copied a build file); the daemon never does.
    pub by_people: bool,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {}: {}.", self.invariant, self.text, self.remedy)
    }
}

/// What is known beside the ledger and the folders; by default nothing.
#[derive(Debug, Clone, Default)]
pub struct Witness {
    /// Nothing is under way and no person has tidied up: then a file has one place only.
    pub at_rest: bool,
    /// How often each content was dropped, by BLAKE3.
    pub dropped: BTreeMap<String, usize>,
    /// Files of others that must be as they were, with the BLAKE3 of each.
    pub untouched: Vec<(PathBuf, String)>,
}

/// What a look found.
#[derive(Debug, Default)]
pub struct Looked {
    /// What does not hold; empty = all is well.
    pub violations: Vec<Violation>,
    /// Files that were read to the end.
    pub files: u64,
    /// Build files that were read and compared with their rows.
    pub builds: u64,
}

impl Looked {
    fn found(&mut self, invariant: Invariant, text: impl Into<String>, remedy: impl Into<String>) {
        let (text, remedy) = (text.into(), remedy.into());
        self.violations.push(Violation { invariant, text, remedy, by_people: false });
    }

    fn found_by_people(&mut self, invariant: Invariant, text: impl Into<String>, remedy: impl Into<String>) {
        self.found(invariant, text, remedy);
        if let Some(last) = self.violations.last_mut() {
            last.by_people = true;
        }
    }
}

/// Looks for whatever breaks I1 to I4. While a daemon works on the farm, a file may be seen between two places: what it
/// says is then certain only when a second look says it too.
pub async fn invariants(settings: &Settings, ledger: &Ledger, witness: &Witness) -> Result<Looked> {
    let mut looked = Looked::default();
    for fault in ledger.faults().await.context("asking the ledger whether it holds together")? {
        looked.found(Invariant::I2, format!("the ledger does not hold together: {fault}"), LEDGER_BROKEN);
    }
    let folders = folders::Folders::read(settings, witness, ledger, &mut looked).await?;
    files::live_and_refused(settings, ledger, &folders, witness, &mut looked).await?;
    files::built(settings, ledger, &mut looked).await?;
    files::work(ledger, &folders, witness, &mut looked).await?;
    files::dropped(ledger, &folders, witness, &mut looked).await?;
    files::untouched(witness, &mut looked);
    builds::visible(settings, ledger, witness, &mut looked).await?;
    unknown(settings, ledger, &mut looked).await?;
    Ok(looked)
}

/// What the folders tell and the ledger does not know.
async fn unknown(settings: &Settings, ledger: &Ledger, looked: &mut Looked) -> Result<()> {
    let (unknown, away) = super::current::unknown(settings, ledger).await?;
    for what in unknown {
        let text = format!("the folders tell of {what}, and the ledger does not know it");
        looked.found(Invariant::I1, text, super::Attention::LedgerBehind.remedy());
    }
    for away in away {
        let text = format!("{} cannot be looked at ({})", away.folder.display(), away.why);
        looked.found(Invariant::I1, text, "mount it again, let nestd's user read it, and look once more");
    }
    Ok(())
}

const LEDGER_BROKEN: &str = "stop the daemon, put the last backup of the ledger back and report this to nestd's makers";
