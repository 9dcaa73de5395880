//! What programs tell of builds, parts and machines, as `nestd outcome`, `release`, `retry`, `confirm`, `flush` and `pause` do.

use std::{collections::BTreeMap, sync::Arc};

use axum::{
    Json,
    extract::{Path, State},
    response::Response,
};
use ledger::{
    BuildId, CommandArgument, CommandKind, FinishingStep, LedgerError, NewCommand, OperatorWord, PartId, PartRow,
    PrintOutcome, ToldOutcome,
};
use schemars::JsonSchema;
use serde::Deserialize;

use super::{
    edit_door::{CarriedOut, send},
    enum_words::words_of,
};
use crate::web::{
    base::{
        api_body::JsonBody,
        error::{HandlerError, HandlerResult},
    },
    core::{
        command::{check_takes_orders, is_failure_of_ledger},
        request_user::RequestUser,
        state::DashboardState,
    },
};

/// What became of the print of a build.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct OutcomeRequest {
    /// The outcome.
    #[schemars(with = "String", extend("enum" = words_of::<PrintOutcome>()))]
    outcome: PrintOutcome,
    /// A note for people.
    #[serde(default)]
    note: String,
    /// Copies that are bad all the same, by the number of their part.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, u32>")]
    bad: BTreeMap<i64, u32>,
    /// Whether bad copies are not to be printed again.
    #[serde(default)]
    keep: bool,
    /// Whether it corrects what was told before.
    #[serde(default)]
    correct: bool,
    /// Whether it is meant although the file of the build lies in the queue: it is taken out first.
    #[serde(default)]
    anyway: bool,
}

/// That a proved build may be published.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct ReleaseRequest {
    /// BLAKE3 of the build file that was looked at; if the build was proved anew since, it is not released.
    file_hash: Option<String>,
}

/// Records the outcome of a build.
pub(super) async fn post_outcome(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    RequestUser(by): RequestUser,
    JsonBody(request): JsonBody<OutcomeRequest>,
) -> HandlerResult<Json<CarriedOut>> {
    let build = require_build(&web, number).await?;
    let outcome = request.outcome;
    let told = ToldOutcome {
        bad: request.bad.into_iter().map(|(part, copies)| (PartId(part), copies)).collect(),
        keep: request.keep,
        is_correction: request.correct,
        ..ToldOutcome::new(outcome, request.note.trim(), &by)
    };
    say(&web, &OperatorWord::Outcome(build, told), &by, request.anyway).await
}

/// Says a word as `farm::operate` judges it, also for the command line and pages.
async fn say(web: &DashboardState, word: &OperatorWord, by: &str, anyway: bool) -> HandlerResult<Json<CarriedOut>> {
    let said = farm::operate(&web.ledger, &web.current_settings(), word, by, anyway).await;
    let said = said.map_err(refusal_of_ledger)?;
    Ok(Json(CarriedOut { done: said.noted.is_empty(), answers: said.sentences }))
}

/// Releases a proved build.
pub(super) async fn post_release(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    RequestUser(by): RequestUser,
    JsonBody(request): JsonBody<ReleaseRequest>,
) -> HandlerResult<Json<CarriedOut>> {
    let build = require_build(&web, number).await?;
    say(&web, &OperatorWord::Release { build, seen: request.file_hash }, &by, false).await
}

/// Closes an order as it is.
pub(super) async fn post_close(
    State(web): State<Arc<DashboardState>>,
    Path(order): Path<String>,
    RequestUser(by): RequestUser,
) -> HandlerResult<Json<CarriedOut>> {
    check_takes_orders(&web)?;
    if web.ledger.find_order(&order).await?.is_none() {
        return Err(HandlerError::NotFound(format!("order named '{order}'")));
    }
    say(&web, &OperatorWord::CloseOrder(order), &by, false).await
}

/// What is loaded in a machine.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LoadRequest {
    /// The material; empty = nothing.
    material: String,
    /// The lot of its powder; empty = not said.
    #[serde(default)]
    lot: String,
}

/// Says what is loaded in a machine.
pub(super) async fn post_load(
    State(web): State<Arc<DashboardState>>,
    Path(machine): Path<String>,
    RequestUser(by): RequestUser,
    JsonBody(request): JsonBody<LoadRequest>,
) -> HandlerResult<Json<CarriedOut>> {
    require_machine(&web, &machine)?;
    say(&web, &OperatorWord::Load { machine, material: request.material, lot: request.lot }, &by, false).await
}

/// What is said of a finishing step.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FinishingRequest {
    /// The step, as the finish of the part names it.
    step: String,
    /// Whether it is done.
    done: bool,
}

/// Says of a finishing step of a part whether it is done, and answers with all of them.
pub(super) async fn post_finishing(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    RequestUser(by): RequestUser,
    JsonBody(request): JsonBody<FinishingRequest>,
) -> HandlerResult<Json<Vec<FinishingStep>>> {
    let part = require_part(&web, number).await?;
    let told = web.ledger.tell_finished(part.id, &request.step, request.done, &by).await;
    told.map_err(refusal_of_ledger)?;
    Ok(Json(web.ledger.finishing_of_part(&part).await?.steps))
}

/// How a refused part is taken back.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct RetryRequest {
    /// Whether its mesh may be mended.
    mend: bool,
}

/// Reads a refused part again.
pub(super) async fn post_retry(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    RequestUser(by): RequestUser,
    JsonBody(request): JsonBody<RetryRequest>,
) -> HandlerResult<Response> {
    let argument = CommandArgument { mend: request.mend, ..CommandArgument::default() };
    command_part(&web, CommandKind::Retry, number, argument, by).await
}

/// Prints a part that waits for an answer as it is.
pub(super) async fn post_confirm(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    RequestUser(by): RequestUser,
) -> HandlerResult<Response> {
    command_part(&web, CommandKind::Confirm, number, CommandArgument::default(), by).await
}

/// Has the daemon do something with a part.
async fn command_part(
    web: &DashboardState,
    kind: CommandKind,
    number: i64,
    argument: CommandArgument,
    asked_by: String,
) -> HandlerResult<Response> {
    check_takes_orders(web)?;
    let part = require_part(web, number).await?;
    send(web, vec![NewCommand { kind, machine: String::new(), part: Some(part.id), argument, asked_by }]).await
}

/// Nests and publishes the waiting parts of a machine.
pub(super) async fn post_flush(
    State(web): State<Arc<DashboardState>>,
    Path(machine): Path<String>,
    RequestUser(by): RequestUser,
) -> HandlerResult<Response> {
    command_machine(&web, CommandKind::Flush, machine, by).await
}

/// Lets a machine begin no build until it is resumed.
pub(super) async fn post_pause(
    State(web): State<Arc<DashboardState>>,
    Path(machine): Path<String>,
    RequestUser(by): RequestUser,
) -> HandlerResult<Response> {
    command_machine(&web, CommandKind::Pause, machine, by).await
}

/// Lets a paused machine begin builds again.
pub(super) async fn post_resume(
    State(web): State<Arc<DashboardState>>,
    Path(machine): Path<String>,
    RequestUser(by): RequestUser,
) -> HandlerResult<Response> {
    command_machine(&web, CommandKind::Resume, machine, by).await
}

/// Has the daemon do something with a machine.
async fn command_machine(
    web: &DashboardState,
    kind: CommandKind,
    machine: String,
    asked_by: String,
) -> HandlerResult<Response> {
    require_machine(web, &machine)?;
    let argument = CommandArgument::default();
    send(web, vec![NewCommand { kind, machine, part: None, argument, asked_by }]).await
}

fn require_machine(web: &DashboardState, machine: &str) -> HandlerResult<()> {
    check_takes_orders(web)?;
    match web.current_settings().profiles.contains_key(machine) {
        true => Ok(()),
        false => Err(HandlerError::NotFound(format!("machine {machine}"))),
    }
}

async fn require_part(web: &DashboardState, number: i64) -> HandlerResult<PartRow> {
    let part = web.ledger.find_part(PartId(number)).await?;
    part.ok_or_else(|| HandlerError::NotFound(format!("part {number}")))
}

async fn require_build(web: &DashboardState, number: i64) -> HandlerResult<BuildId> {
    check_takes_orders(web)?;
    let build = web.ledger.find_build(BuildId(number)).await?;
    build.map(|build| build.id).ok_or_else(|| HandlerError::NotFound(format!("build {number}")))
}

/// What the ledger refuses is a conflict with what it holds.
fn refusal_of_ledger(error: LedgerError) -> HandlerError {
    match is_failure_of_ledger(&error) {
        true => error.into(),
        false => HandlerError::Refused(axum::http::StatusCode::CONFLICT, error.to_string()),
    }
}
