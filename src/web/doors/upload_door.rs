//! Uploads that may be cut and go on: tus 1.0, core, creation, expiration and termination (<https://tus.io/protocols/resumable-upload>). A
//! complete upload is a content that lines can order, and tells its BLAKE3.

use std::{sync::Arc, time::SystemTime};

use axum::{
    Json,
    body::Body,
    extract::{Path, State},
    http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header},
    response::{IntoResponse, Response},
};
use base64::Engine;
use intake::{PutUploads, UPLOAD_KEPT, UploadRecord, UploadState, is_content_hash, is_upload_id};
use schemars::JsonSchema;
use serde::Serialize;
use tokio::sync::{OwnedMutexGuard, watch};
use tokio_stream::StreamExt;

use super::put_content::{incomplete_body, put_contents, run_on_disk, take_place};
use crate::web::{
    base::error::{HandlerError, HandlerResult},
    clients::client::RequestClient,
    core::{command::check_takes_orders, state::DashboardState},
};

/// The version that is spoken.
const TUS_VERSION: HeaderValue = HeaderValue::from_static("1.0.0");
const TUS_EXTENSIONS: HeaderValue = HeaderValue::from_static("creation,expiration,termination");
/// Unfinished uploads that one client may have.
const MAX_UNFINISHED: usize = 100;
/// When to ask again for one more, s.
const UNFINISHED_SECS: u64 = 60;

/// A turn at an upload. What works on the disk holds it as well, so that nothing is written after the next turn has begun.
type SharedTurn = Arc<OwnedMutexGuard<()>>;

/// An upload as it stands.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct UploadResource {
    /// Bytes that have arrived.
    offset: u64,
    /// All bytes of the file.
    length: u64,
    /// BLAKE3 of the file once it is complete: the content that lines can order.
    content: Option<String>,
}

fn refused(status: StatusCode, text: impl Into<String>) -> HandlerError {
    HandlerError::Refused(status, text.into())
}

fn uploads_of(web: &DashboardState) -> PutUploads {
    PutUploads::new(put_contents(web))
}

fn text_header<'h>(headers: &'h HeaderMap, name: &str) -> Option<&'h str> {
    headers.get(name).and_then(|value| value.to_str().ok())
}

fn number_header(headers: &HeaderMap, name: &str) -> HandlerResult<u64> {
    let number = text_header(headers, name).and_then(|text| text.parse().ok());
    number.ok_or_else(|| refused(StatusCode::BAD_REQUEST, format!("{name} must be a number of bytes")))
}

/// Refuses another version of the protocol, and whatever changes something where the farm takes no orders.
fn check_protocol(web: &DashboardState, headers: &HeaderMap) -> HandlerResult<()> {
    check_takes_orders(web)?;
    match headers.get("tus-resumable") == Some(&TUS_VERSION) {
        true => Ok(()),
        false => Err(refused(StatusCode::PRECONDITION_FAILED, "send Tus-Resumable: 1.0.0; the farm speaks tus 1.0.0")),
    }
}

fn tus_response(status: StatusCode, headers: &[(&'static str, String)]) -> Response {
    let mut response = status.into_response();
    response.headers_mut().insert("tus-resumable", TUS_VERSION);
    for (name, value) in headers {
        if let Ok(value) = HeaderValue::from_str(value) {
            response.headers_mut().insert(HeaderName::from_static(name), value);
        }
    }
    response
}

/// The headers that tell how far an upload is.
fn state_headers(upload: &UploadState) -> Vec<(&'static str, String)> {
    let mut headers =
        vec![("upload-offset", upload.offset.to_string()), ("upload-length", upload.record.length.to_string())];
    match &upload.record.content {
        Some(content) => headers.push(("nestd-content", content.clone())),
        None => headers.push(("upload-expires", expiry_text(upload.changed_at))),
    }
    headers
}

/// When an upload is given up of which no more comes, as HTTP writes times.
fn expiry_text(changed_at: SystemTime) -> String {
    let expires = jiff::Timestamp::try_from(changed_at + UPLOAD_KEPT).unwrap_or_else(|_| jiff::Timestamp::now());
    expires.strftime("%a, %d %b %Y %H:%M:%S GMT").to_string()
}

/// What the farm can do.
pub(super) async fn get_options(State(web): State<Arc<DashboardState>>) -> Response {
    let max_bytes = web.current_settings().limits.max_bytes;
    let mut response = tus_response(StatusCode::NO_CONTENT, &[("tus-max-size", max_bytes.to_string())]);
    response.headers_mut().insert("tus-version", TUS_VERSION);
    response.headers_mut().insert("tus-extension", TUS_EXTENSIONS);
    response
}

/// Begins an upload.
pub(super) async fn post_upload(
    State(web): State<Arc<DashboardState>>,
    client: RequestClient,
    headers: HeaderMap,
) -> HandlerResult<Response> {
    check_protocol(&web, &headers)?;
    let length = number_header(&headers, "upload-length")?;
    let expected = read_metadata(text_header(&headers, "upload-metadata").unwrap_or_default(), "blake3")?;
    if let Some(expected) = expected.as_ref().filter(|expected| !is_content_hash(expected)) {
        return Err(refused(StatusCode::BAD_REQUEST, format!("blake3 {expected:?} must be 64 digits of 0-9 and a-f")));
    }
    let record = UploadRecord { length, client: client.counted_as.clone(), expected, content: None };
    let (uploads, max_bytes) = (uploads_of(&web), web.current_settings().limits.max_bytes);
    let id = format!("{:032x}", rand::random::<u128>());
    let begun = id.clone();
    let begun_before = uploads.clone();
    let unfinished = run_on_disk(move || Ok(begun_before.list_unfinished()?)).await?;
    let of_client = unfinished.iter().filter(|upload| upload.record.client == client.counted_as);
    let lengths: Vec<u64> = of_client.map(|upload| upload.record.length).collect();
    if lengths.len() >= MAX_UNFINISHED {
        let text = format!("you have {MAX_UNFINISHED} unfinished uploads: finish some, or give them up");
        return Err(HandlerError::TooMany(UNFINISHED_SECS, text));
    }
    let on_disk = lengths.into_iter().fold(0, u64::saturating_add);
    web.limits.begin_bytes(&client.counted_as, length, on_disk)?;
    let upload = run_on_disk(move || {
        uploads.begin_upload(&begun, &record, max_bytes)?;
        // One of no bytes is complete.
        uploads.settle_upload(&begun)
    })
    .await?;
    let mut told = upload.as_ref().map(state_headers).unwrap_or_default();
    told.push(("location", format!("/api/v1/uploads/{id}")));
    Ok(tus_response(StatusCode::CREATED, &told))
}

/// A value of the header Upload-Metadata: `name base64, name base64`.
fn read_metadata(text: &str, wanted: &str) -> HandlerResult<Option<String>> {
    for pair in text.split(',') {
        let mut words = pair.split_whitespace();
        if words.next() == Some(wanted) {
            let decoded = base64::engine::general_purpose::STANDARD.decode(words.next().unwrap_or_default());
            let value = decoded.ok().and_then(|bytes| String::from_utf8(bytes).ok());
            let wrong =
                || refused(StatusCode::BAD_REQUEST, format!("{wanted} in Upload-Metadata is no text in base64"));
            return value.ok_or_else(wrong).map(Some);
        }
    }
    Ok(None)
}

/// How far an upload is. One that is complete and was cut before it had its name gets it now.
async fn settle(web: &DashboardState, id: &str, turn: &SharedTurn) -> HandlerResult<UploadState> {
    let (uploads, wanted, turn) = (uploads_of(web), id.to_owned(), turn.clone());
    let settled = run_on_disk(move || {
        let _turn = turn;
        uploads.settle_upload(&wanted)
    });
    settled.await?.ok_or_else(|| no_upload(id))
}

fn no_upload(id: &str) -> HandlerError {
    HandlerError::NotFound(format!("upload {id}: it may have expired"))
}

/// How far an upload is just now, while another request may send more of it.
async fn look_at(web: &DashboardState, id: &str) -> HandlerResult<UploadState> {
    if let Some(turn) = web.uploads.try_turn(id) {
        return settle(web, id, &Arc::new(turn)).await;
    }
    let (uploads, wanted) = (uploads_of(web), id.to_owned());
    run_on_disk(move || Ok(uploads.find_upload(&wanted)?)).await?.ok_or_else(|| no_upload(id))
}

/// The upload that an address names.
pub(crate) fn upload_of_path(path: &str) -> Option<&str> {
    path.strip_prefix("/api/v1/uploads/").filter(|id| is_upload_id(id))
}

/// Whether an upload is on this node.
pub(crate) async fn find_upload_here(web: &DashboardState, id: &str) -> HandlerResult<bool> {
    let (uploads, wanted) = (uploads_of(web), id.to_owned());
    Ok(run_on_disk(move || Ok(uploads.find_upload(&wanted)?)).await?.is_some())
}

fn require_id(id: &str) -> HandlerResult<()> {
    is_upload_id(id).then_some(()).ok_or_else(|| HandlerError::NotFound(format!("upload {id}")))
}

/// How far an upload is: as headers, and as JSON. GET only looks. HEAD is how clients begin to go on after a cut: it ends a request that
/// still sends, so that the offset stays what it says.
pub(super) async fn get_upload(
    State(web): State<Arc<DashboardState>>,
    Path(id): Path<String>,
    method: Method,
) -> HandlerResult<Response> {
    require_id(&id)?;
    let upload = match method {
        Method::HEAD => {
            let (turn, _) = web.uploads.take_turn(&id).await?;
            settle(&web, &id, &Arc::new(turn)).await?
        }
        _ => look_at(&web, &id).await?,
    };
    let (offset, length) = (upload.offset, upload.record.length);
    let resource = UploadResource { offset, length, content: upload.record.content.clone() };
    let mut response = Json(resource).into_response();
    response.headers_mut().extend(tus_response(StatusCode::OK, &state_headers(&upload)).headers().clone());
    Ok(response)
}

/// Takes more of an upload.
pub(super) async fn patch_upload(
    State(web): State<Arc<DashboardState>>,
    Path(id): Path<String>,
    client: RequestClient,
    headers: HeaderMap,
    body: Body,
) -> HandlerResult<Response> {
    check_protocol(&web, &headers)?;
    require_id(&id)?;
    if text_header(&headers, header::CONTENT_TYPE.as_str()) != Some("application/offset+octet-stream") {
        return Err(refused(StatusCode::UNSUPPORTED_MEDIA_TYPE, "send application/offset+octet-stream"));
    }
    let offset = number_header(&headers, "upload-offset")?;
    let (turn, comes) = web.uploads.take_turn(&id).await?;
    let turn = Arc::new(turn);
    let upload = settle(&web, &id, &turn).await?;
    if offset != upload.offset {
        let text = format!("{} bytes of it have arrived, not {offset}: ask with HEAD, and go on there", upload.offset);
        return Err(refused(StatusCode::CONFLICT, text));
    }
    if upload.record.content.is_none() {
        let _place = take_place(&web, &client)?;
        append_body(&web, &id, upload.record.length - offset, body, (&turn, comes)).await?;
    }
    let upload = settle(&web, &id, &turn).await?;
    Ok(tus_response(StatusCode::NO_CONTENT, &state_headers(&upload)))
}

/// Writes what comes, until it ends, is cut, or another request comes for the same upload.
async fn append_body(
    web: &DashboardState,
    id: &str,
    mut left: u64,
    body: Body,
    (turn, mut comes): (&SharedTurn, watch::Receiver<u64>),
) -> HandlerResult<()> {
    let (uploads, wanted) = (uploads_of(web), id.to_owned());
    let mut part = run_on_disk(move || Ok(uploads.open_part(&wanted)?)).await?;
    let mut chunks = body.into_data_stream();
    let mut cut = None;
    loop {
        let chunk = tokio::select! {
            chunk = chunks.next() => chunk,
            _ = comes.changed() => {
                cut = Some(refused(StatusCode::CONFLICT, "another request goes on with this upload"));
                break;
            }
        };
        match chunk {
            None => break,
            Some(Err(error)) => {
                cut = Some(incomplete_body(&error));
                break;
            }
            Some(Ok(chunk)) if chunk.len() as u64 > left => {
                cut = Some(refused(StatusCode::PAYLOAD_TOO_LARGE, "more bytes come than Upload-Length said"));
                break;
            }
            Some(Ok(chunk)) => {
                left -= chunk.len() as u64;
                let turn = turn.clone();
                part = run_on_disk(move || {
                    let _turn = turn;
                    part.append_bytes(&chunk).map(|()| part)
                })
                .await?;
            }
        }
    }
    run_on_disk(move || Ok(part.sync_bytes()?)).await?;
    cut.map_or(Ok(()), Err)
}

/// Gives an upload up.
pub(super) async fn delete_upload(
    State(web): State<Arc<DashboardState>>,
    Path(id): Path<String>,
    headers: HeaderMap,
) -> HandlerResult<Response> {
    check_protocol(&web, &headers)?;
    require_id(&id)?;
    let (turn, _) = web.uploads.take_turn(&id).await?;
    let turn = Arc::new(turn);
    settle(&web, &id, &turn).await?;
    let uploads = uploads_of(&web);
    run_on_disk(move || {
        let _turn = turn;
        Ok(uploads.remove_upload(&id)?)
    })
    .await?;
    Ok(tus_response(StatusCode::NO_CONTENT, &[]))
}
