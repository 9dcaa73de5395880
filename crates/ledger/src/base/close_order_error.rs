//! Why an order is not closed.

use thiserror::Error;

/// Why an order cannot be closed.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
pub enum CloseOrderError {
    /// There is none.
    #[error("there is no order '{0}'; `nestd orders --all` lists them")]
    Unknown(String),
    /// Nothing of it waits or asks for a person.
    #[error(
        "nothing of order {0} waits or was refused, so there is nothing to close; `nestd show order {0}` says what became of it"
    )]
    NothingToClose(String),
    /// Files of it arrive, or are being read.
    #[error("files of order {0} are being taken and read; close it in a moment")]
    BeingRead(String),
}
