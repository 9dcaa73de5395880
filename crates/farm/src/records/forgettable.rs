//! Data that the store does not need any more, and the files that are being removed now.

use std::collections::BTreeSet;

use intake::{ContentStore, StoreError};
use ledger::RETRY_PERIOD;

/// Refused files stay in the store this long, so that `nestd retry` finds them.
pub(crate) const KEEP_REFUSED_SECS: f64 = RETRY_PERIOD.as_secs() as f64;

/// Something in the store that is not needed any more.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Forgettable {
    /// A stored file, given by its hash, with the claim notes beside it.
    StoredFile(String),
    /// A claim note beside a stored file that another claim still needs.
    ClaimNote {
        /// Hash of the file.
        hash: String,
        /// Name of the claim.
        claim: String,
    },
}

impl Forgettable {
    /// Removes it. It is no error if it does not exist.
    ///
    /// # Errors
    /// The file system reports an error.
    pub(crate) fn remove_from(&self, store: &ContentStore) -> Result<(), StoreError> {
        match self {
            Self::StoredFile(hash) => store.remove_content(hash),
            Self::ClaimNote { hash, claim } => store.delete_note(hash, claim),
        }
    }
}

/// The data to remove from the store, and the files that a job removes now.
#[derive(Debug, Default)]
pub(crate) struct ForgettingState {
    wanted: BTreeSet<Forgettable>,
    under_way: BTreeSet<String>,
}

impl ForgettingState {
    /// Whether the stored file of a hash is being removed.
    pub(crate) fn is_under_way(&self, hash: &str) -> bool {
        self.under_way.contains(hash)
    }

    /// Adds data to be removed.
    pub(crate) fn want(&mut self, unneeded: impl IntoIterator<Item = Forgettable>) {
        self.wanted.extend(unneeded);
    }

    /// All data to be removed.
    pub(crate) fn wanted(&self) -> &BTreeSet<Forgettable> {
        &self.wanted
    }

    /// Records that a job removes these now. The rest of what was to be removed is needed after all.
    pub(crate) fn begin(&mut self, removed: &[Forgettable]) {
        self.wanted.clear();
        self.under_way.extend(removed.iter().filter_map(|one| match one {
            Forgettable::StoredFile(hash) => Some(hash.clone()),
            Forgettable::ClaimNote { .. } => None,
        }));
    }

    /// Records that no job removes anything any more.
    pub(crate) fn end(&mut self) {
        self.under_way.clear();
    }
}
