//! How far a build is: as its machine plans it while it is under way, and as the ledger has it otherwise.

use ledger::{BuildId, BuildRow, BuildState, UtcTimestamp};

use crate::farm::planning::{MachinePlan, PlanStage};

/// What is so of a build.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BuildFact {
    /// How far it is: one of the words of the plan, or the state of the ledger.
    pub word: String,
    /// When its parts can be unpacked, as far as is known.
    pub ends_at: Option<UtcTimestamp>,
}

impl PlanStage {
    /// The stage in words. `awaits_release` = the build waits for a person's yes.
    pub fn word(self, awaits_release: bool) -> &'static str {
        match self {
            Self::Ended => "should be done",
            Self::Cooling => "cooling",
            Self::Printing => "printing",
            Self::Queued => "in the queue",
            Self::Made if awaits_release => "waits for a yes",
            Self::Made => "being made",
            Self::Open => "open",
            Self::Later => "later",
        }
    }
}

/// What is so of a build. `plan` is that of its machine; `None` = the machine is not configured any more.
pub fn build_fact(build: &BuildRow, plan: Option<&MachinePlan>) -> BuildFact {
    let is_under_way = matches!(build.state, BuildState::Published | BuildState::Printing);
    let is_it = |id: Option<BuildId>| id == Some(build.id);
    let planned = plan.and_then(|plan| plan.builds.iter().find(|planned| is_it(planned.build)));
    BuildFact {
        word: match planned.filter(|_| is_under_way) {
            Some(planned) => planned.stage.word(planned.awaits_release).to_owned(),
            None => build.state_word(),
        },
        ends_at: planned.and_then(|planned| planned.ends_at),
    }
}
