//! A quote: the earliest date of parts on a machine, a date that is kept with 95 %, and what they add. Nothing is taken or changed.

use std::{sync::Arc, time::Duration};

use build_file::format_count;
use jiff::Timestamp;
use ledger::{BuildId, PartRow, UtcTimestamp};
use schemars::JsonSchema;
use serde::Serialize;
use settings::{FarmZone, MachineProfile, Money, PriceSum};

use super::{
    build_plan::{ComingBuild, plan_builds},
    earliest_date::{
        PlanWithOrder, date_kept, holds_order, plan_earliest, plan_with_order, ticket_date, time_held_back,
    },
    machine_plan::{DateRisk, find_risks},
    plan_facts::{PlanFacts, StandingLayout},
    plan_reading::PlanReading,
    quote_insertion::{QuoteInsertion, QuoteMeshes},
    quoted_part::QuotedPart,
    reprint_odds::ReprintOdds,
};

/// Time that the insertion into the open build may take: a quote takes less than two seconds.
pub const QUOTE_SEARCH_TIME: Duration = Duration::from_millis(1400);

/// What a quote says.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct OrderQuote {
    /// The machine.
    pub machine: String,
    /// When it was made. It holds as long as nothing else arrives.
    pub quoted_at: UtcTimestamp,
    /// Copies that it is for.
    pub copies: u32,
    /// The earliest time at which all of them can be unpacked; `None` = it is not known.
    pub earliest_at: Option<UtcTimestamp>,
    /// A date that is kept with 95 %: it holds back time for prints that take longer, and for copies that are printed again.
    pub kept_at: Option<UtcTimestamp>,
    /// The due date to give to the ticket, so that this time is not used up by waiting: for the date that was asked for, if it can be
    /// kept, else for the one that is kept with 95 %.
    pub ticket_due_at: Option<UtcTimestamp>,
    /// The due date that was asked for.
    pub due_at: Option<UtcTimestamp>,
    /// How that date stands.
    pub answer: Option<DueAnswer>,
    /// The open build, if all of them would be in it.
    pub build: Option<BuildId>,
    /// Number of builds that they would be in.
    pub builds: u32,
    /// Height of these builds with them, mm.
    pub height_mm: f64,
    /// Height that they add to all builds to come, mm.
    pub added_mm: f64,
    /// Height that they add to the layout of the open build at most, mm, before it is searched again; `None` = they found no place
    /// there, or it was not tried to the end.
    pub added_at_most_mm: Option<f64>,
    /// Their share of these builds by volume, 0..1.
    pub share: f64,
    /// Hours of printing that are theirs by that share.
    pub print_hours: f64,
    /// Volume of the cake that is theirs by that share, litres; their own volume is in it.
    pub cake_litres: f64,
    /// Their own volume, litres.
    pub part_litres: f64,
    /// What that costs by the rates of the machine; `None` = nothing has a price.
    #[serde(flatten)]
    pub price: Option<PriceSum>,
    /// Due dates that would be late only because of them.
    pub delays: Vec<DateRisk>,
}

/// How a due date that was asked for stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DueAnswer {
    /// It is kept with 95 %.
    Kept,
    /// It is kept if everything goes well.
    Tight,
    /// It is not kept.
    Late,
}

/// What a quote is asked for.
#[derive(Debug)]
pub struct QuoteQuestion {
    /// The parts.
    pub parts: Vec<QuotedPart>,
    /// The due date that is wished for.
    pub due_at: Option<Timestamp>,
    /// The time that the search may take.
    pub within: Duration,
}

/// Makes a quote. `busy` is dropped when all work for it has ended.
pub fn quote_order(
    profile: &Arc<MachineProfile>,
    reading: &PlanReading,
    question: QuoteQuestion,
    meshes: &QuoteMeshes,
    busy: impl Send + 'static,
    now: Timestamp,
) -> OrderQuote {
    let order: Vec<Arc<PartRow>> = question.parts.iter().map(|part| part.row.clone()).collect();
    let due_at = question.due_at;
    let estimated = plan_earliest(profile, &reading.facts, &order, false, now);
    let (mut facts, mut added_at_most_mm, mut stands) = (reading.facts.clone(), None, false);
    let before_mm = facts.layout.map_or(0.0, |layout| layout.height_mm);
    // What waits and stands in no layout yet is not searched for a quote.
    let is_known = facts.layout.is_some() || facts.lines.is_empty();
    if let Some(open) = joined_open_build(&estimated, &order).filter(|_| is_known) {
        let (waiting, placed) = (reading.waiting.clone(), reading.placed.clone());
        let insertion = QuoteInsertion { profile: profile.clone(), waiting, placed, parts: question.parts };
        let found_mm = insertion.find_height_mm(meshes, question.within, busy);
        added_at_most_mm = found_mm.map(|found_mm| found_mm - before_mm);
        // A search finds lower layouts than one insertion: where that is higher than the estimate, the estimate counts.
        if let Some(height_mm) = found_mm.filter(|found_mm| *found_mm <= open.height_mm || facts.lines.is_empty()) {
            facts.layout = Some(layout_with(&facts, &order, open, height_mm));
            stands = true;
        }
    }
    let earliest = if stands { plan_earliest(profile, &facts, &order, stands, now) } else { estimated };
    let copies = order.iter().map(|part| part.owed.copies).sum();
    let odds = ReprintOdds::learn(&reading.experience);
    let held_back = earliest.done.map(|(done, at)| {
        let build = (&earliest.builds[at], copies);
        (done, time_held_back(profile, &facts, build, (reading.reserve, &odds), now))
    });
    let kept_at = held_back.map(|(done, held_secs)| date_kept(done, held_secs));
    let ticket_at = held_back.map(|(done, held_secs)| ticket_date(done, held_secs, due_at));
    let planned = ticket_at.map(|ticket_at| plan_with_order(profile, &facts, &order, (ticket_at, stands), now));
    let base = plan_builds(profile, &reading.facts, now);
    let shares = OrderShares::of(profile, &facts, planned.as_ref().unwrap_or(&earliest), &order, &base);
    let minute = |at: Timestamp| UtcTimestamp(at.round(jiff::Unit::Minute).unwrap_or(at));
    let earliest_at = earliest.done.map(|(done, _)| done);
    OrderQuote {
        machine: profile.name.clone(),
        quoted_at: UtcTimestamp(now),
        copies,
        earliest_at: earliest_at.map(minute),
        kept_at: kept_at.map(minute),
        ticket_due_at: ticket_at.map(minute),
        due_at: due_at.map(UtcTimestamp),
        answer: due_at.map(|due_at| match (earliest_at, kept_at) {
            (_, Some(kept)) if kept <= due_at => DueAnswer::Kept,
            (Some(earliest), _) if earliest <= due_at => DueAnswer::Tight,
            _ => DueAnswer::Late,
        }),
        build: shares.open,
        builds: shares.builds,
        height_mm: shares.height_mm,
        added_mm: shares.added_mm,
        added_at_most_mm,
        share: shares.share,
        print_hours: shares.print_hours,
        cake_litres: shares.cake_litres,
        part_litres: shares.part_litres,
        price: shares.price(profile, copies),
        delays: find_delays(profile, reading, (&base, planned.as_ref().unwrap_or(&earliest)), &order, now),
    }
}

/// The open build, or the first one, if all parts of the order are in it.
fn joined_open_build<'p>(plan: &'p PlanWithOrder, order: &[Arc<PartRow>]) -> Option<&'p ComingBuild> {
    let mut with = plan.builds.iter().filter(|build| holds_order(build, order));
    let (first, other) = (with.next()?, with.next());
    let open = plan.builds.iter().find(|build| !build.lines.is_empty())?;
    (other.is_none() && std::ptr::eq(first, open)).then_some(open)
}

/// The layout of the open build with the order in it.
fn layout_with(facts: &PlanFacts, order: &[Arc<PartRow>], open: &ComingBuild, height_mm: f64) -> StandingLayout {
    let each = |part: &Arc<PartRow>| f64::from(part.owed.copies) * part.measures.volume_mm3.unwrap_or(0.0);
    let added_mm3: f64 = order.iter().map(each).sum();
    let before_mm3 = facts.layout.map_or(0.0, |layout| layout.part_volume_mm3);
    let build = facts.layout.map_or(open.build, |layout| layout.build);
    StandingLayout { build, height_mm, part_volume_mm3: before_mm3 + added_mm3 }
}

/// What part of the builds to come is that of an order.
struct OrderShares {
    open: Option<BuildId>,
    builds: u32,
    height_mm: f64,
    /// Height that is theirs by volume, mm.
    own_mm: f64,
    added_mm: f64,
    share: f64,
    print_hours: f64,
    cake_litres: f64,
    part_litres: f64,
}

impl OrderShares {
    fn of(
        profile: &MachineProfile,
        facts: &PlanFacts,
        plan: &PlanWithOrder,
        order: &[Arc<PartRow>],
        base: &[ComingBuild],
    ) -> Self {
        let base_mm2 = profile.space.volume_mm.x * profile.space.volume_mm.y;
        let sum_mm = |builds: &[ComingBuild]| builds.iter().map(|build| build.height_mm).sum::<f64>();
        let with: Vec<&ComingBuild> = plan.builds.iter().filter(|build| holds_order(build, order)).collect();
        let volume_mm3 = |build: &ComingBuild| -> f64 {
            let of_order = build.lines.iter().filter(|line| order.iter().any(|part| part.id == line.part.id));
            of_order.map(|line| f64::from(line.copies) * line.each_mm3).sum()
        };
        let share = |build: &ComingBuild| volume_mm3(build) / build.volume_mm3.max(1e-9);
        let height_mm: f64 = with.iter().map(|build| build.height_mm).sum();
        let own_mm: f64 = with.iter().map(|build| share(build) * build.height_mm).sum();
        Self {
            open: with.first().and_then(|build| build.build).filter(|_| with.len() == 1),
            builds: u32::try_from(with.len()).unwrap_or(u32::MAX),
            height_mm,
            own_mm,
            added_mm: (sum_mm(&plan.builds) - sum_mm(base)).max(0.0),
            share: own_mm / height_mm.max(1e-9),
            print_hours: facts.outlook.times.print_hours(own_mm),
            cake_litres: 1e-6 * base_mm2 * own_mm,
            part_litres: 1e-6 * with.iter().map(|build| volume_mm3(build)).sum::<f64>(),
        }
    }
}

impl OrderShares {
    /// What they cost, as their builds are priced later.
    fn price(&self, profile: &MachineProfile, copies: u32) -> Option<PriceSum> {
        let hours = self.own_mm * profile.space.print_hours_per_mm;
        let price = Money::rounded(profile.costs.price(hours, self.part_litres, copies));
        profile.costs.has_prices().then(|| PriceSum { price, currency: profile.costs.currency.clone() })
    }
}

/// The due dates of others that are late with the order, and not without it.
fn find_delays(
    profile: &MachineProfile,
    reading: &PlanReading,
    (base, plan): (&[ComingBuild], &PlanWithOrder),
    order: &[Arc<PartRow>],
    now: Timestamp,
) -> Vec<DateRisk> {
    let late = |builds: &[ComingBuild]| -> Vec<DateRisk> {
        find_risks(profile, reading, builds, now).into_iter().filter(|risk| risk.is_late).collect()
    };
    let mut others = plan.builds.clone();
    others.iter_mut().for_each(|build| build.lines.retain(|line| !order.iter().any(|part| part.id == line.part.id)));
    let before = late(base);
    // Parts without an order stand for themselves.
    let is_same = |known: &DateRisk, risk: &DateRisk| {
        let is_of_order = !risk.order.is_empty() || known.parts == risk.parts;
        is_of_order && (&known.order, known.due_at) == (&risk.order, risk.due_at)
    };
    let is_new = |risk: &DateRisk| !before.iter().any(|known| is_same(known, risk));
    late(&others).into_iter().filter(is_new).collect()
}

impl OrderQuote {
    /// The quote in sentences.
    pub fn sentences(&self, zone: &FarmZone) -> Vec<String> {
        let time = |at: UtcTimestamp| zone.format_minute(at.0);
        let copies = format_count(self.copies, "copy", "copies");
        let mut sentences = vec![match (self.earliest_at, self.kept_at) {
            (Some(earliest), Some(kept)) => format!(
                "{copies} on {}: at {} at the earliest; {} is kept with 95 %.",
                self.machine,
                time(earliest),
                time(kept)
            ),
            _ => format!("{copies} on {}: it is not known when they would be printed.", self.machine),
        }];
        if let Some(ticket) = self.ticket_due_at {
            sentences.push(format!("Give the ticket the due date {}.", time(ticket)));
        }
        if let (Some(due_at), Some(answer)) = (self.due_at, self.answer) {
            let how = match answer {
                DueAnswer::Kept => "is kept with 95 %",
                DueAnswer::Tight => "is kept if everything goes well",
                DueAnswer::Late => "is not kept",
            };
            sentences.push(format!("The date asked for, {}, {how}.", time(due_at)));
        }
        let place = match (self.build, self.builds) {
            (Some(build), _) => format!("build {build}, which would be {:.1} mm high", self.height_mm),
            (None, 1) => format!("a build that would be about {:.0} mm high", self.height_mm),
            (None, builds) => format!("{builds} builds, about {:.0} mm high together", self.height_mm),
        };
        let at_most = self.added_at_most_mm.map_or_else(String::new, |mm| format!(" (at most {:.1} mm)", mm.max(0.0)));
        sentences.push(format!("They would be in {place}, and add {:.1} mm{at_most}.", self.added_mm));
        sentences.push(format!(
            "Their share is {:.1} %: {:.1} h of printing and {:.2} l of cake, of which {:.2} l are parts.",
            100.0 * self.share,
            self.print_hours,
            self.cake_litres,
            self.part_litres
        ));
        sentences.extend(self.price.iter().map(|price| format!("That costs about {price}.")));
        for delay in &self.delays {
            let of = if delay.order.is_empty() { delay.parts.join(", ") } else { delay.order.clone() };
            sentences
                .push(format!("Late because of them: {of}, due {}.", zone.format_due(delay.due_at.0, &delay.due_text)));
        }
        sentences
    }
}
