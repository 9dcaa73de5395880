//! The language of an answer: pages are in that of the browser, what programs read is English.

use std::sync::Arc;

use axum::{
    extract::{Request, State},
    http::{HeaderMap, HeaderValue, header},
    middleware::Next,
    response::Response,
};
use language::Language;

use crate::web::core::state::DashboardState;

/// Addresses below which programs ask.
const OF_PROGRAMS: [&str; 6] = ["/api/", "/assets/", "/content/", "/metrics", "/healthz", "/readyz"];
/// Endings of files that programs read.
const FILES_OF_PROGRAMS: [&str; 2] = [".json", ".csv"];

/// Whether programs ask at an address.
pub(super) fn is_of_programs(path: &str) -> bool {
    OF_PROGRAMS.iter().any(|start| path.starts_with(start)) || FILES_OF_PROGRAMS.iter().any(|end| path.ends_with(end))
}

/// Answers a request in its language.
pub(super) async fn speak(State(web): State<Arc<DashboardState>>, request: Request, next: Next) -> Response {
    let path = request.uri().path();
    if is_of_programs(path) {
        return next.run(request).await;
    }
    let language = language_of(request.headers()).unwrap_or(web.current_settings().language);
    let mut response = language.scope(next.run(request)).await;
    response.headers_mut().append(header::VARY, HeaderValue::from_static("accept-language"));
    response
}

/// The language that a browser asks for; `None` = none of those that are known.
fn language_of(headers: &HeaderMap) -> Option<Language> {
    let texts: Vec<&str> =
        headers.get_all(header::ACCEPT_LANGUAGE).iter().filter_map(|value| value.to_str().ok()).collect();
    Language::accepted(&texts.join(","))
}
