//! Quotes for programs: when parts could be done that nobody has ordered yet. The files that come with a request are removed again, and
//! nothing else is changed.

use std::{
    collections::HashMap,
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::Context;
use axum::{
    Json,
    extract::{FromRequest, Multipart, Request, State, multipart::Field},
    http::{StatusCode, header},
};
use farm::{
    MaterialReading, OrderQuote, QUOTE_SEARCH_TIME, QuoteError, QuoteQuestion, QuotedFile, quote_order, read_plan,
    read_quoted_files,
};
use intake::{ArrivingContent, ContentStore, is_content_hash};
use jiff::Timestamp;
use settings::MachineProfile;

use super::{
    order_request::{LineRequest, MAX_LINES, OrderRequest, due_of},
    put_content::{announced_bytes, put_contents, receive_file, take_place},
};
use crate::web::{
    base::{
        client_limits::BytesUnderWay,
        connection_limits::RequestInProgress,
        error::{HandlerError, HandlerResult},
        form_field::{incomplete_form, read_field},
    },
    clients::client::RequestClient,
    core::state::DashboardState,
};

/// Quotes that are made at the same time.
pub(crate) const MAX_QUOTES: usize = 2;
/// Greatest length of the field `quote`, bytes.
const MAX_QUESTION_BYTES: usize = 1 << 20;
/// No quote is waited for any longer: large files take their time to be read.
const TIME_LIMIT: Duration = Duration::from_secs(20);

/// Files that came with a request, by name.
type QuoteFiles = HashMap<String, ArrivingContent>;

fn refused(status: StatusCode, text: impl ToString) -> HandlerError {
    HandlerError::Refused(status, text.to_string())
}

fn unprocessable(text: impl ToString) -> HandlerError {
    refused(StatusCode::UNPROCESSABLE_ENTITY, text)
}

/// Makes a quote for what would be ordered with the same JSON document, or with a form with such a document in its field `quote` and
/// files.
pub(super) async fn post_quote(
    State(web): State<Arc<DashboardState>>,
    client: RequestClient,
    progress: RequestInProgress,
    request: Request,
) -> HandlerResult<Json<OrderQuote>> {
    let busy = || HandlerError::TooMany(1, "other quotes are being made just now: ask again in a moment".to_owned());
    if web.quote_slots.available_permits() == 0 {
        return Err(busy());
    }
    let mut under_way = web.limits.begin_bytes(&client.counted_as, announced_bytes(request.headers()), 0)?;
    let kind = request.headers().get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let (asked, came) = if kind.starts_with("multipart/form-data") {
        let form =
            Multipart::from_request(request, &web).await.map_err(|error| refused(error.status(), error.body_text()))?;
        let _place = take_place(&web, &client)?;
        receive_form(&web, form, &mut under_way).await?
    } else {
        let body = Json::<OrderRequest>::from_request(request, &web).await;
        (body.map_err(|error| refused(error.status(), error.body_text()))?.0, QuoteFiles::new())
    };
    progress.note_complete();
    // Who sends slowly holds up no other quote.
    let place = web.quote_slots.clone().try_acquire_owned().map_err(|_| busy())?;
    let settings = web.current_settings();
    let profile = settings.profiles.get(&asked.machine).cloned().map(Arc::new);
    let profile = profile.ok_or_else(|| unprocessable(format!("there is no machine {}", asked.machine)))?;
    let (files, due_at) = find_files(&web, &profile, &asked, &came).await?;
    let now = Timestamp::now();
    let reading = read_plan(&web.ledger, &profile, now).await?;
    let materials = MaterialReading::read(&web.ledger, &settings.materials).await?;
    let (limits, meshes) = (settings.limits.clone(), web.quote_meshes.clone());
    let work = move || {
        let parts = read_quoted_files(&profile, &limits, &files, Some(Instant::now() + TIME_LIMIT), now);
        // They are in memory, or refused.
        drop(came);
        let parts = parts?;
        materials.ensure_loaded(&parts)?;
        let question = QuoteQuestion { parts, due_at, within: QUOTE_SEARCH_TIME };
        Ok(quote_order(&profile, &reading, question, &meshes, place, now))
    };
    let made = tokio::time::timeout(TIME_LIMIT, tokio::task::spawn_blocking(work)).await;
    let late = |_| refused(StatusCode::SERVICE_UNAVAILABLE, "it takes too long to read these files");
    match made.map_err(late)?.context("making a quote ended")? {
        Ok(quote) => Ok(Json(quote)),
        Err(QuoteError::Refused(reason)) => Err(unprocessable(reason.trim_end_matches('.'))),
        Err(QuoteError::AwaitsMaterial(why)) => Err(refused(StatusCode::CONFLICT, why)),
        Err(QuoteError::TryLater(why)) => Err(refused(StatusCode::SERVICE_UNAVAILABLE, why)),
    }
}

/// Receives a form: its document, and its files.
async fn receive_form(
    web: &DashboardState,
    mut form: Multipart,
    under_way: &mut BytesUnderWay,
) -> HandlerResult<(OrderRequest, QuoteFiles)> {
    let (mut asked, mut files) = (None, QuoteFiles::new());
    while let Some(field) = form.next_field().await.map_err(incomplete_form)? {
        match field.file_name().map(str::to_owned) {
            None if field.name() == Some("quote") => asked = Some(receive_question(field).await?),
            None => {}
            Some(_) if files.len() == MAX_LINES => {
                return Err(refused(StatusCode::PAYLOAD_TOO_LARGE, format!("a quote takes {MAX_LINES} files at most")));
            }
            Some(name) => {
                let file = receive_file(web, Box::pin(field), under_way, 0).await?;
                if files.insert(name.clone(), file).is_some() {
                    return Err(unprocessable(format!("two files of the form are called {name}")));
                }
            }
        }
    }
    Ok((asked.ok_or_else(|| unprocessable("the form has no field quote"))?, files))
}

async fn receive_question(field: Field<'_>) -> HandlerResult<OrderRequest> {
    let text = read_field(field, MAX_QUESTION_BYTES).await?;
    serde_json::from_slice(&text).map_err(|error| unprocessable(format!("quote: {error}")))
}

/// The files of all lines, and the earliest date that they say.
async fn find_files(
    web: &DashboardState,
    profile: &MachineProfile,
    asked: &OrderRequest,
    came: &QuoteFiles,
) -> HandlerResult<(Vec<QuotedFile>, Option<Timestamp>)> {
    if asked.lines.is_empty() || asked.lines.len() > MAX_LINES {
        return Err(unprocessable(format!("a quote has 1 to {MAX_LINES} lines")));
    }
    let (mut files, mut dues) = (Vec::with_capacity(asked.lines.len()), Vec::new());
    for (at, line) in asked.lines.iter().enumerate() {
        let name = build_file::escape_invisible(line.name.trim());
        let wrong = |why: String| unprocessable(format!("line {} ({name}): {why}", at + 1));
        let (ticket, _) = line.read_ticket(asked).map_err(wrong)?;
        dues.extend(due_of(&ticket, &profile.time_zone).map_err(wrong)?);
        let path = find_file(web, line, came).await.map_err(wrong)?;
        files.push(QuotedFile { name: line.name.trim().to_owned(), path, ticket });
    }
    Ok((files, dues.into_iter().min()))
}

/// Where the file of a line lies: it came with the request, was put, or is that of a part.
async fn find_file(web: &DashboardState, line: &LineRequest, came: &QuoteFiles) -> Result<PathBuf, String> {
    let Some(hash) = &line.content else {
        let came = came.get(line.name.trim()).map(|file| file.path().to_owned());
        return came.ok_or_else(|| "it names no content, and no file of that name came with the request".to_owned());
    };
    if !is_content_hash(hash) {
        return Err(format!("content = {hash:?}; it must be a BLAKE3, 64 digits of 0-9 and a-f"));
    }
    let store = ContentStore::from_dir(web.current_settings().state_dir.join("store"));
    for path in [Some(put_contents(web).path_of(hash)), store.file_path(hash).ok()].into_iter().flatten() {
        if tokio::fs::try_exists(&path).await.unwrap_or(false) {
            return Ok(path);
        }
    }
    Err(format!("the farm does not have content {hash}: put it first, to /api/v1/content/{hash}"))
}
