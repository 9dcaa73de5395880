//! The JSON body of a request of a program.

use axum::{
    body::to_bytes,
    extract::{FromRequest, Request},
    http::{StatusCode, header},
};
use serde::de::DeserializeOwned;

use super::error::HandlerError;

/// Largest body of a program's request that brings no file, bytes.
pub(crate) const MAX_JSON_BYTES: usize = 1 << 20;

/// A body in JSON; nothing at all is an empty object. What is wrong with it is told.
pub(crate) struct JsonBody<T>(pub(crate) T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for JsonBody<T> {
    type Rejection = HandlerError;

    async fn from_request(request: Request, _: &S) -> Result<Self, HandlerError> {
        let refused = |status, text: String| HandlerError::Refused(status, text);
        let kind = request.headers().get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok());
        let is_json = kind.is_some_and(|kind| kind.starts_with("application/json"));
        let body = to_bytes(request.into_body(), MAX_JSON_BYTES).await;
        let body = body.map_err(|error| refused(StatusCode::PAYLOAD_TOO_LARGE, error.to_string()))?;
        let body = if body.is_empty() { &b"{}"[..] } else { &body };
        // A page of another site cannot send this type unasked.
        if body != b"{}" && !is_json {
            return Err(refused(StatusCode::UNSUPPORTED_MEDIA_TYPE, "send application/json".to_owned()));
        }
        let wrong =
            |error| refused(StatusCode::UNPROCESSABLE_ENTITY, format!("the request cannot be understood: {error}"));
        serde_json::from_slice(body).map(Self).map_err(wrong)
    }
}
