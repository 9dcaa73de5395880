//! Sends styles and scripts.

use anyhow::Context;
use axum::{extract::Path, http::HeaderMap, response::Response};
use serde::Deserialize;

use crate::web::base::{
    assets::find_asset,
    error::{HandlerError, HandlerResult},
    query::Query,
};

/// The version that a page asks for.
#[derive(Debug, Deserialize)]
pub(crate) struct AssetQuery {
    #[serde(default)]
    v: String,
}

/// Returns an asset by name.
pub(super) async fn get_asset(
    Path(name): Path<String>,
    Query(asked): Query<AssetQuery>,
    headers: HeaderMap,
) -> HandlerResult<Response> {
    let (kind, body) = find_asset(&name).ok_or_else(|| HandlerError::NotFound(format!("asset {name}")))?;
    let keep = if asked.v == body.version() { "private, max-age=31536000, immutable" } else { "private, no-cache" };
    Ok(body.answer(&headers, kind, keep).context("sending an asset")?)
}
