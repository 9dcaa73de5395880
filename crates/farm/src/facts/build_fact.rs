//! How far a build is: as its machine plans it while it is under way, and as the ledger has it otherwise.

use anyhow::Result;
use jiff::Timestamp;
use ledger::{BuildId, BuildRow, BuildState, HistoryRow, Ledger, NamedBuildRow, PlacementRow, UtcTimestamp};
use schemars::JsonSchema;
use serde::Serialize;
use settings::MachineProfile;

use super::read_facts::read_plans;
use crate::planning::{MachinePlan, PlanStage, PlannedBuild};

/// What is so of a build.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct BuildFact {
    /// How far it is, for people: one of the words of the plan, or the state of the ledger.
    #[serde(rename = "state_word")]
    pub word: String,
    /// When its parts can be unpacked, as far as is known, to the minute; `None` = that is not known, or its print was told.
    pub ends_at: Option<UtcTimestamp>,
}

impl PlanStage {
    /// Whether its print has begun, as far as is known.
    pub fn has_begun(self) -> bool {
        matches!(self, Self::Printing | Self::Cooling | Self::Ended)
    }

    /// The stage in words. `awaits_release` = the build waits for a person's yes.
    pub fn word(self, awaits_release: bool) -> &'static str {
        match self {
            Self::Ended => "should be done",
            Self::Cooling => "cooling",
            Self::Printing => "printing",
            Self::Taken => "at the printer",
            Self::Queued => "in the queue",
            Self::Made if awaits_release => "waits for a yes",
            Self::Made => "being made",
            Self::Open => "open",
            Self::Later => "later",
        }
    }
}

/// A build of the history, and what is so of it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DatedBuild {
    /// Its row.
    #[serde(flatten)]
    pub row: HistoryRow,
    /// How far it is.
    #[serde(flatten)]
    pub fact: BuildFact,
}

impl DatedBuild {
    /// Builds of the history with what is so of them.
    ///
    /// # Errors
    /// The ledger cannot be read.
    pub async fn of_rows<'p>(
        ledger: &Ledger,
        profiles: impl IntoIterator<Item = &'p MachineProfile>,
        rows: Vec<HistoryRow>,
        now: Timestamp,
    ) -> Result<Vec<Self>> {
        // Of builds that are over, no plan says more.
        let plans = match rows.iter().any(|row| is_under_way(row.state)) {
            true => read_plans(ledger, profiles, now).await?,
            false => Vec::new(),
        };
        let dated = |row: HistoryRow| {
            let fact = fact_of((row.build, row.state, row.is_taken), row.state_word(), &plans);
            Self { row, fact }
        };
        Ok(rows.into_iter().map(dated).collect())
    }
}

/// What is so of a build.
pub fn build_fact(build: &BuildRow, plans: &[MachinePlan]) -> BuildFact {
    fact_of((build.id, build.state, build.place.taken_at.is_some()), build.state_word(), plans)
}

/// What is so of the build that a copy was taken into.
pub fn build_of_copy(placed: &PlacementRow, plans: &[MachinePlan]) -> BuildFact {
    let word = if placed.is_withdrawn { "withdrawn".to_owned() } else { placed.build_state.to_string() };
    fact_of((placed.build_id, placed.build_state, placed.is_taken), word, plans)
}

/// What is so of a build that a search found.
pub fn build_of_search(build: &NamedBuildRow, plans: &[MachinePlan]) -> BuildFact {
    fact_of((build.id, build.state, build.taken_at.is_some()), build.state_word(), plans)
}

/// Whether the plan of its machine says more of a build than the ledger.
fn is_under_way(state: BuildState) -> bool {
    matches!(state, BuildState::Verified | BuildState::Published | BuildState::Printing)
}

/// `is_taken` = its printer took its file, as far as is known.
fn fact_of((build, state, is_taken): (BuildId, BuildState, bool), word: String, plans: &[MachinePlan]) -> BuildFact {
    let planned = planned_build(build, plans);
    BuildFact {
        word: match planned.filter(|_| is_under_way(state)) {
            Some(planned) => planned.stage.word(planned.awaits_release).to_owned(),
            None if state == BuildState::Published && is_taken => PlanStage::Taken.word(false).to_owned(),
            None => word,
        },
        ends_at: planned.and_then(|planned| planned.ends_at),
    }
}

fn planned_build(build: BuildId, plans: &[MachinePlan]) -> Option<&PlannedBuild> {
    plans.iter().flat_map(|plan| &plan.builds).find(|planned| planned.build == Some(build))
}

/// When the parts of a build can be unpacked, according to the plan of its machine.
pub(super) fn ends_of(build: BuildId, plans: &[MachinePlan]) -> Option<UtcTimestamp> {
    planned_build(build, plans)?.ends_at
}

/// How far a build is in the plan of its machine; `None` = it is in none.
pub(super) fn stage_of(build: BuildId, plans: &[MachinePlan]) -> Option<PlanStage> {
    planned_build(build, plans).map(|planned| planned.stage)
}
