//! The earliest date of an order, and the date that is kept with 95 %. These are functions of facts and time: the plan is made with the
//! order in it, as if it had arrived now.

use std::sync::Arc;

use jiff::Timestamp;
use ledger::{PartId, PartRow};
use settings::MachineProfile;

use super::{
    build_plan::{ComingBuild, add_secs, plan_builds},
    date_outlook::EndReserve,
    plan_facts::{PlanFacts, PlanLine},
    reprint_odds::ReprintOdds,
};

/// A due date moves those of others; the date is sought in so many steps at most.
const MAX_STEPS: usize = 5;

/// The plan of a machine with an order in it.
#[derive(Debug, Clone)]
pub struct PlanWithOrder {
    /// The due date that the order has in it.
    pub due_at: Timestamp,
    /// The builds to come.
    pub builds: Vec<ComingBuild>,
    /// When the last of the order can be unpacked, and the place of its build; `None` = that is not known.
    pub done: Option<(Timestamp, usize)>,
}

/// The facts with the parts of an order in them, due then. `stands`: they stand in the layout of the facts.
pub fn facts_with_order(
    profile: &MachineProfile,
    facts: &PlanFacts,
    order: &[Arc<PartRow>],
    due_at: Timestamp,
    stands: bool,
) -> PlanFacts {
    let mut facts = facts.clone();
    for part in order {
        let mut part = (**part).clone();
        part.terms.due_at = Some(due_at.into());
        let copies = part.owed.copies;
        facts.insert_line(PlanLine::new(profile, Arc::new(part), copies, stands));
    }
    facts
}

/// Whether a build holds parts of the order.
pub fn holds_order(build: &ComingBuild, order: &[Arc<PartRow>]) -> bool {
    let is_of = |id: PartId| order.iter().any(|part| part.id == id);
    build.lines.iter().any(|line| is_of(line.part.id))
}

/// The plan with an order in it that is due then.
pub fn plan_with_order(
    profile: &MachineProfile,
    facts: &PlanFacts,
    order: &[Arc<PartRow>],
    (due_at, stands): (Timestamp, bool),
    now: Timestamp,
) -> PlanWithOrder {
    let builds = plan_builds(profile, &facts_with_order(profile, facts, order, due_at, stands), now);
    let ends = |build: &ComingBuild| build.print.map(|print| print.ends_at).filter(|at| *at < Timestamp::MAX);
    let of_order: Vec<usize> = (0..builds.len()).filter(|&at| holds_order(&builds[at], order)).collect();
    let of_part = |id: PartId| order.iter().any(|part| part.id == id);
    let lines = builds.iter().flat_map(|build| &build.lines).filter(|line| of_part(line.part.id));
    let planned: u64 = lines.map(|line| u64::from(line.copies)).sum();
    let is_whole = planned == order.iter().map(|part| u64::from(part.owed.copies)).sum::<u64>();
    let all_end = is_whole && of_order.iter().all(|&at| ends(&builds[at]).is_some());
    let last = of_order.iter().filter_map(|&at| Some((ends(&builds[at])?, at))).max();
    PlanWithOrder { due_at, done: last.filter(|_| all_end), builds }
}

/// The plan in which the order has the earliest due date that the plan keeps.
pub fn plan_earliest(
    profile: &MachineProfile,
    facts: &PlanFacts,
    order: &[Arc<PartRow>],
    stands: bool,
    now: Timestamp,
) -> PlanWithOrder {
    // At first, as if it were overdue: nothing goes before it but what is overdue itself.
    let mut plan = plan_with_order(profile, facts, order, (now, stands), now);
    for _ in 0..MAX_STEPS {
        let Some((ends_at, _)) = plan.done.filter(|(ends_at, _)| *ends_at > plan.due_at) else { break };
        plan = plan_with_order(profile, facts, order, (ends_at, stands), now);
    }
    plan
}

/// The time that is held back so that a date is kept with 95 %: prints that take longer, builds that get higher, and copies that
/// have to be printed again.
pub fn time_held_back(
    profile: &MachineProfile,
    facts: &PlanFacts,
    (build, copies): (&ComingBuild, u32),
    (reserve, odds): (EndReserve, &ReprintOdds),
    now: Timestamp,
) -> f64 {
    let spread_secs = reserve.span_of(facts, build.height_mm, build.is_nested).as_secs_f64();
    let again = odds.rounds_needed(copies).saturating_sub(1);
    if again == 0 {
        return spread_secs;
    }
    let busy = facts.outlook.printers.iter().map(|printer| printer.free_at).min().unwrap_or(now);
    let height_mm = odds.usual_height_mm.unwrap_or(build.height_mm).max(build.height_mm);
    let estimate_secs = busy.duration_since(now).as_secs_f64().max(0.0)
        + facts.outlook.times.occupied(height_mm).as_secs_f64()
        + spread_secs;
    let round_secs = odds.turnaround_hours.map_or(estimate_secs, |hours| 3600.0 * hours);
    let begin_secs = profile.trigger.gather_secs + profile.search.final_secs;
    spread_secs + f64::from(again) * (begin_secs + round_secs)
}

/// The due date for the ticket of an order whose customer was promised a date: so much earlier that the promise is kept with 95 %,
/// where that is possible. Without a promise, the earliest one.
pub fn ticket_date(earliest: Timestamp, held_back_secs: f64, promised: Option<Timestamp>) -> Timestamp {
    promised.map_or(earliest, |promised| add_secs(promised, -held_back_secs)).max(earliest)
}

/// The date that is kept with 95 %.
pub fn date_kept(ends_at: Timestamp, held_back_secs: f64) -> Timestamp {
    add_secs(ends_at, held_back_secs)
}
