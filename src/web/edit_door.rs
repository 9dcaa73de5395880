//! Changes of orders and lines by programs, as `nestd edit` and `cancel` make them: the daemon carries them out. And what became of a line.

use std::sync::Arc;

use axum::{
    Json,
    extract::{Path, State},
    http::StatusCode,
    response::{IntoResponse, Response},
};
use build_file::LengthUnit;
use nester::OrientationRule;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use super::{
    api_body::JsonBody,
    command::{check_takes_orders, run_commands},
    dto::PartResource,
    enum_words::words_of,
    error::{HandlerError, HandlerResult},
    order_forms::{waiting_lines, waiting_of_several},
    part_forms::{MAX_COPIES, MAX_PRIORITY},
    request_user::RequestUser,
    state::DashboardState,
};
use crate::{
    intake,
    ledger::{CommandArgument, CommandKind, NewCommand, OrderedLine, PartEdit, PartId, PartRow, PartState},
    settings::FarmZone,
};

/// Changes of what was asked; what is left out stays as it is.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct EditRequest {
    /// Copies wanted in all, those in builds included.
    copies: Option<u32>,
    /// When it is due; null = no date.
    #[serde(deserialize_with = "given_or_null")]
    #[schemars(with = "Option<String>")]
    due: Option<Option<String>>,
    /// Priority, 0 to 100.
    priority: Option<u8>,
    /// How it may be turned.
    #[schemars(with = "Option<String>", extend("enum" = words_of::<OrientationRule>()))]
    orientation: Option<OrientationRule>,
    /// Its own clearance, mm; null = that of the machine.
    #[serde(deserialize_with = "given_or_null")]
    #[schemars(with = "Option<f64>")]
    clearance_mm: Option<Option<f64>>,
    /// Unit of its file: mm, cm, m, inch, ft or micron.
    #[schemars(with = "Option<String>")]
    unit: Option<LengthUnit>,
    /// Note for people.
    note: Option<String>,
    /// Another order that it belongs to.
    order: Option<String>,
}

/// A field that may be null is told from one that is left out.
fn given_or_null<'de, D: Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<Option<Option<T>>, D::Error> {
    Option::deserialize(from).map(Some)
}

/// What the farm says of a change.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "Carried")]
pub(super) struct CarriedOut {
    /// Whether all of it is done; else it is noted, and is done when the daemon comes to it.
    pub(super) done: bool,
    /// What was done, a sentence each.
    pub(super) answers: Vec<String>,
}

/// A line of an order that came by request, and what became of it.
#[derive(Serialize, JsonSchema)]
pub(super) struct LineResponse {
    /// The line, as the order was answered, or the number of the part.
    line: String,
    /// Whether the farm still makes a part of it.
    arriving: bool,
    /// Its parts: several where its file holds several solids. A refused one says why.
    parts: Vec<PartResource>,
}

impl EditRequest {
    fn to_edit(&self, zone: &FarmZone) -> Result<PartEdit, String> {
        let due = |text: &Option<String>| match text {
            None => Ok(None),
            Some(text) => intake::parse_due_text(text, zone.time_zone()).map(Some),
        };
        if !self.copies.is_none_or(|copies| (1..=MAX_COPIES).contains(&copies)) {
            return Err(format!("copies: 1 to {MAX_COPIES}"));
        }
        if self.priority.is_some_and(|priority| priority > MAX_PRIORITY) {
            return Err(format!("priority: 0 to {MAX_PRIORITY}"));
        }
        if !self.clearance_mm.flatten().is_none_or(|mm| (0.0..=100.0).contains(&mm)) {
            return Err("clearance_mm: 0 to 100".to_owned());
        }
        let edit = PartEdit {
            copies: self.copies,
            order_name: self.order.clone(),
            priority: self.priority,
            due: self.due.as_ref().map(due).transpose()?,
            orientation: self.orientation,
            clearance_mm: self.clearance_mm,
            unit: self.unit,
            note: self.note.clone(),
            ..PartEdit::default()
        };
        if edit.is_empty() { Err("nothing is to change".to_owned()) } else { Ok(edit) }
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

/// Changes what was asked with the waiting lines of an order.
pub(super) async fn patch_order(
    State(web): State<Arc<DashboardState>>,
    Path(order): Path<String>,
    RequestUser(by): RequestUser,
    JsonBody(request): JsonBody<EditRequest>,
) -> HandlerResult<Response> {
    let edit = read_edit(&web, &request)?;
    let lines = web.ledger.order_lines(&order).await?;
    let commands = waiting_lines(&lines).map(|line| edit_command(line.part, &edit, &by)).collect();
    send_for_order(&web, &order, commands).await
}

/// Cancels what waits of an order.
pub(super) async fn delete_order(
    State(web): State<Arc<DashboardState>>,
    Path(order): Path<String>,
    RequestUser(by): RequestUser,
) -> HandlerResult<Response> {
    check_takes_orders(&web)?;
    let lines = web.ledger.order_lines(&order).await?;
    let commands = waiting_lines(&lines).map(|line| cancel_command(line.part, waiting_of_several(line), &by)).collect();
    send_for_order(&web, &order, commands).await
}

/// A line of an order, and what became of it.
pub(super) async fn get_line(
    State(web): State<Arc<DashboardState>>,
    Path((order, line)): Path<(String, String)>,
) -> HandlerResult<Json<LineResponse>> {
    let (parts, arriving) = find_line(&web, &order, &line).await?;
    Ok(Json(LineResponse {
        line,
        arriving: arriving.is_some(),
        parts: parts.into_iter().map(PartResource::from).collect(),
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
    let parts = find_parts(&web, &order, &line).await?;
    send(&web, parts.iter().map(|part| edit_command(part.id, &edit, &by)).collect()).await
}

/// Cancels what waits of a line.
pub(super) async fn delete_line(
    State(web): State<Arc<DashboardState>>,
    Path((order, line)): Path<(String, String)>,
    RequestUser(by): RequestUser,
) -> HandlerResult<Response> {
    check_takes_orders(&web)?;
    let parts = find_parts(&web, &order, &line).await?;
    let of_order = web.ledger.order_lines(&order).await?;
    let waits = |part: &PartRow| of_order.iter().find(|line| line.part == part.id && line.state == PartState::Waiting);
    let commands: Vec<NewCommand> = (parts.iter())
        .filter_map(|part| Some(cancel_command(part.id, waiting_of_several(waits(part)?), &by)))
        .collect();
    match commands.is_empty() {
        true => Err(refused(StatusCode::CONFLICT, "nothing of this line waits any more")),
        false => send(&web, commands).await,
    }
}

fn edit_command(part: PartId, edit: &PartEdit, by: &str) -> NewCommand {
    command(CommandKind::Edit, part, CommandArgument { copies: None, edit: Some(edit.clone()) }, by)
}

fn cancel_command(part: PartId, copies: Option<u32>, by: &str) -> NewCommand {
    command(CommandKind::Cancel, part, CommandArgument { copies, edit: None }, by)
}

fn command(kind: CommandKind, part: PartId, argument: CommandArgument, by: &str) -> NewCommand {
    NewCommand { kind, profile: String::new(), part: Some(part), argument, asked_by: by.to_owned() }
}

async fn send_for_order(web: &DashboardState, order: &str, commands: Vec<NewCommand>) -> HandlerResult<Response> {
    if !commands.is_empty() {
        return send(web, commands).await;
    }
    match (web.ledger.arriving_lines_of_order(order).await?.is_empty(), web.ledger.find_order(order).await?) {
        (false, _) => Err(HandlerError::TooMany(1, "its lines are arriving: ask again in a moment".to_owned())),
        (true, None) => Err(HandlerError::NotFound(format!("order named '{order}'"))),
        (true, Some(_)) => Err(refused(StatusCode::CONFLICT, "nothing of this order waits any more")),
    }
}

/// Has the daemon carry out commands, and answers what it says.
pub(super) async fn send(web: &DashboardState, commands: Vec<NewCommand>) -> HandlerResult<Response> {
    let answers = run_commands(web, commands).await?;
    if !answers.refusals.is_empty() {
        return Err(refused(StatusCode::CONFLICT, answers.refusals.join("\n")));
    }
    let status = if answers.is_complete { StatusCode::OK } else { StatusCode::ACCEPTED };
    Ok((status, Json(CarriedOut { done: answers.is_complete, answers: answers.done })).into_response())
}

/// The parts of a line, which is named by the answer to its order or by the number of its part, and the line while it arrives.
async fn find_line(
    web: &DashboardState,
    order: &str,
    line: &str,
) -> HandlerResult<(Vec<PartRow>, Option<OrderedLine>)> {
    let parts = match line.parse() {
        Ok(number) => web.ledger.find_part(PartId(number)).await?.into_iter().collect(),
        Err(_) => web.ledger.parts_of_claim(line).await?,
    };
    let parts: Vec<PartRow> = parts.into_iter().filter(|part: &PartRow| part.terms.order_name == order).collect();
    let arriving = web.ledger.arriving_lines_of_order(order).await?.into_iter().find(|arriving| arriving.claim == line);
    match parts.is_empty() && arriving.is_none() {
        true => Err(HandlerError::NotFound(format!("line {line} in order '{order}'"))),
        false => Ok((parts, arriving)),
    }
}

async fn find_parts(web: &DashboardState, order: &str, line: &str) -> HandlerResult<Vec<PartRow>> {
    match find_line(web, order, line).await? {
        (parts, _) if !parts.is_empty() => Ok(parts),
        _ => Err(HandlerError::TooMany(1, "this line is arriving: ask again in a moment".to_owned())),
    }
}
