//! How a request arrives: as a whole, within the time of a request, before it is answered; or, where it brings files, while it is answered.

use axum::{
    body::{Body, to_bytes},
    extract::{ConnectInfo, Request},
    http::{Method, StatusCode, header},
    middleware::Next,
    response::{IntoResponse, Response},
};
use tokio_stream::StreamExt;

use super::api_routes::find_route;
use crate::web::base::{api_body::MAX_JSON_BYTES, connection_limits::RequestInProgress, error::HandlerError};

/// Largest request body of a page without files, bytes.
pub(crate) const MAX_BODY_BYTES: usize = 4096;

/// Whether a request brings files: to the form that adds them to a machine, or to an address of the interface that takes some.
pub(crate) fn brings_files(request: &Request) -> bool {
    let (method, path) = (request.method(), request.uri().path());
    let kind = request.headers().get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok()).unwrap_or_default();
    match find_route(method, path) {
        Some(route) => route.body.brings_files(kind),
        None => *method == Method::POST && path.starts_with("/machines/") && path.ends_with("/files"),
    }
}

/// Receives the whole request while the timeout of its connection runs, then answers it without that timeout. Files are received by
/// whoever answers.
pub(crate) async fn buffer_then_answer(request: Request, next: Next) -> Response {
    let has_files = brings_files(&request);
    let is_short = matches!(*request.method(), Method::GET | Method::HEAD);
    let progress = request.extensions().get::<ConnectInfo<RequestInProgress>>().map(|info| info.0.clone());
    let (head, mut body) = request.into_parts();
    if has_files {
        body = noting_its_end(body, progress.clone().unwrap_or_default());
    } else if !is_short {
        let most = if head.uri.path().starts_with("/api/") { MAX_JSON_BYTES } else { MAX_BODY_BYTES };
        let Ok(bytes) = to_bytes(body, most).await else {
            let text = "the form is too long, or did not arrive as a whole".to_owned();
            return HandlerError::Refused(StatusCode::PAYLOAD_TOO_LARGE, text).into_response();
        };
        body = Body::from(bytes);
    }
    let _at_work = progress.map(|progress| progress.begin_answer(has_files));
    next.run(Request::from_parts(head, body)).await
}

/// The same body. When its last byte was read, the request counts as complete: to hash, judge and move files may take longer than a
/// connection may be silent.
fn noting_its_end(body: Body, progress: RequestInProgress) -> Body {
    let end = tokio_stream::once(()).filter_map(move |()| {
        progress.note_complete();
        None
    });
    Body::from_stream(body.into_data_stream().chain(end))
}
