//! The ledger itself: opening, one writer, many readers.

use std::path::Path;

use jiff::Timestamp;

use super::LedgerError;

/// The database of a farm. Cloning is cheap and gives another handle of the same ledger.
#[derive(Clone)]
pub struct Ledger {}

impl Ledger {
    /// Opens the ledger at `path`; makes the file and its folder when there is none, brings its schema up to date.
    pub async fn open(_path: &Path) -> Result<Self, LedgerError> {
        Ok(Self {})
    }

    /// Opens a ledger that is there and up to date; for faces, which must not make one.
    pub async fn open_existing(path: &Path) -> Result<Self, LedgerError> {
        Err(LedgerError::Missing { path: path.to_owned() })
    }

    /// The same ledger with another clock, for tests that turn time by hand.
    pub fn with_clock(self, _clock: impl Fn() -> Timestamp + Send + Sync + 'static) -> Self {
        self
    }

    /// Ends all work in order.
    pub async fn close(&self) {}
}
