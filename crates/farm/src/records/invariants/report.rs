//! The invariants, and the violations that were found.

use std::{collections::BTreeMap, fmt, path::PathBuf};

/// One of the invariants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Invariant {
    /// No file is lost.
    I1,
    /// No copy is lost or doubled.
    I2,
    /// A visible file in a queue is complete.
    I3,
    /// No file of others is deleted.
    I4,
    /// No copy of an order leaves its sum.
    I5,
}

/// A violation of an invariant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InvariantViolation {
    /// Which invariant.
    pub invariant: Invariant,
    /// What was found.
    pub text: String,
    /// What to do about it.
    pub remedy: String,
    /// People may have caused it on purpose (emptied an archive, copied a build file); the daemon never does.
    pub may_be_manual: bool,
}

impl fmt::Display for InvariantViolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {}: {}.", self.invariant, self.text, self.remedy)
    }
}

/// What is known besides the ledger and the folders; by default nothing.
#[derive(Debug, Clone, Default)]
pub struct InvariantExpectations {
    /// No work is in progress and nobody has tidied up: then each file is in one place only.
    pub at_rest: bool,
    /// How often each content was dropped, by BLAKE3.
    pub dropped: BTreeMap<String, usize>,
    /// Files that do not belong to nestd and must be unchanged, with their BLAKE3.
    pub untouched: Vec<(PathBuf, String)>,
    /// What was asked, by BLAKE3 of the dropped file, as a witness beside the ledger wrote it down; `None` = nobody did.
    pub asked: Option<BTreeMap<String, AskedCopies>>,
    /// The build files that printers took. Only read where `asked` is known.
    pub taken: Vec<PathBuf>,
}

/// The copies that were asked of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AskedCopies {
    /// Copies wanted; those that were cancelled one by one are not.
    pub wanted: u32,
    /// Copies in build files that people said were printed badly, or would not count.
    pub bad: u32,
}

/// Result of a check.
#[derive(Debug, Default)]
pub struct InvariantReport {
    /// Violations; empty = everything is correct.
    pub violations: Vec<InvariantViolation>,
    /// Number of files that were read completely.
    pub files_read: u64,
    /// Number of build files that were compared with their rows.
    pub builds_checked: u64,
}

impl InvariantReport {
    /// Adds a violation.
    pub(super) fn add_violation(&mut self, invariant: Invariant, text: impl Into<String>, remedy: impl Into<String>) {
        let (text, remedy) = (text.into(), remedy.into());
        self.violations.push(InvariantViolation { invariant, text, remedy, may_be_manual: false });
    }

    /// Adds a violation that people may have caused on purpose.
    pub(super) fn add_manual_violation(
        &mut self,
        invariant: Invariant,
        text: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.add_violation(invariant, text, remedy);
        if let Some(last) = self.violations.last_mut() {
            last.may_be_manual = true;
        }
    }
}
