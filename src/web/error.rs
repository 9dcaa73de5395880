//! Errors of request handlers, and the responses that show them.

use axum::{
    Json,
    http::StatusCode,
    response::{IntoResponse, Response},
};

use schemars::JsonSchema;
use serde::Serialize;

use super::page;
use crate::ledger::LedgerError;

/// Why a request failed.
#[derive(Debug, thiserror::Error)]
pub(super) enum HandlerError {
    /// There is nothing of that name or number.
    #[error("there is no {0}")]
    NotFound(String),
    /// The request is invalid or forbidden.
    #[error("{1}")]
    Refused(StatusCode, String),
    /// The ledger does not answer.
    #[error(transparent)]
    Ledger(#[from] LedgerError),
    /// Something else failed.
    #[error("{0:#}")]
    Failed(#[from] anyhow::Error),
}

/// The result of a request handler.
pub(super) type HandlerResult<T> = Result<T, HandlerError>;

impl HandlerError {
    pub(super) fn status_code(&self) -> StatusCode {
        match self {
            Self::NotFound(_) => StatusCode::NOT_FOUND,
            Self::Refused(status, _) => *status,
            Self::Ledger(_) => StatusCode::SERVICE_UNAVAILABLE,
            Self::Failed(_) => StatusCode::INTERNAL_SERVER_ERROR,
        }
    }
}

impl IntoResponse for HandlerError {
    fn into_response(self) -> Response {
        let status = self.status_code();
        if status.is_server_error() {
            tracing::warn!("A page could not be answered: {self}.");
        }
        let text = self.to_string();
        let mut response = (status, page::error_page(status, &text)).into_response();
        response.extensions_mut().insert(ErrorMessage(text));
        response
    }
}

/// The error text of a response, kept so that [`in_form`] can put it into another format.
#[derive(Debug, Clone)]
struct ErrorMessage(String);

/// What the JSON interface answers when it cannot answer.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Error")]
pub(super) struct ApiError {
    /// What is wrong.
    error: String,
}

/// Puts an error response into the format of its address: JSON below `/api/`, else a page.
pub(super) fn format_error_response(response: Response, path: &str) -> Response {
    let status = response.status();
    if !status.is_client_error() && !status.is_server_error() {
        return response;
    }
    let why = response.extensions().get::<ErrorMessage>().map(|why| why.0.clone());
    if path.starts_with("/api/") {
        let reason = || status.canonical_reason().unwrap_or("error").to_lowercase();
        return (status, Json(ApiError { error: why.unwrap_or_else(reason) })).into_response();
    }
    // The error comes from axum, as one line of plain text: a number in the address or a form that cannot be parsed.
    if why.is_none() && status.is_client_error() {
        return (status, page::error_page(status, "This address or this form cannot be understood")).into_response();
    }
    response
}
