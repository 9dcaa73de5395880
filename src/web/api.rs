//! The JSON interface: what the pages show, for machines. `openapi` says at which addresses, and describes it.

use std::sync::Arc;

use axum::{
    Json,
    extract::{Path, Query, State},
};
use schemars::JsonSchema;
use serde::Serialize;

use super::{
    history::{self, Asked},
    part,
    problem::{Answer, Problem},
    render::build_of,
    sheets::{Build, BuildSheet, Part, PartSheet, Placement},
    state::Web,
};
use crate::{
    farm::{kept_notices, standing},
    ledger::{BuildState, DaemonRow, HeightSum, HistoryRow, PartId, ProfileStatus, Utc},
    tables::{MachineForecast, ToldNotice},
};

/// The farm as it stands.
#[derive(Serialize, JsonSchema)]
pub(super) struct Farm {
    /// The daemon that serves or served the ledger.
    daemon: Option<DaemonRow>,
    /// What a person must see to.
    needs_a_person: Vec<ToldNotice>,
    /// The machines that are configured.
    profiles: Vec<Machine>,
}

/// A machine as it stands.
#[derive(Serialize, JsonSchema)]
struct Machine {
    #[serde(flatten)]
    forecast: MachineForecast,
    /// Volume of the machine, mm.
    volume_mm: [f64; 3],
    /// Whether it takes parts and gives builds, as the daemon saw it last; `None` = it was not looked at yet.
    available: Option<bool>,
    /// Why it is unavailable.
    trouble: Option<String>,
    /// Since when it is unavailable.
    trouble_at: Option<Utc>,
}

/// The farm as it stands.
pub(super) async fn farm(State(web): State<Arc<Web>>) -> Answer<Json<Farm>> {
    let (status, settings) = (web.ledger.status().await?, web.settings());
    let stations = web.ledger.stations().await?;
    let machine = |(name, profile): (&String, &crate::settings::Profile)| {
        let nothing = || ProfileStatus { profile: name.clone(), ..ProfileStatus::default() };
        let status = status.iter().find(|s| s.profile == *name).cloned().unwrap_or_else(nothing);
        let station = stations.iter().find(|station| station.profile == *name);
        Machine {
            volume_mm: profile.space.volume_mm.to_array(),
            available: station.map(|station| station.trouble.is_empty()),
            trouble: station.map(|station| station.trouble.clone()).filter(|trouble| !trouble.is_empty()),
            trouble_at: station.and_then(|station| station.trouble_at),
            forecast: MachineForecast::new(status, Some(profile)),
        }
    };
    let profiles = settings.profiles.iter().map(machine).collect();
    let needs_a_person = kept_notices(&settings.state_dir).iter().map(ToldNotice::from).collect();
    Ok(Json(Farm { daemon: web.ledger.daemon().await?, needs_a_person, profiles }))
}

/// The history, filtered as the page is.
pub(super) async fn builds(State(web): State<Arc<Web>>, Query(asked): Query<Asked>) -> Answer<Json<Vec<HistoryRow>>> {
    Ok(Json(history::rows(&web, &asked).await?))
}

/// What the published builds of the history come to, by machine; filtered as the page is.
pub(super) async fn heights(State(web): State<Arc<Web>>, Query(asked): Query<Asked>) -> Answer<Json<Vec<HeightSum>>> {
    Ok(Json(history::sums(&web, &asked).await?))
}

/// A build; one that is not proved yet with what stands in it so far, as on its page.
pub(super) async fn build(State(web): State<Arc<Web>>, Path(number): Path<i64>) -> Answer<Json<BuildSheet>> {
    let (build, profile) = build_of(&web, number).await?;
    let outcomes = all(web.ledger.outcomes(build.id).await?);
    let (mut parts, mut placements) = (Vec::new(), Vec::new());
    if matches!(build.state, BuildState::Open | BuildState::Nesting) {
        for (part, copies) in standing(&web.ledger, &build, &profile).await? {
            placements.extend(copies.iter().map(|copy| Placement::so_far(&build, part.id, copy)));
            parts.push(part.into());
        }
    } else {
        parts = all(web.ledger.parts_of_build(build.id).await?);
        placements = all(web.ledger.placements_of_build(build.id).await?);
    }
    Ok(Json(BuildSheet { build: Build::new(build, &profile), parts, placements, outcomes }))
}

/// Parts, filtered as the page is.
pub(super) async fn parts(State(web): State<Arc<Web>>, Query(asked): Query<part::Asked>) -> Answer<Json<Vec<Part>>> {
    Ok(Json(all(part::page_of(&web, &asked).await?.0)))
}

/// A part.
pub(super) async fn part(State(web): State<Arc<Web>>, Path(number): Path<i64>) -> Answer<Json<PartSheet>> {
    let id = PartId(number);
    let part = web.ledger.part(id).await?.ok_or_else(|| Problem::NotFound(format!("part {number}")))?;
    let (placements, events) = (web.ledger.placements_of_part(id).await?, web.ledger.events_of_part(id).await?);
    let same = web.ledger.parts_of_content(&part.file.content_hash).await?;
    let same_content = same.into_iter().map(|other| other.id).filter(|other| *other != id).collect();
    Ok(Json(PartSheet { part: part.into(), placements: all(placements), events: all(events), same_content }))
}

/// Rows of the ledger as they are told.
fn all<T, R: From<T>>(rows: Vec<T>) -> Vec<R> {
    rows.into_iter().map(R::from).collect()
}
