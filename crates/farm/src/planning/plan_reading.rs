//! Reads from the ledger what the plan of a machine is made from. Nothing is changed.

use std::collections::{BTreeMap, HashSet};

use anyhow::Result;
use jiff::Timestamp;
use ledger::{
    BuildId, BuildRow, Ledger, MachineStatus, OccupyingBuild, PartId, PartRow, PublishedExperience, ToldPrint,
    WaitingPart,
};
use settings::MachineProfile;

use super::{
    date_outlook::{EndReserve, MadeBuild},
    occupation::{FarmRows, Occupation, awaits_release},
    packing_experience::{self, PackingExperience, upper_end},
    plan_facts::{FiredBuild, PlanFacts, PlanHindrance, StandingLayout},
};
use crate::decisions::{
    layout::{CopyId, LayoutPlacement, placed_from_json},
    print_times::{PrintTimes, print_excess_hours},
    printer_choice::{BuildSpan, build_spans},
    printer_outlook::PrinterOutlook,
};

/// Without enough prints to learn from, a print may take longer by this share of its time.
const USUAL_EXCESS: f64 = 0.1;

/// A build that has fired, with what is in it.
#[derive(Debug, Clone)]
pub struct BuildUnderWay {
    /// Its row.
    pub row: BuildRow,
    /// Its parts with the number of their copies, in order of precedence.
    pub parts: Vec<(PartRow, u32)>,
    /// Its printer and when it is printed; `None` = no printer is decided yet.
    pub made: Option<(String, MadeBuild)>,
}

/// What is known of a machine.
#[derive(Debug, Clone)]
pub struct PlanReading {
    /// What the builds to come are planned from.
    pub facts: PlanFacts,
    /// The waiting copies as the ledger has them, in order of precedence.
    pub waiting: Vec<WaitingPart>,
    /// The layout of the open build.
    pub placed: Vec<LayoutPlacement>,
    /// Builds that have fired and whose end is not told, in the order in which they are printed.
    pub under_way: Vec<BuildUnderWay>,
    /// Parts that cannot be in a build yet.
    pub unplanned: Vec<PartRow>,
    /// How sure the end of a print is.
    pub reserve: EndReserve,
    /// What earlier builds teach, the newest first.
    pub experience: Vec<PublishedExperience>,
}

/// Reads what is known of a machine where these copies wait, in order of precedence.
///
/// # Errors
/// The ledger cannot be read.
pub async fn read_plan(
    ledger: &Ledger,
    profile: &MachineProfile,
    (rows, occupation): (&FarmRows, &Occupation),
    waiting: Vec<WaitingPart>,
    now: Timestamp,
) -> Result<PlanReading> {
    let experience = ledger.published_experience(&profile.name, packing_experience::LEARN_FROM).await?;
    let Occupation { builds: occupying, told, times } = occupation;
    let status = MachineStatus::of_machine(&rows.statuses, &profile.name);
    let open = match &status.open {
        Some(open) => ledger.find_build(open.build).await?,
        None => None,
    };
    let (placed, layout) = standing_layout(open.as_ref(), &waiting);
    let standing: HashSet<CopyId> = placed.iter().map(|placed| placed.copy).collect();
    let is_down = |printer: &str| rows.down(&profile.name, printer).is_some();
    let spans = build_spans(profile, occupying, times, is_down, now);
    let outlook = PrinterOutlook::new(profile, occupying, *times, |printer| !is_down(printer), now);
    let is_away = rows.observed(&profile.name).is_some_and(|row| !row.trouble.is_empty());
    let is_homeless = |build: &&OccupyingBuild| build.printer.is_none() && build.published_at.is_none();
    let fired = |build: &OccupyingBuild| FiredBuild { build: build.build, height_mm: build.height_mm.unwrap_or(0.0) };
    let reserve = EndReserve { print_hours: excess_hours(profile, (times, told), &experience) };
    let facts = PlanFacts {
        lines: PlanFacts::rank_lines(profile, waiting.clone(), &standing),
        layout,
        newest: ledger.newest_arrival(&profile.name).await?.map_or(Timestamp::UNIX_EPOCH, |at| at.0),
        fired: occupying.iter().filter(is_homeless).map(fired).collect(),
        hindrance: match () {
            () if status.paused.is_some() => Some(PlanHindrance::Paused),
            () if is_away => Some(PlanHindrance::Unavailable),
            () if outlook.printers.is_empty() => Some(PlanHindrance::NoPrinter),
            () => None,
        },
        outlook,
        packing: PackingExperience::learn(profile, &experience),
    };
    let under_way = read_under_way(ledger, profile, (occupying, &spans), is_down, now).await?;
    let unplanned = ledger.unplanned_parts(&profile.name).await?;
    Ok(PlanReading { facts, waiting, placed, under_way, unplanned, reserve, experience })
}

/// The waiting copies that stand in the open build, and its layout, if there are any.
fn standing_layout(open: Option<&BuildRow>, waiting: &[WaitingPart]) -> (Vec<LayoutPlacement>, Option<StandingLayout>) {
    let Some(open) = open else { return Default::default() };
    let waits: HashSet<CopyId> =
        waiting.iter().flat_map(|line| line.copies.iter().map(|&copy| (line.part.id, copy))).collect();
    let mut placed = placed_from_json(open.kept.layout.as_deref().unwrap_or_default());
    placed.retain(|placed| waits.contains(&placed.copy));
    let each: BTreeMap<PartId, f64> =
        waiting.iter().map(|line| (line.part.id, line.part.measures.volume_mm3.unwrap_or(0.0))).collect();
    let volume_mm3: f64 = placed.iter().filter_map(|placed| each.get(&placed.copy.0)).sum();
    let layout = open
        .measures
        .height_mm
        .filter(|height_mm| *height_mm > 0.0 && volume_mm3 > 0.0)
        .map(|height_mm| StandingLayout { build: Some(open.id), height_mm, part_volume_mm3: volume_mm3 });
    (placed, layout)
}

/// Hours by which 95 % of prints exceed their time at most.
fn excess_hours(
    profile: &MachineProfile,
    (times, told): (&PrintTimes, &[ToldPrint]),
    experience: &[PublishedExperience],
) -> f64 {
    if times.learned_from > 0 {
        return upper_end(print_excess_hours(times, told)).max(0.0);
    }
    let heights: Vec<f64> = experience.iter().map(|build| build.height_mm).collect();
    let height_mm = crate::decisions::print_times::median(heights).unwrap_or(0.5 * profile.space.volume_mm.z);
    USUAL_EXCESS * times.occupied(height_mm).as_secs_f64() / 3600.0
}

async fn read_under_way(
    ledger: &Ledger,
    profile: &MachineProfile,
    (occupying, spans): (&[OccupyingBuild], &BTreeMap<String, Vec<BuildSpan>>),
    is_down: impl Fn(&str) -> bool,
    now: Timestamp,
) -> Result<Vec<BuildUnderWay>> {
    let mut under_way = Vec::with_capacity(occupying.len());
    for build in occupying {
        let Some(row) = ledger.find_build(build.build).await? else { continue };
        let mut counts: BTreeMap<PartId, u32> = BTreeMap::new();
        for (part, _) in ledger.counted_copies(build.build).await? {
            *counts.entry(part).or_default() += 1;
        }
        let parts = ledger.parts_of_build(build.build).await?;
        let parts = parts.into_iter().filter_map(|part| Some((counts.remove(&part.id)?, part)));
        let parts = parts.map(|(copies, part)| (part, copies)).collect();
        let made = spans.iter().find_map(|(printer, spans)| {
            let at = spans.iter().position(|span| span.build == build.build)?;
            let free_at = at.checked_sub(1).map_or(now, |before| spans[before].ends_at);
            let (BuildSpan { begins_at, printed_at, ends_at, .. }, stage) = (spans[at], spans[at].stage(now));
            let height_mm = build.height_mm.unwrap_or(0.0);
            let awaits_release = awaits_release(profile, &row);
            let awaits_printer = is_down(printer) && begins_at == Timestamp::MAX;
            Some((
                printer.clone(),
                MadeBuild { height_mm, stage, awaits_release, awaits_printer, free_at, begins_at, printed_at, ends_at },
            ))
        });
        under_way.push(BuildUnderWay { row, parts, made });
    }
    under_way.sort_by_key(|build| build.made.as_ref().map_or(Timestamp::MAX, |(_, made)| made.begins_at));
    Ok(under_way)
}

impl BuildUnderWay {
    /// Its number.
    pub fn id(&self) -> BuildId {
        self.row.id
    }
}
