//! Changes of orders and lines by programs, as `nestd edit` and `cancel` make them: the daemon carries them out. And what became of a line.

use std::sync::Arc;

use axum::{
    Json,
    extract::{Path, State},
    http::StatusCode,
    response::{IntoResponse, Response},
};
use build_file::LengthUnit;
use ledger::{CommandArgument, CommandKind, NewCommand, PartEdit, PartId, PartRow, PartState};
use nester::OrientationRule;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use settings::{FarmZone, given_or_null};

use super::{dto::PartResource, enum_words::words_or_null};
use crate::web::{
    base::{
        api_body::JsonBody,
        error::{HandlerError, HandlerResult},
        query::order_address,
    },
    core::{
        command::{CommandAnswers, check_takes_orders, run_commands},
        request_user::RequestUser,
        state::DashboardState,
    },
    forms::order_cancel::{CancelTarget, cancel_lines, is_being_read},
};

/// Changes of what was asked; what is left out stays as it is.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct EditRequest {
    /// Copies wanted in all, those in builds included; for one part at a time.
    copies: Option<u32>,
    /// When it is due; null = no date.
    #[serde(deserialize_with = "given_or_null")]
    #[schemars(with = "Option<String>")]
    due: Option<Option<String>>,
    /// Priority, 0 to 100.
    priority: Option<u8>,
    /// How it may be turned; not for a whole order.
    #[schemars(with = "Option<String>", extend("enum" = words_or_null::<OrientationRule>()))]
    orientation: Option<OrientationRule>,
    /// Its own clearance, mm; null = that of the machine.
    #[serde(deserialize_with = "given_or_null")]
    #[schemars(with = "Option<f64>")]
    clearance_mm: Option<Option<f64>>,
    /// Unit of its file: mm, cm, m, inch, ft or micron; not for a whole order.
    #[schemars(with = "Option<String>")]
    unit: Option<LengthUnit>,
    /// Note for people.
    note: Option<String>,
    /// Another order that it belongs to.
    order: Option<String>,
    /// What it is to be made of; empty = anything.
    material: Option<String>,
    /// Finishing steps after the print; empty = none. They can also be changed where nothing waits any more.
    finish: Option<String>,
    /// Who it is for; can also be changed where nothing waits any more.
    customer: Option<String>,
    /// Where the customer gets e-mail when the order is complete; can also be changed where nothing waits any more.
    email: Option<String>,
}

/// What the farm says of a change.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "Carried")]
pub(crate) struct CarriedOut {
    /// Whether all of it is done; else it is noted, and is done when the daemon comes to it.
    pub(crate) done: bool,
    /// What was done, a sentence each.
    pub(crate) answers: Vec<String>,
}

/// A line of an order that came by request, and what became of it.
#[derive(Serialize, JsonSchema)]
pub(crate) struct LineResponse {
    /// The line, as the order was answered, or the number of the part.
    line: String,
    /// Whether the farm still makes a part of it.
    arriving: bool,
    /// Whether it was cancelled before the farm had a part of it.
    cancelled: bool,
    /// Its parts: several where its file holds several solids. A refused one says why.
    parts: Vec<PartResource>,
}

impl EditRequest {
    fn to_edit(&self, zone: &FarmZone) -> Result<PartEdit, String> {
        let due = |text: &Option<String>| match text {
            None => Ok(None),
            Some(text) => intake::parse_due_text(text, zone.time_zone()).map(Some),
        };
        let edit = PartEdit {
            copies: self.copies,
            order_name: self.order.clone(),
            customer: self.customer.clone(),
            email: self.email.clone(),
            material: self.material.clone(),
            finish: self.finish.clone(),
            priority: self.priority,
            due: self.due.as_ref().map(due).transpose()?,
            orientation: self.orientation,
            clearance_mm: self.clearance_mm,
            unit: self.unit,
            note: self.note.clone(),
            ..PartEdit::default()
        };
        if edit.is_empty() { Err("nothing is to change".to_owned()) } else { edit.checked() }
    }
}

fn refused(status: StatusCode, text: impl Into<String>) -> HandlerError {
    HandlerError::Refused(status, text.into())
}

fn read_edit(web: &DashboardState, request: &EditRequest) -> HandlerResult<PartEdit> {
    check_takes_orders(web)?;
    let edit = request.to_edit(&web.current_settings().time_zone);
    edit.map_err(|wrong| refused(StatusCode::UNPROCESSABLE_ENTITY, wrong))
}

/// When to ask again for a line that arrives, s.
const ARRIVING_SECS: u64 = 1;
/// Parts that a refusal names.
const MAX_NAMED: usize = 3;

/// A line of an order that was looked for.
struct FoundLine {
    parts: Vec<PartRow>,
    is_arriving: bool,
    is_cancelled: bool,
}

/// Changes what was asked with the waiting lines of an order.
pub(super) async fn patch_order(
    State(web): State<Arc<DashboardState>>,
    Path(order): Path<String>,
    RequestUser(by): RequestUser,
    JsonBody(request): JsonBody<EditRequest>,
) -> HandlerResult<Response> {
    let edit = read_edit(&web, &request)?;
    let mut parts = web.ledger.parts_of_order(&order).await?;
    let arriving = web.ledger.arriving_lines_of_order(&order).await?;
    if parts.is_empty() && arriving.is_empty() {
        return Err(nothing_left(&web, &order).await?);
    }
    parts.retain(|part| !edit.possible_in(part.state).is_empty());
    if edit.copies.is_some() || edit.orientation.is_some() || edit.unit.is_some() {
        let fields = "copies, orientation and unit are changed part by part";
        return Err(part_by_part(fields, &order, &parts));
    }
    require_known(!arriving.is_empty(), &parts)?;
    if parts.is_empty() {
        return Err(nothing_left(&web, &order).await?);
    }
    let edit_of = |part: &PartRow| edit_command(part.id, &edit.possible_in(part.state), &by);
    send(&web, parts.iter().map(edit_of).collect()).await
}

/// Cancels what waits of an order, arrives or is being read.
pub(super) async fn delete_order(
    State(web): State<Arc<DashboardState>>,
    Path(order): Path<String>,
    RequestUser(by): RequestUser,
) -> HandlerResult<Response> {
    check_takes_orders(&web)?;
    let answers = cancel_lines(&web, CancelTarget { order: &order, line: None }, &by).await?;
    match answers.is_empty() {
        true => Err(nothing_left(&web, &order).await?),
        false => carried_out(answers),
    }
}

/// A line of an order, and what became of it.
pub(super) async fn get_line(
    State(web): State<Arc<DashboardState>>,
    Path((order, line)): Path<(String, String)>,
) -> HandlerResult<Json<LineResponse>> {
    let found = find_line(&web, &order, &line).await?;
    Ok(Json(LineResponse {
        line,
        arriving: found.is_arriving,
        cancelled: found.is_cancelled,
        parts: found.parts.into_iter().map(PartResource::from).collect(),
    }))
}

/// Changes what was asked with a line.
pub(super) async fn patch_line(
    State(web): State<Arc<DashboardState>>,
    Path((order, line)): Path<(String, String)>,
    RequestUser(by): RequestUser,
    JsonBody(request): JsonBody<EditRequest>,
) -> HandlerResult<Response> {
    let edit = read_edit(&web, &request)?;
    let FoundLine { mut parts, is_arriving, is_cancelled } = find_line(&web, &order, &line).await?;
    if is_cancelled {
        return Err(refused(StatusCode::CONFLICT, "this line was cancelled before it was taken"));
    }
    require_known(is_arriving, &parts)?;
    if parts.iter().any(|part| part.state != PartState::Refused) {
        parts.retain(|part| part.state != PartState::Refused);
    }
    if edit.copies.is_some() && parts.len() > 1 {
        let text = "the file of this line holds several parts, each with its own copies";
        return Err(part_by_part(text, &order, &parts));
    }
    send(&web, parts.iter().map(|part| edit_command(part.id, &edit, &by)).collect()).await
}

/// Cancels what waits of a line, arrives or is being read.
pub(super) async fn delete_line(
    State(web): State<Arc<DashboardState>>,
    Path((order, line)): Path<(String, String)>,
    RequestUser(by): RequestUser,
) -> HandlerResult<Response> {
    check_takes_orders(&web)?;
    find_line(&web, &order, &line).await?;
    let answers = cancel_lines(&web, CancelTarget { order: &order, line: Some(&line) }, &by).await?;
    match answers.is_empty() {
        true => Err(refused(StatusCode::CONFLICT, "nothing of this line waits any more")),
        false => carried_out(answers),
    }
}

fn edit_command(part: PartId, edit: &PartEdit, by: &str) -> NewCommand {
    let argument = CommandArgument { copies: None, edit: Some(edit.clone()), ..CommandArgument::default() };
    NewCommand { kind: CommandKind::Edit, machine: String::new(), part: Some(part), argument, asked_by: by.to_owned() }
}

/// Why an order has nothing to change or to cancel.
async fn nothing_left(web: &DashboardState, order: &str) -> HandlerResult<HandlerError> {
    let is_known = web.ledger.find_order(order).await?.is_some() || web.ledger.has_cancelled_lines(order).await?;
    Ok(match is_known {
        true => refused(StatusCode::CONFLICT, "nothing of this order waits any more"),
        false => HandlerError::NotFound(format!("order named '{order}'")),
    })
}

/// Refuses a change of several parts that concerns each by itself, and says where it is made.
fn part_by_part(why: &str, order: &str, parts: &[PartRow]) -> HandlerError {
    let address = format!("/api/v1{}/lines", order_address(order));
    let named = |part: &PartRow| format!("PATCH {address}/{} for {}", part.id, part.full_name());
    let mut named: Vec<String> = parts.iter().take(MAX_NAMED).map(named).collect();
    if named.is_empty() {
        named.push(format!("PATCH {address}/LINE"));
    }
    let more = if parts.len() > MAX_NAMED { ", and so on" } else { "" };
    refused(StatusCode::UNPROCESSABLE_ENTITY, format!("{why}: {}{more}", named.join(", ")))
}

/// Refuses a change while lines arrive or are read for the first time: it would miss them.
fn require_known(is_arriving: bool, parts: &[PartRow]) -> HandlerResult<()> {
    let text = match (is_arriving, parts.iter().any(is_being_read)) {
        (true, _) => "lines of it are arriving: ask again in a moment",
        (false, true) => "files of it are being read: ask again in a moment",
        (false, false) => return Ok(()),
    };
    Err(HandlerError::TooMany(ARRIVING_SECS, text.to_owned()))
}

/// Has the daemon carry out commands, and answers what it says.
pub(crate) async fn send(web: &DashboardState, commands: Vec<NewCommand>) -> HandlerResult<Response> {
    carried_out(run_commands(web, commands).await?)
}

fn carried_out(answers: CommandAnswers) -> HandlerResult<Response> {
    if !answers.refusals.is_empty() {
        return Err(HandlerError::NotAllDone { done: answers.done, refused: answers.refusals });
    }
    let status = if answers.is_complete { StatusCode::OK } else { StatusCode::ACCEPTED };
    Ok((status, Json(CarriedOut { done: answers.is_complete, answers: answers.done })).into_response())
}

/// The parts of a line, which is named by the answer to its order or by the number of its part.
async fn find_line(web: &DashboardState, order: &str, line: &str) -> HandlerResult<FoundLine> {
    let mut parts = match line.parse() {
        Ok(number) => web.ledger.find_part(PartId(number)).await?.into_iter().collect(),
        Err(_) => web.ledger.parts_of_claim(line).await?,
    };
    parts.retain(|part: &PartRow| part.terms.order_name == order);
    let is_arriving = web.ledger.arriving_lines_of_order(order).await?.iter().any(|arriving| arriving.claim == line);
    let is_cancelled = web.ledger.is_cancelled_line(order, line).await? == Some(true);
    match parts.is_empty() && !is_arriving && !is_cancelled {
        true => Err(HandlerError::NotFound(format!("line {line} in order '{order}'"))),
        false => Ok(FoundLine { parts, is_arriving, is_cancelled }),
    }
}
