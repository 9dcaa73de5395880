//! The step "batched": what waits is kept nested in the open build, and fires when a trigger holds.

use std::{collections::BTreeSet, time::Instant};

use anyhow::{Context, Result};
use jiff::Timestamp;
use tracing::{info, warn};

use super::{
    budget::Budget,
    claimed::reason_text,
    event::Event,
    farm::Farm,
    jobs::JobKey,
    layout::{Copy, Layout, copies_of},
    nest::{Best, NestOrder, Nested},
    priority::give_way,
    station::Search,
    trigger::{Facts, FiredBy, fired_by},
};
use crate::{
    intake,
    ledger::{BuildId, OpenLayout, PartId, PartRow, Refusal, WaitingPart},
};

/// A search for very many copies gets at least this much each, seconds: enough to have tried them all.
const SECS_PER_COPY: f64 = 0.02;

/// A profile is batched again after so many times what it took: a line of very many parts must not take up the farm.
const BATCH_REST: u32 = 9;

impl Farm {
    /// As [`Farm::batch`], unless the last time took long and is not long ago.
    pub(super) async fn batch_when_rested(&mut self, name: &str) -> Result<()> {
        let Some(station) = self.stations.get_mut(name) else { return Ok(()) };
        let began = Instant::now();
        if began < station.batch_at {
            station.is_settled = false;
            return Ok(());
        }
        let result = self.batch(name).await;
        if let Some(station) = self.stations.get_mut(name) {
            station.batch_at = Instant::now() + BATCH_REST * began.elapsed();
        }
        result
    }

    /// Keeps a profile's open build current and fires it when it is time.
    pub(super) async fn batch(&mut self, name: &str) -> Result<()> {
        let waiting = self.ledger.waiting_copies(name).await?;
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
            let copies = waiting.iter().map(|w| w.copies.len()).sum();
            let beyond = wanted.len() < copies;
            let facts = Facts {
                copies,
                oldest: waiting.iter().map(|w| w.part.claimed_at.0).min().unwrap_or_default(),
                due: waiting.iter().filter_map(|w| w.part.due_at.map(|d| d.0)).min(),
                height_mm: station.open.layout.height_mm,
                density: station.open.layout.part_volume_mm3 / station.profile.build_volume().size_mm.element_product(),
                full: station.open.covers(&wanted)
                    && !station.open.layout.placed.is_empty()
                    && (beyond || !station.open.layout.unplaced.is_empty()),
                flush: !station.flush.is_empty() && !being_read,
                knows_the_date: self.clock.knows_the_date(),
            };
            if let Some(by) = fired_by(&station.profile, &facts, Timestamp::now()) {
                return self.fire(name, by, &wanted).await;
            }
        }
        self.improve(name, cut, wanted);
        Ok(())
    }

    /// Whether a part of the profile is claimed but not read: an order by hand waits for it, unless the disk keeps it from
    /// being read.
    async fn is_being_read(&self, name: &str) -> Result<bool> {
        let claimed = self.ledger.claimed_parts(name, self.read_again.len() + 1).await?;
        Ok(claimed.iter().any(|part| !self.read_again.is_failing(&part.id)))
    }

    /// Begins a search for the open build where one is wanted and a slot is free.
    fn improve(&mut self, name: &str, cut: Vec<WaitingPart>, wanted: BTreeSet<Copy>) {
        if !self.has_free_slot() {
            return;
        }
        let key = JobKey::Improve(name.to_owned());
        let meshes = self.meshes.clone();
        let Some(station) = self.stations.get_mut(name) else { return };
        if !station.open.wants_search(&wanted, Instant::now()) || self.jobs.runs(&key) {
            return;
        }
        let open = &mut station.open;
        open.rounds += 1;
        let (round, best) = (open.rounds, Best::default());
        let secs = station.profile.arrival_secs.max(SECS_PER_COPY * wanted.len() as f64);
        let budget = Budget::starting_now(secs);
        let order = NestOrder {
            profile: station.profile.clone(),
            wanted: cut.into_iter().map(|w| (w.part, w.copies)).collect(),
            start: open.layout.placed.clone(),
            budget: budget.clone(),
            seed: station.profile.nest.seed.wrapping_add(round),
            best: best.clone(),
        };
        open.search = Some(Search { round, budget, best, copies: wanted });
        let profile = name.to_owned();
        self.jobs.start(key, move || {
            give_way();
            Event::Improved { profile, round, nested: order.run(&meshes) }
        });
    }

    /// Takes in what a search for an open build found.
    pub(super) async fn on_improved(&mut self, name: &str, round: u64, nested: Result<Nested>) -> Result<()> {
        self.jobs.ended(&JobKey::Improve(name.to_owned()));
        let Some(station) = self.stations.get_mut(name) else { return Ok(()) };
        if station.open.search.as_ref().is_none_or(|search| search.round != round) {
            return Ok(());
        }
        let nested = match nested {
            Ok(nested) => nested,
            Err(failure) => {
                warn!(profile = %name, "The open build could not be nested: {failure:#}.");
                station.open.ended(round, None);
                return Ok(());
            }
        };
        station.open.ended(round, Some(nested.layout.clone()));
        let build = self.ledger.open_build(name).await?.id;
        self.save_layout(build, &nested.layout).await?;
        self.ledger.add_cpu_secs(build, nested.cpu_secs).await?;
        self.refuse_what_fits_nowhere(name, &nested.layout).await
    }

    /// A part that finds no place in an empty volume would wait for ever: once it was tried alone, it is refused.
    async fn refuse_what_fits_nowhere(&mut self, name: &str, layout: &Layout) -> Result<()> {
        let (true, Some(&(part, _))) = (layout.placed.is_empty(), layout.unplaced.first()) else { return Ok(()) };
        let Some(station) = self.stations.get_mut(name) else { return Ok(()) };
        if !station.open.placed_nothing(layout.unplaced.len()) {
            return Ok(());
        }
        let reason = format!("It was tried and found no place in the empty build volume of {name}.");
        warn!(part.id = %part, profile = %name, "Refused part {part}. {reason}");
        let refused =
            self.refuse_waiting(part, Refusal::TooLarge, &reason).await.context("refusing a part that fits nowhere");
        if refused.is_err()
            && let Some(station) = self.stations.get_mut(name)
        {
            // Tried once more, so that it is refused when that can be done.
            station.open.forget_tried();
        }
        refused
    }

    /// A part on which the search panics must not keep the others from being built: half of the line is tried next, and
    /// what panics alone is refused.
    pub(super) async fn on_search_panicked(&mut self, name: &str, message: &str) -> Result<()> {
        let Some(station) = self.stations.get_mut(name) else { return Ok(()) };
        let copies = station.open.search.as_ref().map(|search| search.copies.clone()).unwrap_or_default();
        station.open.ended(station.open.rounds, None);
        let (true, Some(&(part, _))) = (station.open.placed_nothing(copies.len()), copies.first()) else {
            return Ok(());
        };
        let reason = format!("The search failed on it: {message}.");
        self.refuse_waiting(part, Refusal::Failure, &reason).await.context("refusing a part that the search fails on")
    }

    /// waiting -> rejected, with a copy of the original in the error folder.
    async fn refuse_waiting(&self, part: PartId, cause: Refusal, reason: &str) -> Result<()> {
        if let Some(row) = self.ledger.part(part).await? {
            self.copy_into_error(&row, reason)?;
        }
        Ok(self.ledger.cancel(part, cause, reason).await?)
    }

    /// The original was let go when the part began to wait: a copy from the store goes into the error folder. The same
    /// copy again changes nothing.
    pub(super) fn copy_into_error(&self, row: &PartRow, reason: &str) -> Result<()> {
        let Some(station) = self.stations.get(&row.profile) else { return Ok(()) };
        let (stored, error_dir) = (self.meshes.store.path(&row.content_hash)?, &station.profile.folders.error);
        let text = reason_text(row, reason);
        match super::tidy::refused_files(error_dir, row)?.first() {
            Some((_, known)) => intake::rewrite_reason(known, &text),
            None => intake::refuse_copy(&stored, error_dir, &format!("part-{}", row.id), &row.name, &text),
        }
        .with_context(|| format!("copying {} into the error folder", row.name))
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
        let open = &station.open;
        let mut layout = Layout { placed: open.best_placed(), ..open.layout.clone() };
        // A full build takes what was tried and stands; any other takes all that waits, and what finds no place after
        // the final search goes back to the head of the line.
        let copies: Vec<Copy> = match by {
            FiredBy::Full => open.layout.placed.iter().map(|p| p.copy).collect(),
            _ => wanted.iter().copied().collect(),
        };
        if copies.is_empty() {
            return Ok(());
        }
        layout.placed.retain(|p| copies.contains(&p.copy));
        let build = self.ledger.open_build(name).await?.id;
        self.ledger.begin_nesting(build, &by.to_string(), &copies).await?;
        self.fresh_builds.insert(build);
        station.open.clear();
        let flush = std::mem::take(&mut station.flush);
        info!(build.id = %build, profile = %name, "Fired build {build} of {name} with {} copies: {by}.", copies.len());
        self.save_layout(build, &layout).await?;
        self.answer(&flush, &format!("build {build} is being nested with {} copies", copies.len())).await
    }

    /// Whether another search may run beside those that do.
    pub(super) fn has_free_slot(&self) -> bool {
        let searches = self.jobs.count(|key| matches!(key, JobKey::Improve(_) | JobKey::Final(_)));
        searches < self.nest_slots
    }
}
