//! The step "batched": what waits is kept nested in the open build, and fires when a trigger holds.

use std::{collections::BTreeSet, time::Instant};

use anyhow::{Context, Result};
use build_file::counted;
use nester::SearchBudget;
use tracing::{info, warn};

use super::{
    failure::Lost,
    farm::Farm,
    jobs::Job,
    layout::{Copy, Layout, copies_of},
    nest_order::{Best, NestOrder, Nested},
    priority::give_way,
    station::Search,
    trigger::{FiredBy, fired_by},
};
use crate::ledger::{BuildId, OpenLayout, PartId, PartRow, Refusal, WaitingPart};

/// A search for very many copies gets at least this much each, seconds: enough to have tried them all.
const SECS_PER_COPY: f64 = 0.02;

/// A profile is batched again after so many times what it took: a line of very many parts must not take up the farm.
const BATCH_REST: u32 = 9;

/// A search may end so much after its time before others begin beside it, seconds.
const OVERDUE_SECS: f64 = 2.0;

/// Improving a profile's open build.
#[derive(Clone)]
pub(super) struct ImproveJob {
    profile: String,
    round: u64,
}

impl Job<Farm> for ImproveJob {
    const KIND: &'static str = "Improve";
    type Outcome = Result<Nested>;

    fn about(&self) -> String {
        self.profile.clone()
    }

    async fn done(self, farm: &mut Farm, nested: Self::Outcome) -> Result<()> {
        farm.on_improved(&self.profile, self.round, nested).await
    }

    async fn panicked(self, farm: &mut Farm, message: &str) -> Result<()> {
        let build = farm.ledger.open_build(&self.profile).await?;
        farm.has_ended_well(&build).await?;
        farm.on_search_panicked(&self.profile, message).await
    }

    fn not_started(self, farm: &mut Farm, _why: &str) {
        if let Some(station) = farm.stations.get_mut(&self.profile) {
            station.open.ended(station.open.rounds, None, farm.schedule.time.instant());
        }
    }
}

impl Farm {
    /// As [`Farm::batch`], unless the last time took long and is not long ago.
    pub(super) async fn batch_when_rested(&mut self, name: &str) -> Result<()> {
        let (began, now) = (Instant::now(), self.now());
        let Some(station) = self.stations.get_mut(name) else { return Ok(()) };
        if now < station.batch_at || station.agrees.is_none() {
            station.is_settled = false;
            return Ok(());
        }
        let result = self.batch(name).await;
        if let Some(station) = self.stations.get_mut(name) {
            station.batch_at = self.schedule.time.instant() + BATCH_REST * began.elapsed();
        }
        result
    }

    /// Keeps a profile's open build current and fires it when it is time.
    pub(super) async fn batch(&mut self, name: &str) -> Result<()> {
        if self.stations.get(name).is_some_and(|station| !station.holds.are_fresh()) {
            return Ok(());
        }
        let mut waiting = self.ledger.waiting_copies(name).await?;
        waiting.retain(|waiting| !self.ending.leaving.contains_key(&waiting.part.id));
        let flush = self.stations.get(name).is_some_and(|s| !s.flush.is_empty());
        let being_read = flush && self.is_being_read(name).await?;
        let Some(station) = self.stations.get_mut(name) else { return Ok(()) };
        station.is_settled = waiting.is_empty();
        if waiting.is_empty() {
            station.open.clear();
            if !being_read {
                let flush = std::mem::take(&mut station.flush);
                self.answer(&flush, &format!("nothing waits in {name}")).await?;
            }
            return Ok(());
        }
        let cut = station.open.cut(&waiting, &station.profile);
        let wanted: BTreeSet<Copy> = copies_of(&cut).into_iter().collect();
        station.is_settled = station.open.covers(&wanted);
        if !station.paused {
            let flush = !station.flush.is_empty() && !being_read;
            let facts = station.trigger_facts(&waiting, &wanted, flush, self.schedule.clock.knows_the_date());
            if let Some(by) = fired_by(&station.profile, &facts, self.schedule.time.date()) {
                return self.fire(name, by, &wanted).await;
            }
        }
        self.improve(name, cut, wanted).await
    }

    /// Whether a part of the profile is claimed but not read: an order by hand waits for it, unless the disk keeps it from
    /// being read.
    async fn is_being_read(&self, name: &str) -> Result<bool> {
        let claimed = self.ledger.claimed_parts(name, self.reading.again.len() + 1).await?;
        Ok(claimed.iter().any(|part| !self.reading.again.is_failing(&part.id)))
    }

    /// Begins a search for the open build where one is wanted and a slot is free.
    async fn improve(&mut self, name: &str, cut: Vec<WaitingPart>, wanted: BTreeSet<Copy>) -> Result<()> {
        if !self.has_free_slot() {
            return Ok(());
        }
        let meshes = self.meshes.clone();
        let Some(station) = self.stations.get_mut(name) else { return Ok(()) };
        if !station.open.wants_search(&wanted, self.schedule.time.instant()) || self.jobs.runs::<ImproveJob>(name) {
            return Ok(());
        }
        let build = self.ledger.open_build(name).await?;
        let parts: Vec<&PartRow> = cut.iter().map(|waiting| &waiting.part).collect();
        if self.is_wary(&build, build.searches, &parts) {
            return Ok(());
        }
        self.ledger.begin_search(build.id).await?;
        let Some(station) = self.stations.get_mut(name) else { return Ok(()) };
        let open = &mut station.open;
        open.rounds += 1;
        let (round, best) = (open.rounds, Best::default());
        let secs = station.profile.search.arrival_secs.max(SECS_PER_COPY * wanted.len() as f64);
        let budget = SearchBudget::of_secs(secs);
        let order = NestOrder {
            profile: station.profile.clone(),
            wanted: cut.into_iter().map(|w| (w.part, w.copies)).collect(),
            start: open.layout.placed.clone(),
            budget: budget.clone(),
            seed: station.profile.search.nest.seed.wrapping_add(round),
            best: best.clone(),
        };
        open.search = Some(Search { round, budget, best, copies: wanted });
        let profile = name.to_owned();
        self.jobs.start(ImproveJob { profile, round }, move || {
            give_way();
            order.run(&meshes)
        });
        Ok(())
    }

    /// Takes in what a search for an open build found.
    async fn on_improved(&mut self, name: &str, round: u64, nested: Result<Nested>) -> Result<()> {
        let build = self.ledger.open_build(name).await?;
        self.has_ended_well(&build).await?;
        let Some(station) = self.stations.get_mut(name) else { return Ok(()) };
        if station.open.search.as_ref().is_none_or(|search| search.round != round) {
            return Ok(());
        }
        let nested = match nested {
            Ok(nested) => nested,
            Err(failure) => {
                station.open.ended(round, None, self.schedule.time.instant());
                if let Some(lost) = Lost::of(&failure) {
                    return self.ask_again(lost).await;
                }
                warn!(profile = %name, "The open build could not be nested: {failure:#}.");
                return Ok(());
            }
        };
        station.open.ended(round, Some(nested.layout.clone()), self.schedule.time.instant());
        self.save_layout(build.id, &nested.layout).await?;
        self.ledger.add_cpu_secs(build.id, nested.cpu_secs).await?;
        self.refuse_what_fits_nowhere(name, &nested.layout).await
    }

    /// A part that finds no place in an empty volume would wait for ever: once it was tried alone, it is refused.
    async fn refuse_what_fits_nowhere(&mut self, name: &str, layout: &Layout) -> Result<()> {
        let (true, Some(&(part, _))) = (layout.placed.is_empty(), layout.unplaced.first()) else { return Ok(()) };
        let Some(station) = self.stations.get_mut(name) else { return Ok(()) };
        if !station.open.placed_nothing(layout.unplaced.len()) {
            return Ok(());
        }
        let reason = format!(
            "It was tried and found no place in the empty build volume of {name}. Drop it for a larger machine, or with a freer \
             orientation or a smaller clearance_mm in its ticket."
        );
        warn!(part.id = %part, profile = %name, "Refused part {part}. {reason}");
        self.refuse_waiting(part, Refusal::TooLarge, &reason).await
    }

    /// A part on which the search panics must not keep the others from being built: half of the line is tried next, and
    /// what panics alone is refused.
    async fn on_search_panicked(&mut self, name: &str, message: &str) -> Result<()> {
        let Some(station) = self.stations.get_mut(name) else { return Ok(()) };
        let copies = station.open.search.as_ref().map(|search| search.copies.clone()).unwrap_or_default();
        station.open.ended(station.open.rounds, None, self.schedule.time.instant());
        let (true, Some(&(part, _))) = (station.open.placed_nothing(copies.len()), copies.first()) else {
            return Ok(());
        };
        let reason = format!(
            "The search failed on it: {message}. Take it back to try once more; where that fails too, export it again."
        );
        self.refuse_waiting(part, Refusal::Failure, &reason).await
    }

    /// waiting -> rejected, with a copy of the original in the error folder.
    async fn refuse_waiting(&mut self, part: PartId, cause: Refusal, reason: &str) -> Result<()> {
        let row = self.ledger.part(part).await?.context("a part that waits has no row")?;
        self.begin_leaving(row, cause, reason, None);
        Ok(())
    }

    /// Keeps a layout in the ledger, so that a restart goes on from it.
    pub(super) async fn save_layout(&self, build: BuildId, layout: &Layout) -> Result<()> {
        let row = OpenLayout {
            layout: layout.to_json(),
            height_mm: layout.height_mm,
            density: layout.density,
            copies: layout.placed.len() as u32,
            part_volume_mm3: layout.part_volume_mm3,
        };
        Ok(self.ledger.save_layout(build, &row).await?)
    }

    /// The open build becomes a batch: its copies are taken, and the next open build begins with the rest.
    async fn fire(&mut self, name: &str, by: FiredBy, wanted: &BTreeSet<Copy>) -> Result<()> {
        let Some(station) = self.stations.get_mut(name) else { return Ok(()) };
        let (copies, layout) = station.open.taken_by(by, wanted);
        if copies.is_empty() {
            return Ok(());
        }
        let build = self.ledger.open_build(name).await?.id;
        self.ledger.begin_nesting(build, &by.to_string(), &copies).await?;
        self.nesting.fresh.insert(build);
        station.open.clear();
        let flush = std::mem::take(&mut station.flush);
        info!(build.id = %build, profile = %name, "Fired build {build} of {name} with {}: {by}.", counted(copies.len(), "copy", "copies"));
        self.save_layout(build, &layout).await?;
        self.answer(&flush, &format!("build {build} is being nested with {}", counted(copies.len(), "copy", "copies")))
            .await
    }

    /// Whether another search may run beside those that do. One whose time is over does not count: proving or preparing a
    /// build for long must not keep other machines from theirs.
    pub(super) fn has_free_slot(&self) -> bool {
        let is_due = |budget: Option<&SearchBudget>| budget.is_none_or(|budget| budget.secs_over() <= OVERDUE_SECS);
        let improving = self.jobs.running::<ImproveJob>().filter(|name| {
            is_due(self.stations.get(*name).and_then(|s| s.open.search.as_ref()).map(|search| &search.budget))
        });
        let finals = self.nesting.finals.values().filter(|(budget, _)| is_due(Some(budget)));
        let searches = improving.count() + finals.count();
        searches < self.nesting.slots
    }
}
