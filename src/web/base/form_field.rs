//! Fields of forms with files, which are received as they come.

use axum::extract::multipart::{Field, MultipartError};

use super::error::{HandlerError, HandlerResult};

/// A form did not arrive as a whole, or is none.
pub(crate) fn incomplete_form(error: MultipartError) -> HandlerError {
    HandlerError::Refused(error.status(), format!("the request did not arrive as a whole: {}", error.body_text()))
}

/// A field without a file.
///
/// # Errors
/// `Refused` when it is longer, or did not arrive as a whole.
pub(crate) async fn read_field(mut field: Field<'_>, max_bytes: usize) -> HandlerResult<Vec<u8>> {
    let mut bytes = Vec::new();
    while let Some(chunk) = field.chunk().await.map_err(incomplete_form)? {
        bytes.extend_from_slice(&chunk);
        if bytes.len() > max_bytes {
            let text = format!("the field {} has more than {max_bytes} bytes", field.name().unwrap_or_default());
            return Err(HandlerError::Refused(axum::http::StatusCode::PAYLOAD_TOO_LARGE, text));
        }
    }
    Ok(bytes)
}
