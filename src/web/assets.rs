//! Styles and scripts, embedded in the binary.

use axum::{
    extract::Path,
    http::header,
    response::{IntoResponse, Response},
};

use super::error::HandlerError;

const ASSETS: [(&str, &str, &[u8]); 4] = [
    ("style.css", "text/css; charset=utf-8", include_bytes!("assets/style.css")),
    ("live.js", "text/javascript; charset=utf-8", include_bytes!("assets/live.js")),
    ("view.js", "text/javascript; charset=utf-8", include_bytes!("assets/view.js")),
    ("icon.svg", "image/svg+xml", include_bytes!("assets/icon.svg")),
];

/// Returns an asset by name.
pub(super) async fn get_asset(Path(name): Path<String>) -> Result<Response, HandlerError> {
    let found = ASSETS.iter().find(|(known, _, _)| *known == name);
    let (_, kind, bytes) = found.ok_or_else(|| HandlerError::NotFound(format!("asset {name}")))?;
    Ok(([(header::CONTENT_TYPE, *kind), (header::CACHE_CONTROL, "no-cache")], *bytes).into_response())
}
