//! What the store does not need any more, and what of it is being removed now.

use std::collections::BTreeSet;

use crate::{
    intake::{ContentStore, StoreError},
    ledger::RETRY_PERIOD,
};

/// Refused files stay in the store this long, so that `nestd retry` finds them.
pub(super) const KEEP_REFUSED_SECS: f64 = RETRY_PERIOD.as_secs() as f64;

/// Something in the store that is not needed any more.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Forgettable {
    /// A stored file with the notes beside it, by its hash.
    StoredFile(String),
    /// The note of a claim beside a file that is kept for another one.
    ClaimNote {
        /// Hash of the file.
        hash: String,
        /// Whose note.
        claim: String,
    },
}

impl Forgettable {
    /// Removes it; that it is not there is no error.
    ///
    /// # Errors
    /// The disk does not let it.
    pub(super) fn remove_from(&self, store: &ContentStore) -> Result<(), StoreError> {
        match self {
            Self::StoredFile(hash) => store.remove_content(hash),
            Self::ClaimNote { hash, claim } => store.delete_note(hash, claim),
        }
    }
}

/// What is to be removed from the store, and what a job removes now.
#[derive(Debug, Default)]
pub(super) struct ForgettingState {
    wanted: BTreeSet<Forgettable>,
    under_way: BTreeSet<String>,
}

impl ForgettingState {
    /// Whether the stored file of a hash is being removed.
    pub(super) fn is_under_way(&self, hash: &str) -> bool {
        self.under_way.contains(hash)
    }

    /// Adds to what is to be removed.
    pub(super) fn want(&mut self, unneeded: impl IntoIterator<Item = Forgettable>) {
        self.wanted.extend(unneeded);
    }

    /// All that is to be removed.
    pub(super) fn take_wanted(&mut self) -> BTreeSet<Forgettable> {
        std::mem::take(&mut self.wanted)
    }

    /// It is being removed now.
    pub(super) fn begin(&mut self, one: &Forgettable) {
        if let Forgettable::StoredFile(hash) = one {
            self.under_way.insert(hash.clone());
        }
    }

    /// Nothing is being removed any more.
    pub(super) fn end(&mut self) {
        self.under_way.clear();
    }
}
