//! What became of copies: a function of the ledger and of the plans. Where a machine has a plan, that says which of its builds lie in a
//! queue, are printed, and are over; where it has none (it is not configured any more, or on another node), what the ledger saw holds.

use language::say;
use ledger::{BuildState, LineCopies, PlacementRow};
use schemars::JsonSchema;
use serde::Serialize;

use super::build_fact::stage_of;
use crate::planning::{MachinePlan, PlanStage, PlannedPart};

/// The state of a copy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CopyWord {
    /// Told good.
    Good,
    /// Its print is over, as far as is known, and nobody told how it came out.
    Printed,
    /// It is printed.
    Printing,
    /// Its build lies in a queue.
    Queued,
    /// Its build is being made.
    InBuild,
    /// It waits for a build.
    Waiting,
    /// It is wanted and not made, because its part was refused.
    Refused,
    /// It was printed badly.
    Bad,
    /// Its build was taken back out of the queue before it was printed.
    Withdrawn,
    /// It is not wanted any more.
    Cancelled,
}

impl CopyWord {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Good,
        Self::Printed,
        Self::Printing,
        Self::Queued,
        Self::InBuild,
        Self::Waiting,
        Self::Refused,
        Self::Bad,
        Self::Withdrawn,
        Self::Cancelled,
    ];

    /// The word for people.
    pub fn word(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Printed => "should be printed",
            Self::Printing => "printing",
            Self::Queued => "in the queue",
            Self::InBuild => "in a build",
            Self::Waiting => "waiting",
            Self::Refused => "refused",
            Self::Bad => "bad",
            Self::Withdrawn => "withdrawn",
            Self::Cancelled => "cancelled",
        }
    }

    /// So many copies in this state: `3 good`. `count` may be of more: `3 of 5`.
    pub fn counted(self, count: impl language::IntoArg) -> String {
        match self {
            Self::Good => say!("copies-good", count = count),
            Self::Printed => say!("copies-printed", count = count),
            Self::Printing => say!("copies-printing", count = count),
            Self::Queued => say!("copies-queued", count = count),
            Self::InBuild => say!("copies-in-build", count = count),
            Self::Waiting => say!("copies-waiting", count = count),
            Self::Refused => say!("copies-refused", count = count),
            Self::Bad => say!("copies-bad", count = count),
            Self::Withdrawn => say!("copies-withdrawn", count = count),
            Self::Cancelled => say!("copies-cancelled", count = count),
        }
    }

    /// That of a copy in a build that counts, by the stage of its build in the plan of its machine, or else by what the ledger saw.
    fn in_build(placed: &PlacementRow, stage: Option<PlanStage>) -> Self {
        match placed.build_state {
            BuildState::Complete => Self::Good,
            BuildState::Failed | BuildState::Interrupted => Self::Printed,
            BuildState::Open | BuildState::Nesting | BuildState::Verified => Self::InBuild,
            state @ (BuildState::Published | BuildState::Printing) => match stage {
                Some(PlanStage::Cooling | PlanStage::Ended) => Self::Printed,
                Some(PlanStage::Printing | PlanStage::Taken) => Self::Printing,
                Some(_) => Self::Queued,
                None if state == BuildState::Printing || placed.is_taken => Self::Printing,
                None => Self::Queued,
            },
        }
    }
}

/// What became of a copy that was taken into a build.
pub fn copy_fact(placed: &PlacementRow, plans: &[MachinePlan]) -> CopyWord {
    match placed {
        _ if placed.is_withdrawn => CopyWord::Withdrawn,
        _ if placed.is_bad => CopyWord::Bad,
        _ => CopyWord::in_build(placed, stage_of(placed.build_id, plans)),
    }
}

/// What became of copies, of which the ledger knows how many are where; `is_of` = whether a part of a plan is among them.
pub fn copy_counts(known: &LineCopies, plans: &[MachinePlan], is_of: impl Fn(&PlannedPart) -> bool) -> LineCopies {
    let in_stages = |stages: &[PlanStage]| -> u32 {
        let builds = plans.iter().flat_map(|plan| &plan.builds).filter(|build| stages.contains(&build.stage));
        builds.flat_map(|build| &build.parts).filter(|part| is_of(part)).map(|part| part.copies).sum()
    };
    let under_way = known.queued + known.printing;
    let over = in_stages(&[PlanStage::Cooling, PlanStage::Ended]).min(under_way);
    let queued = in_stages(&[PlanStage::Queued]).min(under_way - over);
    let printing = in_stages(&[PlanStage::Printing, PlanStage::Taken]).min(under_way - over - queued);
    // Those of builds that are in no plan are where the ledger saw them.
    let unplanned = under_way - over - queued - printing;
    let queued_besides = known.queued.saturating_sub(queued).min(unplanned);
    LineCopies {
        queued: queued + queued_besides,
        printing: printing + unplanned - queued_besides,
        printed: known.printed + over,
        ..*known
    }
}

/// The states of copies with how many are in each, those of the sum of the wanted ones first; those of which there is none are left out.
pub fn counted_words(copies: &LineCopies) -> impl Iterator<Item = (u32, CopyWord)> {
    let all = [
        (copies.good, CopyWord::Good),
        (copies.printed, CopyWord::Printed),
        (copies.printing, CopyWord::Printing),
        (copies.queued, CopyWord::Queued),
        (copies.in_builds, CopyWord::InBuild),
        (copies.waiting, CopyWord::Waiting),
        (copies.refused, CopyWord::Refused),
        (copies.bad, CopyWord::Bad),
        (copies.cancelled, CopyWord::Cancelled),
    ];
    all.into_iter().filter(|(copies, _)| *copies > 0)
}
