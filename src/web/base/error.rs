//! Errors of request handlers, and the responses that show them.

use axum::{
    Json,
    http::{HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};
use language::say;
use ledger::LedgerError;
use maud::Markup;
use schemars::JsonSchema;
use serde::Serialize;

use super::page;

/// Why a request failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum HandlerError {
    /// There is nothing of that name or number.
    #[error("{}", there_is_no(.0))]
    NotFound(String),
    /// The request is invalid or forbidden.
    #[error("{1}")]
    Refused(StatusCode, String),
    /// The client asks too much; it may ask again after this many seconds.
    #[error("{1}")]
    TooMany(u64, String),
    /// Some of what was asked is refused; the rest is done, or noted.
    #[error("{}", not_all_done(done, refused))]
    NotAllDone { done: Vec<String>, refused: Vec<String> },
    /// The ledger does not answer.
    #[error(transparent)]
    Ledger(#[from] LedgerError),
    /// Something else failed.
    #[error("{0:#}")]
    Failed(#[from] anyhow::Error),
}

fn there_is_no(what: &str) -> String {
    say!("there-is-no", what = what)
}

fn not_all_done(done: &[String], refused: &[String]) -> String {
    match done.is_empty() {
        true => refused.join("\n"),
        false => {
            say!("refused-but-done", refused = refused.join(" "))
                + "\n"
                + &say!("done-all-the-same", done = done.join(" "))
        }
    }
}

/// The result of a request handler.
pub(crate) type HandlerResult<T> = Result<T, HandlerError>;

impl HandlerError {
    pub(crate) fn status_code(&self) -> StatusCode {
        match self {
            Self::NotFound(_) => StatusCode::NOT_FOUND,
            Self::Refused(status, _) => *status,
            Self::TooMany(..) => StatusCode::TOO_MANY_REQUESTS,
            Self::NotAllDone { .. } => StatusCode::CONFLICT,
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
        if let Self::TooMany(secs, _) = self {
            response.headers_mut().insert(header::RETRY_AFTER, secs.into());
        }
        let (done, refused) = match self {
            Self::NotAllDone { done, refused } => (done, refused),
            _ => Default::default(),
        };
        response.extensions_mut().insert(ErrorMessage { text, done, refused });
        response
    }
}

/// The error text of a response, kept so that [`format_error_response`] can put it into another format.
#[derive(Debug, Clone)]
struct ErrorMessage {
    text: String,
    done: Vec<String>,
    refused: Vec<String>,
}

/// A page of its own that says why a request is refused.
pub(crate) fn page_with_status(status: StatusCode, text: String, page: Markup) -> Response {
    let mut response = (status, page).into_response();
    response.extensions_mut().insert(ErrorMessage { text, done: Vec::new(), refused: Vec::new() });
    response
}

/// What programs are answered when they cannot be answered: application/problem+json (RFC 9457).
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Problem")]
pub(crate) struct ProblemDetails {
    /// about:blank: the status says what kind of problem it is.
    r#type: &'static str,
    /// The status in words.
    title: &'static str,
    /// The status.
    status: u16,
    /// What is wrong, in whole sentences where a file is refused: as its reason file would say it.
    detail: String,
    /// Where several parts were to be changed and not all could be: what was done all the same, a sentence each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    done: Vec<String>,
    /// And what was refused, a sentence each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    refused: Vec<String>,
}

/// An answer of another node, which is in its format already.
#[derive(Debug, Clone)]
pub(crate) struct AnsweredElsewhere;

/// Puts an error response into the format of its address: problem+json below `/api/`, else a page.
pub(crate) fn format_error_response(mut response: Response, path: &str) -> Response {
    let status = response.status();
    let is_error = status.is_client_error() || status.is_server_error();
    if !is_error || response.extensions().get::<AnsweredElsewhere>().is_some() {
        return response;
    }
    let why = response.extensions().get::<ErrorMessage>().cloned();
    if path.starts_with("/api/") {
        let title = status.canonical_reason().unwrap_or("Error");
        let plain = || ErrorMessage { text: title.to_lowercase(), done: Vec::new(), refused: Vec::new() };
        let ErrorMessage { text: detail, done, refused } = why.unwrap_or_else(plain);
        let problem = ProblemDetails { r#type: "about:blank", title, status: status.as_u16(), detail, done, refused };
        let mut told = (status, Json(problem)).into_response();
        told.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        // Such as when to ask again, and where an upload is.
        told.headers_mut().extend(response.headers_mut().drain().filter_map(|(name, value)| {
            let name = name.filter(|name| *name == header::RETRY_AFTER || *name == header::ALLOW)?;
            Some((name, value))
        }));
        return told;
    }
    // The error comes from axum, as one line of plain text: a number in the address or a form that cannot be parsed.
    if why.is_none() && status.is_client_error() {
        return (status, page::error_page(status, &say!("not-understood"))).into_response();
    }
    response
}
