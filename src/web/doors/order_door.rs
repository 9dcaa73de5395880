//! Orders of programs: each request has a key, and is carried out once, whatever is sent again and wherever the daemon ends. What can be
//! judged at once is refused at once; the ledger has the order before the answer is sent, and the farm makes the parts of it.

use std::{collections::BTreeMap, sync::Arc};

use anyhow::Context;
use axum::{
    body::to_bytes,
    extract::{FromRequest, Multipart, Path, Request, State},
    http::{HeaderMap, StatusCode, header},
    response::{IntoResponse, Response},
};
use build_file::LengthUnit;
use farm::JudgedFile;
use intake::ordered_claim_id;
use ledger::{AnsweredRequest, NewOrderRequest, OrderedLine, RecordedRequest};
use schemars::JsonSchema;
use serde::Serialize;
use settings::MachineProfile;

use super::{
    order_request::{CheckedLine, MAX_LINES, OrderRequest},
    put_content::{
        announced_bytes, find_content, incomplete_body, put_contents, receive_content, require_room, take_place,
    },
};
use crate::web::{
    base::{
        api_body::MAX_JSON_BYTES,
        client_limits::BytesUnderWay,
        connection_limits::RequestInProgress,
        error::{HandlerError, HandlerResult},
        form_field::{incomplete_form, read_field},
    },
    clients::client::RequestClient,
    core::{command::check_takes_orders, state::DashboardState},
};

/// The header with the key of a request.
const KEY_HEADER: &str = "idempotency-key";
/// Says that a request was carried out before.
const REPLAYED_HEADER: &str = "idempotency-replayed";
/// Longest key, characters.
const MAX_KEY: usize = 255;

/// An order that was taken. Its lines become parts within seconds.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct OrderAccepted {
    /// Name of the order.
    order: String,
    /// The machine.
    machine: String,
    /// Its lines, in the order of the request.
    lines: Vec<AcceptedLine>,
}

/// A line that was taken.
#[derive(Debug, Serialize, JsonSchema)]
struct AcceptedLine {
    /// The line: asked for by /api/v1/orders/{order}/lines/{line}.
    line: String,
    /// File name.
    name: String,
    /// BLAKE3 of the file.
    content: String,
    /// Copies ordered.
    copies: u32,
}

/// Takes an order.
pub(super) async fn post_order(
    State(web): State<Arc<DashboardState>>,
    client: RequestClient,
    progress: RequestInProgress,
    request: Request,
) -> HandlerResult<Response> {
    receive_order(web, client, progress, None, request).await
}

/// Adds lines to an order.
pub(super) async fn post_lines(
    State(web): State<Arc<DashboardState>>,
    Path(order): Path<String>,
    client: RequestClient,
    progress: RequestInProgress,
    request: Request,
) -> HandlerResult<Response> {
    receive_order(web, client, progress, Some(order), request).await
}

fn unprocessable(text: impl Into<String>) -> HandlerError {
    HandlerError::Refused(StatusCode::UNPROCESSABLE_ENTITY, text.into())
}

/// Receives an order. Once it has arrived it is carried out, also when its client goes away: to judge its files may take longer than the
/// client waits, and it finds the answer under its key.
async fn receive_order(
    web: Arc<DashboardState>,
    client: RequestClient,
    progress: RequestInProgress,
    order_name: Option<String>,
    request: Request,
) -> HandlerResult<Response> {
    check_takes_orders(&web)?;
    let key = read_key(request.headers())?;
    let turn = web.door.begin_request(&client.key_name(), &key)?;
    let mut order = read_request(&web, &client, request).await?;
    progress.note_complete();
    if let Some(name) = order_name {
        if !order.order.is_empty() && order.order != name {
            return Err(unprocessable(format!("the address names order {name}, the request {}", order.order)));
        }
        order.order = name;
    }
    let carry_out = async move {
        let _turn = turn;
        take_order(&web, &client, key, order).await
    };
    tokio::spawn(carry_out).await.context("an order was not carried out")?
}

async fn take_order(
    web: &DashboardState,
    client: &RequestClient,
    key: String,
    order: OrderRequest,
) -> HandlerResult<Response> {
    let fingerprint = order.fingerprint();
    if let Some(known) = web.ledger.find_answered_request(&client.key_name(), &key).await? {
        return answer_again(web, client, &key, &known, &fingerprint).await;
    }
    let settings = web.current_settings();
    let Some(profile) = settings.profiles.get(&order.machine) else {
        let known: Vec<&str> = settings.profiles.keys().map(String::as_str).collect();
        let text = format!("there is no machine {}; there are {}", order.machine, known.join(", "));
        return Err(unprocessable(text));
    };
    let lines = order.check_lines(profile).map_err(unprocessable)?;
    judge_lines(web, profile, &lines).await?;
    let new = new_order(client, key, fingerprint, &order, lines, profile.intake.unit)?;
    match web.ledger.record_order_request(&new).await? {
        recorded @ (RecordedRequest::New | RecordedRequest::NewAgain) => {
            farm::note_order(&web.ledger, &settings.state_dir, &new.client, &new.key, &new.answered).await?;
            Ok(match recorded == RecordedRequest::NewAgain {
                true => replayed(new.answered.answer),
                false => accepted(new.answered.answer),
            })
        }
        RecordedRequest::Known(known) => answer_again(web, client, &new.key, &known, &new.answered.fingerprint).await,
    }
}

fn read_key(headers: &HeaderMap) -> HandlerResult<String> {
    let bad = |text: &str| HandlerError::Refused(StatusCode::BAD_REQUEST, text.to_owned());
    let Some(value) = headers.get(KEY_HEADER) else {
        return Err(bad(
            "an order needs an Idempotency-Key: a text that no other order of this client has, such as a UUID",
        ));
    };
    let key = value.to_str().map(|key| key.trim().trim_matches('"')).unwrap_or_default();
    match key.is_empty() || key.len() > MAX_KEY {
        true => Err(bad("an Idempotency-Key has 1 to 255 characters of ASCII")),
        false => Ok(key.to_owned()),
    }
}

/// The answer of a request that was carried out.
fn accepted(answer: String) -> Response {
    (StatusCode::ACCEPTED, [(header::CONTENT_TYPE, "application/json")], answer).into_response()
}

/// The same answer, once more.
fn replayed(answer: String) -> Response {
    ([(REPLAYED_HEADER, "true")], accepted(answer)).into_response()
}

async fn answer_again(
    web: &DashboardState,
    client: &RequestClient,
    key: &str,
    known: &AnsweredRequest,
    fingerprint: &str,
) -> HandlerResult<Response> {
    if known.fingerprint != fingerprint {
        return Err(unprocessable("this Idempotency-Key was used for another request: take a new key for a new order"));
    }
    // The daemon may have ended before it was noted.
    farm::note_order(&web.ledger, &web.current_settings().state_dir, &client.key_name(), key, known).await?;
    Ok(replayed(known.answer.clone()))
}

/// Reads a request: JSON, or a form with the JSON as `order` and files, which are named as their lines are.
async fn read_request(web: &DashboardState, client: &RequestClient, request: Request) -> HandlerResult<OrderRequest> {
    let kind = request.headers().get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok()).unwrap_or_default();
    if kind.starts_with("application/json") {
        let body = to_bytes(request.into_body(), MAX_JSON_BYTES).await.map_err(|error| incomplete_body(&error))?;
        return parse_order(&body);
    }
    let _place = take_place(web, client)?;
    let announced = announced_bytes(request.headers());
    let mut under_way = web.limits.begin_bytes(&client.counted_as, announced, 0)?;
    require_room(web, announced).await?;
    let form = Multipart::from_request(request, &()).await.map_err(|error| {
        let text = format!("send application/json, or multipart/form-data with files: {}", error.body_text());
        HandlerError::Refused(StatusCode::UNSUPPORTED_MEDIA_TYPE, text)
    })?;
    let (order, files) = read_form(web, form, &mut under_way).await?;
    with_files(order, &files)
}

fn parse_order(text: &[u8]) -> HandlerResult<OrderRequest> {
    let wrong = |error| HandlerError::Refused(StatusCode::BAD_REQUEST, format!("this is no order: {error}"));
    serde_json::from_slice(text).map_err(wrong)
}

/// Receives a form: its order, and the contents of its files by their names.
async fn read_form(
    web: &DashboardState,
    mut form: Multipart,
    under_way: &mut BytesUnderWay,
) -> HandlerResult<(OrderRequest, BTreeMap<String, String>)> {
    let (mut order, mut files) = (None, BTreeMap::new());
    while let Some(field) = form.next_field().await.map_err(incomplete_form)? {
        match field.file_name().map(str::to_owned) {
            None if field.name() == Some("order") && order.is_none() => {
                order = Some(parse_order(&read_field(field, MAX_JSON_BYTES).await?)?);
            }
            None => return Err(unprocessable("beside its files, the form has one field: order")),
            Some(_) if files.len() == MAX_LINES => {
                return Err(unprocessable(format!("an order has {MAX_LINES} files at most")));
            }
            Some(name) if files.contains_key(&name) => {
                return Err(unprocessable(format!("two files are called {name}: it is not clear which one is meant")));
            }
            // There is room for all of them; each has the limit for itself.
            Some(name) => {
                let stored = receive_content(web, Box::pin(field), under_way, 0, None).await?;
                files.insert(name, stored.hash);
            }
        }
    }
    let missing = || unprocessable("the form has no field order, which says what is ordered");
    Ok((order.ok_or_else(missing)?, files))
}

/// The order with the contents of the files that came with it.
fn with_files(mut order: OrderRequest, files: &BTreeMap<String, String>) -> HandlerResult<OrderRequest> {
    for line in &mut order.lines {
        let name = line.name.trim();
        match (&line.content, files.get(name)) {
            (None, found) => line.content = found.cloned(),
            (Some(said), Some(found)) if said != found => {
                let text = format!("the line {name} names another content than that of the file that came with it");
                return Err(unprocessable(format!("{text}: leave content out, or the file")));
            }
            (Some(_), _) => {}
        }
    }
    let is_ordered = |name: &&String| !order.lines.iter().any(|line| line.name.trim() == **name);
    match files.keys().find(is_ordered) {
        Some(name) => Err(unprocessable(format!("no line orders copies of {name}"))),
        None => Ok(order),
    }
}

/// Refuses lines whose files are not there, or cannot be printed as asked: with the text that their reason files would have.
async fn judge_lines(web: &DashboardState, profile: &MachineProfile, lines: &[CheckedLine]) -> HandlerResult<()> {
    for line in lines {
        if find_content(web, &line.content).await?.is_none() {
            let text = "{name}: the farm does not have content {hash}: put it first, to /api/v1/content/{hash}";
            return Err(unprocessable(text.replace("{name}", &line.name).replace("{hash}", &line.content)));
        }
    }
    let limits = Arc::new(web.current_settings().limits.clone());
    let profile = Arc::new(profile.clone());
    let (mut reasons, mut files): (Vec<String>, Vec<JudgedFile>) = Default::default();
    for line in lines {
        let turn = web.door.judging.clone().acquire_owned().await.context("a step ended")?;
        let (file, name, ticket) = (put_contents(web).path_of(&line.content), line.name.clone(), line.ticket.clone());
        let (content, profile, limits) = (line.content.clone(), profile.clone(), limits.clone());
        let judge = move || {
            let _turn = turn;
            farm::judge_file(&file, (&name, &content), &ticket, &profile, &limits)
        };
        match tokio::task::spawn_blocking(judge).await.context("a step ended")? {
            Ok(file) => files.extend(file),
            Err(reason) => reasons.push(reason),
        }
    }
    if !reasons.is_empty() {
        return Err(unprocessable(reasons.join("\n")));
    }
    web.judged.keep(files);
    Ok(())
}

/// The order as the ledger records it.
fn new_order(
    client: &RequestClient,
    key: String,
    fingerprint: String,
    order: &OrderRequest,
    lines: Vec<CheckedLine>,
    unit: LengthUnit,
) -> HandlerResult<NewOrderRequest> {
    let to_line = |(at, line): (usize, CheckedLine)| OrderedLine {
        claim: ordered_claim_id(&client.key_name(), &key, &fingerprint, at + 1),
        client: client.key_name(),
        machine: order.machine.clone(),
        order_name: line.ticket.order.unwrap_or_default(),
        name: line.name,
        content_hash: line.content,
        copies: line.copies,
        ticket: line.ticket_text,
        read_unit: Some(unit),
    };
    let lines: Vec<OrderedLine> = lines.into_iter().enumerate().map(to_line).collect();
    let accepted = |line: &OrderedLine| AcceptedLine {
        line: line.claim.clone(),
        name: line.name.clone(),
        content: line.content_hash.clone(),
        copies: line.copies,
    };
    let answer = OrderAccepted {
        order: lines.first().map(|line| line.order_name.clone()).unwrap_or_default(),
        machine: order.machine.clone(),
        lines: lines.iter().map(accepted).collect(),
    };
    let answer = serde_json::to_string(&answer).context("writing the answer")?;
    let client = client.key_name();
    Ok(NewOrderRequest { client, key, answered: AnsweredRequest { fingerprint, answer }, lines })
}
