//! `/metrics` and `/readyz`, for external monitoring.

use std::sync::Arc;

use axum::{
    extract::State,
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};

use crate::{
    metrics::CONTENT_TYPE,
    web::{base::error::HandlerResult, core::state::DashboardState},
};

/// The metrics.
pub(super) async fn get_metrics(State(web): State<Arc<DashboardState>>) -> HandlerResult<Response> {
    let text = web.metrics.render_text(&web.ledger, &web.current_settings()).await?;
    Ok(([(header::CONTENT_TYPE, CONTENT_TYPE)], text).into_response())
}

/// Readiness: the ledger answers, the daemon's heartbeat is recent and every folder exists.
pub(super) async fn get_readiness(State(web): State<Arc<DashboardState>>) -> HandlerResult<Response> {
    let daemon = web.ledger.find_node(&web.current_settings().node.name).await?;
    let settings = web.current_settings();
    let gone: Vec<String> = settings
        .all_folders()
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
