//! The JSON interface: what the pages show, for machines. `openapi` says at which addresses, and describes it.

use std::{sync::Arc, time::Duration};

use axum::{
    Json,
    extract::{Path, State},
    http::StatusCode,
};
use farm::{
    AlertSummary, DateRisk, DatedBuild, FarmReading, MachineFact, MachinePlan, alerts_of_farm, build_fact, copy_counts,
    load_placed_parts, read_plans,
};
use jiff::Timestamp;
use ledger::{BuildState, EventRow, HeightSummary, Ledger, MachineStatus, NodeRow, PartId, UtcTimestamp};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use settings::{MachineProfile, NotificationKind};

use super::dto::{BuildResource, BuildResponse, PartResource, PartResponse, PlacementResource, RecordResponse};
use crate::{
    outbox::{EventMessage, MessageBody, event_kinds, message_id},
    tables::{FarmNode, MachineForecast, list_farm_nodes},
    web::{
        base::{
            error::{HandlerError, HandlerResult},
            query::Query,
        },
        core::{cached_render::find_build, state::DashboardState},
        pages::{
            history::{self, HistoryFilter},
            live::MAX_LISTENERS,
            part,
        },
        paper::record_page::MadePart,
    },
};

/// The farm as it stands.
#[derive(Serialize, JsonSchema)]
pub(crate) struct FarmResponse {
    /// The daemon of this node.
    daemon: Option<NodeRow>,
    /// All nodes of the farm, with their machines.
    nodes: Vec<FarmNode>,
    /// What a person must see to.
    needs_a_person: Vec<AlertSummary>,
    /// The machines that are configured.
    machines: Vec<MachineResource>,
    /// What is late, or at risk to be, by due date.
    dates_at_risk: Vec<DateRisk>,
}

/// A machine as it stands.
#[derive(Serialize, JsonSchema)]
struct MachineResource {
    #[serde(flatten)]
    forecast: MachineForecast,
    /// Volume of the machine, mm.
    volume_mm: [f64; 3],
    /// Whether it takes parts and gives builds, as the daemon saw it last; `None` = it was not looked at yet.
    available: Option<bool>,
    /// Why it is unavailable.
    trouble: Option<String>,
    /// Since when it is unavailable.
    trouble_at: Option<UtcTimestamp>,
}

/// The current state of the farm.
pub(super) async fn get_farm(State(web): State<Arc<DashboardState>>) -> HandlerResult<Json<FarmResponse>> {
    let (settings, now) = (web.current_settings(), Timestamp::now());
    let reading = FarmReading::read(&web.ledger, settings.profiles.values(), now).await?;
    let machine = |((name, profile), fact): ((&String, &settings::MachineProfile), MachineFact)| {
        let status = MachineStatus::of_machine(&reading.rows.statuses, name);
        let observed = reading.rows.observed(name);
        MachineResource {
            volume_mm: profile.space.volume_mm.to_array(),
            available: observed.map(|observed| observed.trouble.is_empty()),
            trouble: observed.map(|observed| observed.trouble.clone()).filter(|trouble| !trouble.is_empty()),
            trouble_at: observed.and_then(|observed| observed.trouble_at),
            forecast: MachineForecast::new(status, Some(profile), fact, now),
        }
    };
    let resources = settings.profiles.iter().zip(reading.facts()).map(machine).collect();
    let nodes = list_farm_nodes(&web.ledger).await?;
    let alerts = alerts_of_farm(&settings, nodes.iter().map(|listed| &listed.node));
    let needs_a_person = alerts.iter().map(AlertSummary::from).collect();
    let at_risk = reading.dates_at_risk(&web.ledger).await?;
    let daemon = web.ledger.find_node(&settings.node.name).await?;
    Ok(Json(FarmResponse { daemon, nodes, needs_a_person, machines: resources, dates_at_risk: at_risk }))
}

/// The history, filtered as the page is.
pub(super) async fn list_builds(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<HistoryFilter>,
) -> HandlerResult<Json<Vec<DatedBuild>>> {
    Ok(Json(history::list_rows(&web, &asked).await?))
}

/// The sums of the published builds by machine, filtered as the history page is.
pub(super) async fn list_height_sums(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<HistoryFilter>,
) -> HandlerResult<Json<Vec<HeightSummary>>> {
    Ok(Json(history::read_height_sums(&web, &asked).await?))
}

/// A build. One that is not proved yet comes with its current layout, as on its page.
pub(super) async fn get_build(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
) -> HandlerResult<Json<BuildResponse>> {
    let (build, profile) = find_build(&web, number).await?;
    let outcomes = convert_rows(web.ledger.outcomes_of_build(build.id).await?);
    let (mut parts, mut placements) = (Vec::new(), Vec::new());
    if matches!(build.state, BuildState::Open | BuildState::Nesting) {
        for (part, copies) in load_placed_parts(&web.ledger, &build, &profile).await? {
            placements.extend(copies.iter().map(|copy| PlacementResource::from_open_layout(&build, part.id, copy)));
            parts.push(part.into());
        }
    } else {
        parts = convert_rows(web.ledger.parts_of_build(build.id).await?);
        placements = convert_rows(web.ledger.placements_of_build(build.id).await?);
    }
    let settings = web.current_settings();
    let plans = read_plans(&web.ledger, settings.profiles.get(&build.machine), Timestamp::now()).await?;
    let fact = build_fact(&build, &plans);
    Ok(Json(BuildResponse { build: BuildResource::new(build, fact, &profile), parts, placements, outcomes }))
}

/// Parts, filtered as the page is.
pub(crate) async fn list_parts(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<part::PartFilter>,
) -> HandlerResult<Json<Vec<PartResource>>> {
    Ok(Json(convert_rows(part::read_page(&web, &asked).await?.0)))
}

/// A part.
pub(super) async fn get_part(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
) -> HandlerResult<Json<PartResponse>> {
    let id = PartId(number);
    let part = web.ledger.find_part(id).await?.ok_or_else(|| HandlerError::NotFound(format!("part {number}")))?;
    let (placements, events) = (web.ledger.placements_of_part(id).await?, web.ledger.events_of_part(id).await?);
    let known = web.ledger.line_of_part(id).await?.copies;
    let copies_now = copy_counts(&known, &web.read_plans().await?, |planned| planned.part == id);
    let same = web.ledger.parts_with_content(&part.file.content_hash).await?;
    let same_content = same.into_iter().map(|other| other.id).filter(|other| *other != id).collect();
    Ok(Json(PartResponse {
        part: part.into(),
        copies_now,
        placements: convert_rows(placements),
        events: convert_rows(events),
        same_content,
    }))
}

/// How the copies of a part were made.
pub(super) async fn get_record(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
) -> HandlerResult<Json<RecordResponse>> {
    let MadePart { part, finishing, builds } = MadePart::read(&web, number).await?;
    Ok(Json(RecordResponse { part: part.into(), finishing: finishing.steps, builds }))
}

/// Converts rows of the ledger to their JSON form.
fn convert_rows<T, R: From<T>>(rows: Vec<T>) -> Vec<R> {
    rows.into_iter().map(R::from).collect()
}

/// Most events of an answer, and as many as it has where nobody says it.
const MAX_EVENTS: u32 = 500;
const USUAL_EVENTS: u32 = 100;
/// A question waits for events no longer than this, seconds: a connection without an answer is cut.
const MAX_WAIT_SECS: u32 = 8;

/// Which events are asked for.
#[derive(Debug, Clone, Deserialize, Serialize, JsonSchema)]
#[serde(default)]
#[schemars(inline)]
pub(crate) struct EventQuestion {
    /// Only events after this one: `last` of the answer before, an id, or a number; empty = from the first.
    after: String,
    /// Most events of the answer, 1 to 500.
    limit: u32,
    /// How long to wait for an event where there is none yet, seconds; at most 8.
    wait: u32,
}

impl Default for EventQuestion {
    fn default() -> Self {
        Self { after: String::new(), limit: USUAL_EVENTS, wait: 0 }
    }
}

/// Events in the order of their numbers.
#[derive(Serialize, JsonSchema)]
pub(crate) struct EventsResponse {
    /// The events, as a webhook gets them.
    events: Vec<MessageBody>,
    /// What to ask for next, as `after`: nothing up to this one is missing.
    last: String,
}

/// The events after one, each once.
pub(super) async fn get_events(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<EventQuestion>,
) -> HandlerResult<Json<EventsResponse>> {
    if !(1..=MAX_EVENTS).contains(&asked.limit) || asked.wait > MAX_WAIT_SECS {
        let text = format!("limit is 1 to {MAX_EVENTS}, and wait at most {MAX_WAIT_SECS} seconds");
        return Err(HandlerError::Refused(StatusCode::BAD_REQUEST, text));
    }
    let deadline = tokio::time::Instant::now() + Duration::from_secs(asked.wait.into());
    // Whoever finds no place among those who wait is answered at once.
    let mut changes = (asked.wait > 0 && web.changes.receiver_count() < MAX_LISTENERS).then(|| web.changes.subscribe());
    loop {
        let answer = read_events(&web.ledger, &asked).await?;
        let Some(changes) = changes.as_mut().filter(|_| answer.events.is_empty()) else { return Ok(Json(answer)) };
        if !matches!(tokio::time::timeout_at(deadline, changes.changed()).await, Ok(Ok(()))) {
            return Ok(Json(answer));
        }
    }
}

async fn read_events(ledger: &Ledger, asked: &EventQuestion) -> HandlerResult<EventsResponse> {
    // Before the events: what is written meanwhile belongs to the next answer.
    let latest = ledger.last_event_id().await?;
    let after = number_of_event(ledger, &asked.after, latest).await?;
    let rows = ledger.events_after(after, &event_kinds(&NotificationKind::ALL), asked.limit).await?;
    let is_all = rows.len() < asked.limit as usize;
    let rows: Vec<EventRow> = rows.into_iter().filter(|row| row.id <= latest).collect();
    let last = match rows.last() {
        Some(row) if !is_all => Some(row.clone()),
        _ => ledger.find_event(latest).await?,
    };
    let mut events = Vec::new();
    for row in &rows {
        events.push(EventMessage::from_event(row, ledger).await?.json);
    }
    Ok(EventsResponse { events, last: last.map_or_else(|| "0".to_owned(), |row| message_id(&row)) })
}

/// The number of the event that was the last for whoever asks. A ledger that has another event of this number, or none yet, was put back
/// to an earlier time: the events after that number are not those that follow what the program knows.
async fn number_of_event(ledger: &Ledger, after: &str, latest: i64) -> HandlerResult<i64> {
    let number = after.split('@').next().unwrap_or_default();
    let Ok(number) = (if number.is_empty() { Ok(0) } else { number.parse::<i64>() }) else {
        return Err(HandlerError::Refused(
            StatusCode::BAD_REQUEST,
            "after is the id of an event, or its number".to_owned(),
        ));
    };
    let is_known = match after.contains('@') {
        true => ledger.find_event(number).await?.is_some_and(|row| message_id(&row) == after),
        false => number <= latest,
    };
    match is_known {
        true => Ok(number),
        false => {
            let text = format!(
                "this ledger does not have the event {after}: it was put back to an earlier time. Its latest event is {latest}; ask without after \
                 and drop what you know"
            );
            Err(HandlerError::Refused(StatusCode::CONFLICT, text))
        }
    }
}

/// Whose plan is asked for.
#[derive(Debug, Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(default)]
#[schemars(inline)]
pub(crate) struct PlanQuestion {
    /// Only this machine; all if empty.
    machine: String,
}

/// The plans as JSON.
pub(crate) async fn get_plans(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<PlanQuestion>,
) -> HandlerResult<Json<Vec<MachinePlan>>> {
    Ok(Json(make_plans(&web, &asked).await?))
}

async fn make_plans(web: &DashboardState, asked: &PlanQuestion) -> HandlerResult<Vec<MachinePlan>> {
    let (settings, now) = (web.current_settings(), Timestamp::now());
    if !asked.machine.is_empty() && !settings.profiles.contains_key(&asked.machine) {
        return Err(HandlerError::NotFound(format!("machine {}", asked.machine)));
    }
    let is_asked = |profile: &&MachineProfile| asked.machine.is_empty() || asked.machine == profile.name;
    Ok(read_plans(&web.ledger, settings.profiles.values().filter(is_asked), now).await?)
}
