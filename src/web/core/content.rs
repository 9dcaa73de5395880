//! What the other nodes of the farm ask: the contents of parts, and what is seen in the queues of a machine.

use std::{io::Read, path::Path as FilePath, sync::Arc};

use anyhow::Context;
use axum::{
    Json,
    body::{Body, Bytes},
    extract::{Path, State},
    http::{HeaderMap, HeaderValue, header},
    response::{IntoResponse, Response},
};
use ledger::SeenFile;
use serde::Deserialize;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;

use super::{cached_render::find_build, state::DashboardState};
use crate::web::base::{
    error::{HandlerError, HandlerResult},
    query::Query,
};

/// Bytes that are read at once.
const CHUNK_BYTES: usize = 1 << 18;
/// Chunks that wait for a slow receiver.
pub(crate) const CHUNKS_AHEAD: usize = 4;

/// The file whose BLAKE3 this is, from the store or an archive of this node.
pub(crate) async fn get_content(
    State(web): State<Arc<DashboardState>>,
    Path(hash): Path<String>,
) -> HandlerResult<Response> {
    let found = farm::find_kept_content(&web.current_settings(), &web.ledger, &hash).await?;
    let path = found.ok_or_else(|| HandlerError::NotFound(format!("file with the BLAKE3 {hash} on this node")))?;
    let kind = HeaderValue::from_static("application/octet-stream");
    stream_file(&path, [(header::CONTENT_TYPE, kind)].into_iter().collect())
}

/// How another node asks where the file of a build is.
#[derive(Debug, Deserialize)]
pub(crate) struct SeenQuery {
    /// Whether the outcome of its print is being told.
    outcome: bool,
}

/// What this node sees of the file of a build in the queues of its machine, for a word that is said on another node.
pub(crate) async fn get_seen_file(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    Query(query): Query<SeenQuery>,
) -> HandlerResult<Json<Option<SeenFile>>> {
    let (build, _) = find_build(&web, number).await?;
    Ok(Json(farm::see_own_file(&web.ledger, &web.current_settings(), build, query.outcome).await?))
}

/// Answers with a file, piece by piece.
pub(crate) fn stream_file(path: &FilePath, mut headers: HeaderMap) -> HandlerResult<Response> {
    let opened = std::fs::File::open(path).and_then(|file| Ok((file.metadata()?.len(), file)));
    let (bytes, file) = opened.with_context(|| format!("opening {}", path.display()))?;
    headers.insert(header::CONTENT_LENGTH, bytes.into());
    let (send, chunks) = mpsc::channel(CHUNKS_AHEAD);
    tokio::task::spawn_blocking(move || send_pieces(file, &send));
    Ok((headers, Body::from_stream(ReceiverStream::new(chunks))).into_response())
}

/// Sends what is read, piece by piece, as long as somebody receives it. It blocks its thread.
pub(crate) fn send_pieces(mut source: impl Read, send: &mpsc::Sender<std::io::Result<Bytes>>) {
    loop {
        let mut chunk = vec![0; CHUNK_BYTES];
        let read = source.read(&mut chunk);
        let is_last = !matches!(read, Ok(1..));
        let chunk = read.map(|count| {
            chunk.truncate(count);
            Bytes::from(chunk)
        });
        // The receiver may have gone.
        if send.blocking_send(chunk).is_err() || is_last {
            return;
        }
    }
}
