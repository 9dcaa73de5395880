//! A claim whose original is still in the hot folder's `.claimed`, with its claim note.

use intake::{ClaimedPart, ContentStore, StoreError};

/// A recorded claim that has not been released.
#[derive(Debug, Clone)]
pub(crate) struct StandingClaim {
    /// The claim.
    pub claim: ClaimedPart,
    /// Text of the claim note beside its stored file.
    pub note: String,
}

impl StandingClaim {
    /// Copies the original into the store again if it is missing there. An earlier part with the same content may have
    /// ended after the first copy and before the row was recorded, and its stored file was removed.
    ///
    /// # Errors
    /// The file system reports an error.
    pub(crate) fn ensure_stored(&self, store: &ContentStore, hash: &str) -> Result<(), StoreError> {
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
