//! What follows from an error of the ledger: whether it is the ledger itself that failed, and whether it helps to try again.

use crate::{
    LedgerError, ServerError,
    base::sqlite_code::{SQLITE_CORRUPT, SQLITE_FULL, SQLITE_IOERR, SQLITE_NOTADB, SQLITE_READONLY, sqlite_code},
};

impl LedgerError {
    /// Whether the ledger itself could not be read or changed: what was asked may well be allowed.
    pub fn is_trouble(&self) -> bool {
        let is_replaced = matches!(self, Self::Replaced { .. } | Self::Overwritten { .. });
        is_replaced
            || self.is_disk_failure()
            || self.is_damage()
            || matches!(self, Self::Sql(_) | Self::Open { .. } | Self::Server(_))
    }

    /// Whether the cause is a failed or full disk, or a lock, and not the change. Retrying helps once the disk is repaired.
    pub fn is_disk_failure(&self) -> bool {
        match self {
            Self::ReadOnly | Self::Folder { .. } | Self::Locked { .. } => true,
            Self::Server(error) => error.is_transient(),
            Self::Open { error, .. } | Self::Sql(error) => {
                matches!(error, sqlx::Error::Io(_)) || matches!(sqlite_code(error), Some(SQLITE_IOERR | SQLITE_FULL))
            }
            _ => false,
        }
    }
}

impl From<sqlx::Error> for LedgerError {
    fn from(error: sqlx::Error) -> Self {
        use sqlx::Error::{AnyDriverError, ColumnDecode, Decode};
        let error = match error {
            AnyDriverError(source) => match source.downcast::<ServerError>() {
                Ok(server) => return Self::Server(*server),
                Err(other) => AnyDriverError(other),
            },
            other => other,
        };
        match (sqlite_code(&error), &error) {
            (Some(SQLITE_READONLY), _) => Self::ReadOnly,
            (Some(SQLITE_CORRUPT | SQLITE_NOTADB), _) | (_, ColumnDecode { .. } | Decode(_)) => {
                Self::Corrupt(error.to_string())
            }
            _ => Self::Sql(error),
        }
    }
}

impl LedgerError {
    /// Whether the ledger file is damaged, so retrying does not help.
    pub fn is_damage(&self) -> bool {
        matches!(self, Self::Damaged { .. } | Self::Corrupt(_))
    }
}
