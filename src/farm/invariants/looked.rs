//! What must hold, and what was found not to.

use std::{collections::BTreeMap, fmt, path::PathBuf};

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
    /// Something does not hold.
    pub(super) fn found(&mut self, invariant: Invariant, text: impl Into<String>, remedy: impl Into<String>) {
        let (text, remedy) = (text.into(), remedy.into());
        self.violations.push(Violation { invariant, text, remedy, by_people: false });
    }

    /// Something does not hold that a person may have done on purpose.
    pub(super) fn found_by_people(&mut self, invariant: Invariant, text: impl Into<String>, remedy: impl Into<String>) {
        self.found(invariant, text, remedy);
        if let Some(last) = self.violations.last_mut() {
            last.by_people = true;
        }
    }
}
