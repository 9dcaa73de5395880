//! What a page answers when it cannot answer.

use axum::{
    Json,
    http::StatusCode,
    response::{IntoResponse, Response},
};

use schemars::JsonSchema;
use serde::Serialize;

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
        let text = self.to_string();
        let mut response = (status, page::error(status, &text)).into_response();
        response.extensions_mut().insert(Why(text));
        response
    }
}

/// What a response says is wrong, for who puts it into another form.
#[derive(Debug, Clone)]
struct Why(String);

/// What the JSON interface answers when it cannot answer.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Error")]
pub(super) struct ApiError {
    /// What is wrong.
    error: String,
}

/// An answer that tells an error, in the form that is expected at an address: JSON below `/api/`, else a page.
pub(super) fn in_form(response: Response, path: &str) -> Response {
    let status = response.status();
    if !status.is_client_error() && !status.is_server_error() {
        return response;
    }
    let why = response.extensions().get::<Why>().map(|why| why.0.clone());
    if path.starts_with("/api/") {
        let reason = || status.canonical_reason().unwrap_or("error").to_lowercase();
        return (status, Json(ApiError { error: why.unwrap_or_else(reason) })).into_response();
    }
    // Of the library, in one line of plain text: an address whose number is none, a form that is none.
    if why.is_none() && status.is_client_error() {
        return (status, page::error(status, "This address or this form cannot be understood")).into_response();
    }
    response
}
