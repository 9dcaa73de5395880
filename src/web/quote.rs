//! Quotes for programs: when parts could be done that nobody has ordered yet. The files that come with a request are removed again, and
//! nothing else is changed.

use std::{path::Path, sync::Arc, time::Duration};

use anyhow::Context;
use axum::{
    Json,
    extract::{FromRequest, Multipart, Request, State, multipart::Field},
    http::{StatusCode, header},
};
use jiff::Timestamp;
use schemars::JsonSchema;
use serde::Deserialize;
use tempfile::TempDir;
use tokio::io::AsyncWriteExt;

use super::{
    error::{HandlerError, HandlerResult},
    state::DashboardState,
};
use crate::{
    farm::{
        OrderQuote, QUOTE_SEARCH_TIME, QuoteError, QuoteQuestion, QuotedFile, quote_order, read_plan, read_quoted_files,
    },
    intake::{self, ContentStore},
    settings::MachineProfile,
};

/// Quotes that are made at the same time.
pub(super) const MAX_QUOTES: usize = 2;
/// Lines of a quote, and files that come with it.
const MAX_LINES: usize = 200;
/// Greatest length of the field `quote`, bytes.
const MAX_QUESTION_BYTES: usize = 1 << 18;
/// No quote is waited for any longer: large files take their time to be read.
const TIME_LIMIT: Duration = Duration::from_secs(20);

/// What a quote is asked for.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct QuoteRequest {
    /// The machine.
    machine: String,
    /// The date that is wished for, such as 2026-11-25 (the end of that day in the farm's time zone) or 2026-11-25T17:00:00Z.
    #[serde(default)]
    due: Option<String>,
    /// What is asked for.
    lines: Vec<QuoteRequestLine>,
}

/// A part of a quote: a file that comes with the request, or one that the farm has.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct QuoteRequestLine {
    /// Name of a file of the form.
    #[serde(default)]
    file: Option<String>,
    /// BLAKE3 of the file of a part that the farm keeps, 64 hex digits.
    #[serde(default)]
    content: Option<String>,
    /// Copies of each solid in it.
    #[serde(default = "one_copy")]
    copies: u32,
}

fn one_copy() -> u32 {
    1
}

fn refused(status: StatusCode, text: impl ToString) -> HandlerError {
    HandlerError::Refused(status, text.to_string())
}

/// Makes a quote for a JSON document, or for a form with such a document in its field `quote` and files.
pub(super) async fn post_quote(
    State(web): State<Arc<DashboardState>>,
    request: Request,
) -> HandlerResult<Json<OrderQuote>> {
    let busy = || refused(StatusCode::TOO_MANY_REQUESTS, "other quotes are being made just now: ask again in a moment");
    let place = web.quote_slots.clone().try_acquire_owned().map_err(|_| busy())?;
    let kind = request.headers().get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let folder = TempDir::with_prefix("nestd-quote-").context("a folder for the files of a quote")?;
    let asked = if kind.starts_with("multipart/form-data") {
        let form =
            Multipart::from_request(request, &web).await.map_err(|error| refused(error.status(), error.body_text()))?;
        receive_form(&web, form, folder.path()).await?
    } else {
        let body = Json::<QuoteRequest>::from_request(request, &web).await;
        body.map_err(|error| refused(error.status(), error.body_text()))?.0
    };
    let settings = web.current_settings();
    let profile = settings.profiles.get(&asked.machine).cloned().map(Arc::new);
    let profile = profile
        .ok_or_else(|| refused(StatusCode::UNPROCESSABLE_ENTITY, format!("there is no machine {}", asked.machine)))?;
    let due_at = due_of(&asked, &profile)?;
    let files = find_files(&web, &asked, folder.path()).await?;
    let now = Timestamp::now();
    let reading = read_plan(&web.ledger, &profile, now).await?;
    let (limits, meshes) = (settings.limits.clone(), web.quote_meshes.clone());
    let work = move || {
        let parts = read_quoted_files(&profile, &limits, &files, true, now);
        // They are in memory, or refused.
        drop(folder);
        let question = QuoteQuestion { parts: parts?, due_at, within: QUOTE_SEARCH_TIME };
        Ok(quote_order(&profile, &reading, question, &meshes, place, now))
    };
    let made = tokio::time::timeout(TIME_LIMIT, tokio::task::spawn_blocking(work)).await;
    let late = |_| refused(StatusCode::SERVICE_UNAVAILABLE, "it takes too long to read these files");
    match made.map_err(late)?.context("making a quote ended")? {
        Ok(quote) => Ok(Json(quote)),
        Err(QuoteError::Refused(reason)) => {
            Err(refused(StatusCode::UNPROCESSABLE_ENTITY, reason.trim_end_matches('.')))
        }
        Err(QuoteError::TryLater(why)) => Err(refused(StatusCode::SERVICE_UNAVAILABLE, why)),
    }
}

fn due_of(asked: &QuoteRequest, profile: &MachineProfile) -> HandlerResult<Option<Timestamp>> {
    let parse = |text: &String| intake::parse_due_text(text, profile.time_zone.time_zone());
    let due = asked.due.as_ref().map(parse).transpose();
    due.map(|due| due.map(|(at, _)| at)).map_err(|why| refused(StatusCode::UNPROCESSABLE_ENTITY, why))
}

/// Receives a form: its document, and its files into a folder.
async fn receive_form(web: &DashboardState, mut form: Multipart, folder: &Path) -> HandlerResult<QuoteRequest> {
    let broken = |error: axum::extract::multipart::MultipartError| refused(error.status(), error.body_text());
    let (mut asked, mut files, max_bytes) = (None, 0, web.current_settings().limits.max_bytes);
    while let Some(mut field) = form.next_field().await.map_err(broken)? {
        match field.file_name().map(str::to_owned) {
            None if field.name() == Some("quote") => {
                let mut text = Vec::new();
                while let Some(chunk) = field.chunk().await.map_err(broken)? {
                    text.extend_from_slice(&chunk);
                    if text.len() > MAX_QUESTION_BYTES {
                        return Err(refused(StatusCode::PAYLOAD_TOO_LARGE, "the field quote is too long"));
                    }
                }
                let read = serde_json::from_slice(&text);
                asked =
                    Some(read.map_err(|error| refused(StatusCode::UNPROCESSABLE_ENTITY, format!("quote: {error}")))?);
            }
            None => {}
            Some(_) if files == MAX_LINES => {
                return Err(refused(StatusCode::PAYLOAD_TOO_LARGE, format!("a quote takes {MAX_LINES} files at most")));
            }
            Some(name) => {
                files += 1;
                receive_file(field, &file_in(folder, &name), max_bytes).await?;
            }
        }
    }
    asked.ok_or_else(|| refused(StatusCode::UNPROCESSABLE_ENTITY, "the form has no field quote"))
}

/// Where a file of this name lies: the name itself is no path here.
fn file_in(folder: &Path, name: &str) -> std::path::PathBuf {
    folder.join(blake3::hash(name.as_bytes()).to_hex().as_str())
}

async fn receive_file(mut field: Field<'_>, path: &Path, max_bytes: u64) -> HandlerResult<()> {
    let mut file = tokio::fs::File::create(path).await.context("a file of a quote")?;
    let mut bytes = 0;
    while let Some(chunk) = field.chunk().await.map_err(|error| refused(error.status(), error.body_text()))? {
        bytes += chunk.len() as u64;
        if bytes > max_bytes {
            return Err(refused(
                StatusCode::PAYLOAD_TOO_LARGE,
                format!("a file may have {max_bytes} bytes (limits.max_bytes)"),
            ));
        }
        file.write_all(&chunk).await.context("a file of a quote")?;
    }
    Ok(file.flush().await.context("a file of a quote")?)
}

/// The files of all lines: those of the form, and those in the store.
async fn find_files(web: &DashboardState, asked: &QuoteRequest, folder: &Path) -> HandlerResult<Vec<QuotedFile>> {
    let wrong = |text: String| Err(refused(StatusCode::UNPROCESSABLE_ENTITY, text));
    if asked.lines.is_empty() || asked.lines.len() > MAX_LINES {
        return wrong(format!("a quote has 1 to {MAX_LINES} lines"));
    }
    let store = ContentStore::from_dir(web.current_settings().state_dir.join("store"));
    let mut files = Vec::with_capacity(asked.lines.len());
    for line in &asked.lines {
        let (name, path) = match (&line.file, &line.content) {
            (Some(name), None) => (name.clone(), file_in(folder, name)),
            (None, Some(hash)) => {
                let Ok(path) = store.file_path(hash) else { return wrong(format!("{hash} is no BLAKE3")) };
                let known = web.ledger.parts_with_content(hash).await?.into_iter().next();
                (known.map(|part| part.name).unwrap_or_default(), path)
            }
            _ => return wrong("a line has either file or content".to_owned()),
        };
        if line.copies == 0 || name.is_empty() || !tokio::fs::try_exists(&path).await.unwrap_or(false) {
            let what = line.file.as_ref().or(line.content.as_ref());
            return wrong(format!("{} is not here, or no copy of it is asked for", what.map_or("", String::as_str)));
        }
        files.push(QuotedFile { name, path, copies: line.copies });
    }
    Ok(files)
}
