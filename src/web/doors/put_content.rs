//! Files that programs put before they order copies of them. They are written to disk as they arrive.

use std::sync::Arc;

use anyhow::Context;
use axum::{
    Json,
    body::{Body, Bytes},
    extract::{Path, State},
    http::{HeaderMap, StatusCode, header},
    response::{IntoResponse, Response},
};
use intake::{ArrivingContent, PutContents, PutError, StoredFile, is_content_hash};
use schemars::JsonSchema;
use serde::Serialize;
use tokio::sync::OwnedSemaphorePermit;
use tokio_stream::{Stream, StreamExt};

use crate::web::{
    base::{
        client_limits::{BytesUnderWay, ClientPlace},
        error::{HandlerError, HandlerResult},
    },
    clients::client::RequestClient,
    core::{command::check_takes_orders, state::DashboardState},
};

/// A file that the farm has.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "Content")]
pub(crate) struct ContentResource {
    /// BLAKE3 of the file, 64 hex digits.
    pub(crate) content: String,
    /// Its size.
    pub(crate) bytes: u64,
}

impl From<StoredFile> for ContentResource {
    fn from(stored: StoredFile) -> Self {
        Self { content: stored.hash, bytes: stored.bytes }
    }
}

/// Tells whether a file is there, so that it need not be put again.
pub(super) async fn get_put_content(
    State(web): State<Arc<DashboardState>>,
    Path(hash): Path<String>,
) -> HandlerResult<Json<ContentResource>> {
    let hash = require_hash(&hash)?;
    let found = find_content(&web, hash).await?;
    let missing = || HandlerError::NotFound(format!("content {hash}"));
    Ok(Json(found.ok_or_else(missing)?.into()))
}

/// Takes a file whose BLAKE3 the address names. To put it again changes nothing.
pub(crate) async fn put_content(
    State(web): State<Arc<DashboardState>>,
    Path(hash): Path<String>,
    client: RequestClient,
    headers: HeaderMap,
    body: Body,
) -> HandlerResult<Response> {
    check_takes_orders(&web)?;
    let hash = require_hash(&hash)?;
    if let Some(found) = find_own_content(&web, hash).await? {
        return Ok(Json(ContentResource::from(found)).into_response());
    }
    let _place = take_place(&web, &client)?;
    let announced = announced_bytes(&headers);
    let mut under_way = web.limits.begin_bytes(&client.counted_as, announced, 0)?;
    let stored =
        receive_content(&web, body.into_data_stream(), &mut under_way, announced, Some(hash.to_owned())).await?;
    Ok((StatusCode::CREATED, Json(ContentResource::from(stored))).into_response())
}

/// Takes a file, and says its BLAKE3.
pub(super) async fn post_content(
    State(web): State<Arc<DashboardState>>,
    client: RequestClient,
    headers: HeaderMap,
    body: Body,
) -> HandlerResult<Response> {
    check_takes_orders(&web)?;
    let _place = take_place(&web, &client)?;
    let announced = announced_bytes(&headers);
    let mut under_way = web.limits.begin_bytes(&client.counted_as, announced, 0)?;
    let stored = receive_content(&web, body.into_data_stream(), &mut under_way, announced, None).await?;
    Ok((StatusCode::CREATED, Json(ContentResource::from(stored))).into_response())
}

fn require_hash(hash: &str) -> HandlerResult<&str> {
    let text = || format!("'{hash}' is no BLAKE3: 64 digits of 0-9 and a-f");
    is_content_hash(hash).then_some(hash).ok_or_else(|| HandlerError::Refused(StatusCode::BAD_REQUEST, text()))
}

/// How many bytes a request says that it brings, 0 = it does not say.
pub(super) fn announced_bytes(headers: &HeaderMap) -> u64 {
    let length = headers.get(header::CONTENT_LENGTH).and_then(|value| value.to_str().ok());
    length.and_then(|length| length.parse().ok()).unwrap_or(0)
}

/// Where the files are that were put.
pub(crate) fn put_contents(web: &DashboardState) -> PutContents {
    PutContents::of_farm(&web.current_settings().state_dir)
}

/// The file with this BLAKE3 on this node, which is kept from now on as if it was just put.
async fn find_own_content(web: &DashboardState, hash: &str) -> HandlerResult<Option<StoredFile>> {
    let (contents, hash) = (put_contents(web), hash.to_owned());
    run_on_disk(move || Ok(contents.use_content(&hash)?)).await
}

/// The same; a file that was put on another node is brought here.
pub(super) async fn find_content(web: &DashboardState, hash: &str) -> HandlerResult<Option<StoredFile>> {
    if let Some(found) = find_own_content(web, hash).await? {
        return Ok(Some(found));
    }
    match farm::fetch_put_content(&web.current_settings(), &web.ledger, hash).await? {
        true => find_own_content(web, hash).await,
        false => Ok(None),
    }
}

/// A place for a file that arrives, until it is dropped.
pub(crate) struct FilePlace {
    _of_all: OwnedSemaphorePermit,
    _of_client: ClientPlace,
}

/// One of the places for files that arrive at the same time, of which one client may hold some.
pub(super) fn take_place(web: &DashboardState, client: &RequestClient) -> HandlerResult<FilePlace> {
    let of_client = web.limits.begin_file(&client.counted_as)?;
    let busy = |_| HandlerError::TooMany(1, "others are sending files just now: try again in a moment".to_owned());
    let of_all = web.upload_slots.clone().try_acquire_owned().map_err(busy)?;
    Ok(FilePlace { _of_all: of_all, _of_client: of_client })
}

/// Refuses a request for which the disk has no room.
pub(super) async fn require_room(web: &DashboardState, bytes: u64) -> HandlerResult<()> {
    let contents = put_contents(web);
    run_on_disk(move || {
        contents.create_folder()?;
        contents.check_room(bytes, u64::MAX)
    })
    .await
}

/// Receives a file as it comes, and keeps it under its BLAKE3. `announced` = its size, 0 = not said.
pub(super) async fn receive_content<E: std::fmt::Display>(
    web: &DashboardState,
    chunks: impl Stream<Item = Result<Bytes, E>> + Unpin,
    under_way: &mut BytesUnderWay,
    announced: u64,
    expected: Option<String>,
) -> HandlerResult<StoredFile> {
    let file = receive_file(web, chunks, under_way, announced).await?;
    run_on_disk(move || file.finish_content(expected.as_deref())).await
}

/// Receives a file as it comes. It is removed when it is dropped.
pub(crate) async fn receive_file<E: std::fmt::Display>(
    web: &DashboardState,
    mut chunks: impl Stream<Item = Result<Bytes, E>> + Unpin,
    under_way: &mut BytesUnderWay,
    announced: u64,
) -> HandlerResult<ArrivingContent> {
    let (contents, max_bytes) = (put_contents(web), web.current_settings().limits.max_bytes);
    let token = rand::random();
    let mut file = run_on_disk(move || contents.begin_content(token, announced, max_bytes)).await?;
    while let Some(chunk) = chunks.next().await {
        let chunk = chunk.map_err(|error| incomplete_body(&error))?;
        under_way.count_received(chunk.len() as u64)?;
        file = run_on_disk(move || file.write_chunk(&chunk).map(|()| file)).await?;
    }
    Ok(file)
}

/// The body of a request ended before it was complete.
pub(super) fn incomplete_body(error: &impl std::fmt::Display) -> HandlerError {
    HandlerError::Refused(StatusCode::BAD_REQUEST, format!("the file did not arrive as a whole: {error}"))
}

/// Runs what writes to the disk where it holds up no other request.
pub(crate) async fn run_on_disk<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, PutError> + Send + 'static,
) -> HandlerResult<T> {
    let done = tokio::task::spawn_blocking(work).await.context("a step ended")?;
    done.map_err(|error| {
        let status = match error {
            PutError::TooLarge { .. } => StatusCode::PAYLOAD_TOO_LARGE,
            PutError::OtherContent { .. } | PutError::TooLong { .. } => StatusCode::UNPROCESSABLE_ENTITY,
            PutError::NoRoom { .. } | PutError::Write(_) => StatusCode::INSUFFICIENT_STORAGE,
        };
        HandlerError::Refused(status, error.to_string())
    })
}
