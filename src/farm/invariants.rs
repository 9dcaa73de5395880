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
mod looked;

use anyhow::{Context, Result};

pub use looked::{Invariant, Looked, Violation, Witness};

use crate::{ledger::Ledger, settings::Settings};

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
