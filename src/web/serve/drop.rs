//! Files that people put into the hot folder of a machine with their browser. They are taken as files are that were copied there; what
//! does not arrive as a whole leaves nothing behind.

use std::{path::PathBuf, sync::Arc, time::Duration};

use access::Role;
use anyhow::Context;
use axum::{
    extract::{Multipart, Path, State, multipart::Field},
    http::StatusCode,
    response::{IntoResponse, Response},
};
use intake::{PutUploads, UPLOAD_KEPT, UploadError, UploadedFile, remove_unfinished_uploads};
use language::say;
use maud::{Markup, html};
use settings::MachineProfile;

use super::sent_form::{carry_out_form, check_form_key};
use crate::web::{
    base::{
        connection_limits::RequestInProgress,
        error::{HandlerError, HandlerResult},
        form_field::{incomplete_form, read_field},
        page::html_page,
    },
    clients::client::RequestClient,
    core::{form_answer::FormAnswer, state::DashboardState},
    doors::put_content::{put_contents, run_on_disk},
    forms::drop_form::{DropFields, MAX_FIELD_BYTES, drop_form},
};

/// Uploads at the same time.
pub(super) const MAX_UPLOADS: usize = 4;
/// Files of one form.
const MAX_FILES: usize = 500;
/// An upload without a byte for this time has ended; a connection ends far sooner.
const QUIET_UPLOAD: Duration = Duration::from_secs(600);

/// How long a file stays that was put, after it was last put or ordered.
const CONTENT_KEPT: Duration = Duration::from_secs(7 * 86_400);
/// How long the key of a request is kept.
const KEYS_KEPT: jiff::SignedDuration = jiff::SignedDuration::from_hours(30 * 24);

/// The page with the form of a machine.
pub(super) async fn show_form(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
) -> HandlerResult<Markup> {
    let profile = find_machine(&web, &name)?;
    let content = html! {
        h1 { (say!("add-files-to", machine = &name)) }
        @if web.offers(Role::Order) {
            p { (say!("add-files-text", machine = &name)) }
            (drop_form(&web, &profile, web.current_settings().limits.max_bytes))
        } @else { p { (phrase!("no-orders-from-pages", folder = html! { code { (profile.folders.inbox.display()) } })) } }
    };
    Ok(html_page(&say!("add-files-to", machine = &name), "", Some("drop.js"), &content))
}

fn find_machine(web: &DashboardState, name: &str) -> HandlerResult<MachineProfile> {
    let settings = web.current_settings();
    settings.profiles.get(name).cloned().ok_or_else(|| HandlerError::NotFound(say!("machine-named", machine = name)))
}

fn refused(status: StatusCode, text: impl ToString) -> HandlerError {
    HandlerError::Refused(status, text.to_string())
}

/// Takes the files of a form. Those for a machine of another node were passed on to it.
pub(super) async fn post_files(
    State(web): State<Arc<DashboardState>>,
    Path(name): Path<String>,
    client: RequestClient,
    progress: RequestInProgress,
    mut form: Multipart,
) -> HandlerResult<Response> {
    let profile = find_machine(&web, &name)?;
    let busy = || HandlerError::TooMany(1, say!("others-add-files"));
    let _place = web.upload_slots.clone().try_acquire_owned().map_err(|_| busy())?;
    let (mut fields, mut files, mut asked) = (DropFields::default(), Vec::new(), blake3::Hasher::new());
    let (inbox, max_bytes) = (profile.folders.inbox.clone(), web.current_settings().limits.max_bytes);
    while let Some(field) = form.next_field().await.map_err(incomplete_form)? {
        let field_name = field.name().unwrap_or_default().to_owned();
        match field.file_name().map(str::to_owned) {
            None => {
                let text = read_text(field).await?;
                if field_name == "key" {
                    check_form_key(&web, &text)?;
                }
                fields.set_field(&field_name, text);
            }
            // A browser sends an empty one where nothing was chosen.
            Some(file_name) if file_name.is_empty() => {}
            Some(_) if files.len() == MAX_FILES => {
                return Err(refused(StatusCode::PAYLOAD_TOO_LARGE, say!("form-takes-files", files = MAX_FILES)));
            }
            Some(file_name) => {
                check_form_key(&web, &fields.key)?;
                asked.update(file_name.as_bytes()).update(b"\n");
                files.push(receive_file(field, inbox.clone(), file_name, max_bytes, &mut asked).await?);
            }
        }
    }
    progress.note_complete();
    check_form_key(&web, &fields.key)?;
    if files.is_empty() {
        return Err(refused(StatusCode::BAD_REQUEST, say!("no-file-chosen")));
    }
    let zone = web.current_settings().time_zone.clone();
    let ticket = fields.to_ticket(&zone).map_err(|why| refused(StatusCode::BAD_REQUEST, why))?;
    asked.update(format!("{name}\n{fields:?}").as_bytes());
    let place = async move {
        match tokio::task::spawn_blocking(move || place_files(files, &ticket)).await.context("a step ended") {
            Ok(placed) => answer_drop(&profile, &placed).into_response(),
            Err(failure) => HandlerError::from(failure).into_response(),
        }
    };
    carry_out_form(web, &client, &fields.key, asked.finalize().to_hex().to_string(), place).await
}

fn answer_drop(profile: &MachineProfile, placed: &[Result<String, UploadError>]) -> FormAnswer {
    let sentences = placed_sentences(profile, placed);
    match placed.iter().any(Result::is_ok) {
        true => FormAnswer::told(&say!("files-were-added"), sentences, "/"),
        false => FormAnswer::refused(sentences, "/"),
    }
}

/// Gives all files their names in the hot folder: each by itself, so that one that fails keeps no other.
fn place_files(files: Vec<UploadedFile>, ticket: &str) -> Vec<Result<String, UploadError>> {
    files.into_iter().map(|file| file.finish(ticket)).collect()
}

fn placed_sentences(profile: &MachineProfile, placed: &[Result<String, UploadError>]) -> Vec<String> {
    let sentence = |placed: &Result<String, UploadError>| match placed {
        Ok(name) => say!("file-is-there", file = name, machine = &profile.name),
        Err(error) => say!("file-not-added", why = error.to_string()),
    };
    let taken = say!("file-is-taken-after", secs = format!("{:.0}", profile.intake.settle_secs));
    let is_any_there = placed.iter().any(Result::is_ok);
    placed.iter().map(sentence).chain(is_any_there.then_some(taken)).collect()
}

async fn read_text(field: Field<'_>) -> HandlerResult<String> {
    let bytes = read_field(field, MAX_FIELD_BYTES).await?;
    String::from_utf8(bytes).map_err(|_| refused(StatusCode::BAD_REQUEST, say!("field-is-no-text")))
}

/// Receives one file into the hot folder, under a name that the farm does not look at; it is part of what is asked.
async fn receive_file(
    mut field: Field<'_>,
    inbox: PathBuf,
    name: String,
    max_bytes: u64,
    asked: &mut blake3::Hasher,
) -> HandlerResult<UploadedFile> {
    let token = rand::random();
    let begin = move || UploadedFile::begin(&inbox, &name, token, max_bytes);
    let mut file = on_disk(begin).await?;
    while let Some(chunk) = field.chunk().await.map_err(incomplete_form)? {
        asked.update(&chunk);
        let write = move || file.write_chunk(&chunk).map(|()| file);
        file = on_disk(write).await?;
    }
    Ok(file)
}

/// Runs what writes to the disk where it holds up no other request.
async fn on_disk<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, UploadError> + Send + 'static,
) -> HandlerResult<T> {
    let done = tokio::task::spawn_blocking(work).await.context("a step ended")?;
    done.map_err(|error| {
        let status = match error {
            UploadError::Name { .. } => StatusCode::BAD_REQUEST,
            UploadError::TooLarge { .. } => StatusCode::PAYLOAD_TOO_LARGE,
            UploadError::Write { .. } => StatusCode::INSUFFICIENT_STORAGE,
        };
        refused(status, error)
    })
}

/// Forgets keys of requests, and removes files that were put and that nobody needs any more.
async fn sweep_put_files(web: &DashboardState) -> HandlerResult<()> {
    farm::update_order_notes(&web.ledger, &web.current_settings().state_dir).await?;
    let before = jiff::Timestamp::now().checked_sub(KEYS_KEPT).context("the clock is at the begin of time")?;
    web.ledger.forget_order_requests(before.into()).await?;
    let needed = web.ledger.contents_of_arriving_lines().await?.into_iter().collect();
    let contents = put_contents(web);
    run_on_disk(move || {
        contents.sweep_contents(QUIET_UPLOAD, CONTENT_KEPT, &needed)?;
        Ok(PutUploads::new(contents).sweep_uploads(UPLOAD_KEPT)?)
    })
    .await
}

/// Removes what was arriving when an earlier daemon ended, as long as the dashboard is served.
pub(super) async fn sweep_unfinished(web: Arc<DashboardState>) {
    loop {
        let settings = web.current_settings();
        let own = settings.profiles.values().filter(|profile| profile.of_node.is_empty());
        let inboxes: Vec<PathBuf> = own.map(|profile| profile.folders.inbox.clone()).collect();
        let sweep = move || {
            for inbox in inboxes {
                // A folder that is away is swept when it is there again.
                if let Err(error) = remove_unfinished_uploads(&inbox, QUIET_UPLOAD) {
                    tracing::debug!("{} cannot be swept: {error}.", inbox.display());
                }
            }
        };
        if tokio::task::spawn_blocking(sweep).await.is_err() {
            return;
        }
        if let Err(error) = sweep_put_files(&web).await {
            tracing::debug!("What was put cannot be swept: {error}.");
        }
        tokio::time::sleep(QUIET_UPLOAD).await;
    }
}
