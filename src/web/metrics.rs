//! `/metrics` and `/readyz`: what watches the farm from outside asks here.

use std::sync::Arc;

use axum::{
    extract::State,
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};

use super::{problem::Answer, state::Web};
use crate::metrics::CONTENT_TYPE;

/// The metrics.
pub(super) async fn metrics(State(web): State<Arc<Web>>) -> Answer<Response> {
    let text = web.metrics.text(&web.ledger, &web.settings()).await?;
    Ok(([(header::CONTENT_TYPE, CONTENT_TYPE)], text).into_response())
}

/// Whether the ledger answers, the daemon beats and every folder is there.
pub(super) async fn readyz(State(web): State<Arc<Web>>) -> Answer<Response> {
    let daemon = web.ledger.daemon().await?;
    let settings = web.settings();
    let gone: Vec<String> = settings
        .folders()
        .iter()
        .filter(|folder| !folder.is_dir())
        .map(|f| format!("{} is not there\n", f.display()))
        .collect();
    Ok(match (daemon.is_some_and(|d| d.alive && !d.is_silent(jiff::Timestamp::now())), gone.is_empty()) {
        (true, true) => "ready\n".into_response(),
        (false, _) => (StatusCode::SERVICE_UNAVAILABLE, "the daemon does not run, or cannot write into the ledger\n")
            .into_response(),
        (true, false) => (StatusCode::SERVICE_UNAVAILABLE, gone.concat()).into_response(),
    })
}
