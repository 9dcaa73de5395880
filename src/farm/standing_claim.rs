//! A claim whose original still lies in the hot folder's `.claimed`, with what is noted of it beside its stored file.

use crate::intake::{ClaimedPart, ContentStore, StoreError};

/// A recorded claim that has not been let go.
#[derive(Debug, Clone)]
pub(super) struct StandingClaim {
    /// The claim.
    pub claim: ClaimedPart,
    /// What is noted of it beside its stored file.
    pub note: String,
}

impl StandingClaim {
    /// Copies the original into the store again where it is not there: between the first copy and the row, the end of an earlier
    /// part of the same content may have taken it away.
    ///
    /// # Errors
    /// The disk does not let it.
    pub(super) fn ensure_stored(&self, store: &ContentStore, hash: &str) -> Result<(), StoreError> {
        let stored = store.file_path(hash)?;
        match stored.try_exists() {
            Ok(true) => Ok(()),
            Err(source) => Err(StoreError::Io { what: "look at", path: stored, source }),
            Ok(false) => {
                store.store_claimed(&self.claim)?;
                store.write_note(hash, &self.claim.id, &self.note)
            }
        }
    }
}
