//! What a page answers when it cannot answer.

use axum::{
    http::StatusCode,
    response::{IntoResponse, Response},
};

use super::page;
use crate::ledger::LedgerError;

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub(super) enum Problem {
    /// Nothing of that name or number.
    #[error("there is no {0}")]
    NotFound(String),
    /// The request makes no sense or may not be made.
    #[error("{1}")]
    Refused(StatusCode, String),
    /// The ledger does not answer.
    #[error(transparent)]
    Ledger(#[from] LedgerError),
    /// Something else failed.
    #[error("{0:#}")]
    Failed(#[from] anyhow::Error),
}

/// What a handler gives back.
pub(super) type Answer<T> = Result<T, Problem>;

impl Problem {
    pub(super) fn status(&self) -> StatusCode {
        match self {
            Self::NotFound(_) => StatusCode::NOT_FOUND,
            Self::Refused(status, _) => *status,
            Self::Ledger(_) => StatusCode::SERVICE_UNAVAILABLE,
            Self::Failed(_) => StatusCode::INTERNAL_SERVER_ERROR,
        }
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = self.status();
        if status.is_server_error() {
            tracing::warn!("A page could not be answered: {self}.");
        }
        (status, page::error(status, &self.to_string())).into_response()
    }
}
