//! An open build that waits is lowered further, in rounds of growing CPU time and at the lowest priority, while nothing else
//! needs the thread. What is reached is kept in the ledger, with a pool of different layouts to go on from.

use std::collections::BTreeSet;

use anyhow::Result;
use jobs::BackgroundJob;
use ledger::{BuildId, Ledger, LedgerError, NightSearchRow, NightState, PartRow, WaitingPart};
use nester::NestingMethod;
use tracing::{debug, info, warn};

use super::{batch::save_layout, searches::start_search};
use crate::{
    alerts::failure::PartFault,
    core::{
        desks::Searching,
        farm::Farm,
        machine_state::{MachineState, MachineStates},
    },
    decisions::{
        kept_layouts::{find_row, hash_problem},
        layout::{CopyId, layouts_from_json, layouts_to_json},
        night_decision::{MAX_STARTS, NightSearchEnd, begin_night, count_search, decide_search},
    },
    nesting::{
        layout_search::{LayoutSearch, NestingRequest, NestingResult},
        search_policy::{SearchPolicy, arrival_search_secs},
    },
    receive::damaged_files,
};

/// Height differences up to this count as equal, mm.
const SAME_MM: f64 = 1e-6;

/// Lowers the open build of a machine.
#[derive(Clone)]
pub(crate) struct NightSearchJob {
    machine: String,
    build: BuildId,
    search: LayoutSearch,
    /// The copies and rules that it is for.
    problem: String,
}

/// The pool to go on from: that of a search, or the `kept` one of a height if it is higher or lacks copies. A search that was stopped
/// before it had looked at its pool has built its own layout.
fn pool_beside(found: &NestingResult, kept: &str, height_mm: f64) -> String {
    let is_of_use = found.layout.unplaced.is_empty() && found.layout.height_mm <= height_mm + SAME_MM;
    if is_of_use { layouts_to_json(&found.pool) } else { kept.to_owned() }
}

impl BackgroundJob<Farm> for NightSearchJob {
    const KIND: &'static str = "Night";
    const IS_LOOK: bool = true;
    type Outcome = Result<NestingResult>;
    type Desk<'f> = Searching<'f>;

    fn subject(&self) -> String {
        self.machine.clone()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, outcome: Self::Outcome) -> Result<()> {
        match outcome {
            Ok(found) => self.take_result(&mut desk, found).await,
            Err(failure) => {
                self.give_up(&mut desk, &format!("{failure:#}")).await?;
                match PartFault::find_in_chain(&failure) {
                    Some(fault) => {
                        damaged_files::hold_faulty_part(&mut desk.shared, desk.machines, desk.meshes, fault).await
                    }
                    None => Ok(()),
                }
            }
        }
    }

    async fn on_panic(self, mut desk: Self::Desk<'_>, message: &str) -> Result<()> {
        self.give_up(&mut desk, message).await
    }

    fn on_not_started(self, desk: Self::Desk<'_>, _why: &str) {
        if let Some((machine, row)) = self.take_search(desk.machines) {
            machine.open.night.keep_unsaved(NightSearchRow { starts: row.starts.saturating_sub(1), ..row });
        }
    }
}

impl NightSearchJob {
    /// The machine and the search, unless something else is wanted of its open build by now.
    fn take_search<'m>(&self, machines: &'m mut MachineStates) -> Option<(&'m mut MachineState, NightSearchRow)> {
        let machine = machines.get_mut(&self.machine)?;
        let night = &mut machine.open.night;
        night.search.take_if(|search| search.is(&self.search))?;
        let row = night.row.clone()?;
        Some((machine, row))
    }

    async fn take_result(self, desk: &mut Searching<'_>, found: NestingResult) -> Result<()> {
        let Some((machine, row)) = self.take_search(desk.machines) else {
            return self.count_ended(desk.shared.ledger, Some(found)).await;
        };
        let first_secs = arrival_search_secs(&machine.profile, machine.open.layout.placed.len());
        let pool = pool_beside(&found, &row.pool, machine.open.layout.height_mm);
        let is_lower = machine.open.take_lower_layout(found.layout);
        let end = NightSearchEnd {
            asked_secs: self.search.policy.limit_cpu_secs(),
            cpu_secs: found.cpu_secs,
            height_mm: machine.open.layout.height_mm,
            is_stopped: self.search.is_stopped(),
        };
        let row = NightSearchRow { pool, ..count_search(row, &end, first_secs) };
        debug!(machine = %self.machine, cpu_secs = row.cpu_secs, height_mm = end.height_mm, "An open build was searched further.");
        machine.open.night.keep_unsaved(row.clone());
        if is_lower {
            save_layout(desk.shared.ledger, self.build, &machine.open.layout).await?;
        }
        desk.shared.ledger.save_night_search(self.build, &row).await?;
        machine.open.night.is_known = true;
        Ok(desk.shared.ledger.add_cpu_secs(self.build, found.cpu_secs).await?)
    }

    /// Counts a search of which nothing is taken, because something else is wanted of the open build by now: its time was spent,
    /// and it did not end the daemon.
    async fn count_ended(&self, ledger: &Ledger, found: Option<NestingResult>) -> Result<()> {
        let cpu_secs = found.as_ref().map_or(0.0, |found| found.cpu_secs);
        match ledger.add_cpu_secs(self.build, cpu_secs).await {
            // Its copies were built meanwhile.
            Err(LedgerError::WrongState { .. }) => return Ok(()),
            counted => counted?,
        }
        let Some(row) = find_row(ledger, self.build, &self.problem).await? else { return Ok(()) };
        let (spent_secs, round_cpu_secs) = (row.cpu_secs + cpu_secs, row.round_cpu_secs + cpu_secs);
        let pool = found.map_or(row.pool.clone(), |found| pool_beside(&found, &row.pool, row.round_height_mm));
        let row = NightSearchRow { cpu_secs: spent_secs, round_cpu_secs, pool, starts: 0, ..row };
        Ok(ledger.save_night_search(self.build, &row).await?)
    }

    /// What failed would fail again: these copies are not searched further.
    async fn give_up(&self, desk: &mut Searching<'_>, why: &str) -> Result<()> {
        let Some((machine, row)) = self.take_search(desk.machines) else {
            return self.count_ended(desk.shared.ledger, None).await;
        };
        warn!(machine = %self.machine, "The open build of {} is not lowered further while it waits: {why}.", self.machine);
        let row = NightSearchRow { state: NightState::GivenUp, ..row };
        machine.open.night.keep_unsaved(row.clone());
        desk.shared.ledger.save_night_search(self.build, &row).await?;
        machine.open.night.is_known = true;
        Ok(())
    }
}

/// Stops what must give way, and goes on with the open builds that wait, as far as threads are free.
pub(crate) async fn search_waiting_builds(desk: &mut Searching<'_>) -> Result<()> {
    desk.searches.stop_surplus();
    let names: Vec<String> =
        desk.machines.iter().filter(|(_, machine)| may_go_on(machine)).map(|(name, _)| name.clone()).collect();
    for name in names {
        let is_known = desk.machines[&name].open.night.is_known;
        // Without a thread, only how far it is: people see that.
        if (!is_known || desk.searches.has_idle_slot()) && !desk.jobs.is_running::<NightSearchJob>(&name) {
            go_on(desk, &name).await?;
        }
    }
    Ok(())
}

/// Whether the open build of a machine waits for something else than a search, and its search is not known to have ended.
fn may_go_on(machine: &MachineState) -> bool {
    let open = &machine.open;
    machine.leases.are_fresh()
        && machine.agreed_folders.is_some()
        && machine.pacing.is_idle
        && machine.pending_flushes.is_empty()
        && !open.layout.placed.is_empty()
        && open.search.is_none()
        && open.night.search.is_none()
        && (!open.night.is_known || open.night.row.as_ref().is_some_and(|row| row.state == NightState::GoesOn))
}

/// Goes on with the open build of a machine, or finds that this is not worth its time any more.
async fn go_on(desk: &mut Searching<'_>, name: &str) -> Result<()> {
    let build = desk.shared.ledger.open_build(name).await?.id;
    let known = desk.shared.ledger.find_night_search(build).await?;
    let profile = desk.machines[name].profile.clone();
    let improve_secs = profile.search.improve_secs;
    if improve_secs <= 0.0 || profile.search.nest.method == NestingMethod::Paper {
        if known.is_some() {
            desk.shared.ledger.delete_night_search(build).await?;
        }
        desk.machines.get_mut(name).into_iter().for_each(|machine| machine.open.night.is_known = true);
        return Ok(());
    }
    let placed = desk.machines[name].open.layout.copies();
    let wanted = keep_copies(desk.shared.ledger.waiting_copies(name).await?, &placed);
    if wanted.iter().map(|(_, copies)| copies.len()).sum::<usize>() != placed.len() {
        // Copies are gone since: the next look at the open build finds that.
        return Ok(());
    }
    let (problem, open) = (hash_problem(&profile, &wanted), &desk.machines[name].open);
    let (height_mm, unsaved) = (open.layout.height_mm, open.night.unsaved_row().cloned());
    if unsaved.is_some() {
        save_layout(desk.shared.ledger, build, &open.layout).await?;
    }
    let row = unsaved.or_else(|| known.clone()).filter(|row| row.problem == problem);
    let row = row.unwrap_or_else(|| begin_night(problem, height_mm));
    let (row, pool) = match layouts_from_json(&row.pool) {
        Ok(pool) => (row, pool),
        Err(error) => {
            warn!(machine = %name, "The kept layouts of the open build of {name} cannot be read, so its search begins anew: {error}.");
            (begin_night(row.problem, height_mm), Vec::new())
        }
    };
    let decision = decide_search(&row, arrival_search_secs(&profile, placed.len()), improve_secs);
    let secs = decision.ok().filter(|_| desk.searches.has_idle_slot());
    let state = decision.err().unwrap_or(NightState::GoesOn);
    let row = NightSearchRow { state, starts: row.starts + u32::from(secs.is_some()), ..row };
    if known.as_ref() != Some(&row) {
        desk.shared.ledger.save_night_search(build, &row).await?;
    }
    if row.state != NightState::GoesOn {
        let why = if row.starts >= MAX_STARTS { ", because the daemon ended during its last searches" } else { "" };
        info!(machine = %name, cpu_secs = row.cpu_secs, "The open build of {name} is not searched further: {}{why}.", row.state);
    }
    let Some(machine) = desk.machines.get_mut(name) else { return Ok(()) };
    (machine.open.night.row, machine.open.night.is_known) = (Some(row.clone()), true);
    if let Some(cpu_secs) = secs {
        machine.open.rounds += 1;
        let search = LayoutSearch::begin(SearchPolicy::Waiting { cpu_secs, earlier_cpu_secs: row.cpu_secs });
        machine.open.night.search = Some(search.clone());
        let starts = std::iter::once(machine.open.layout.placed.clone()).chain(pool).collect();
        let request = NestingRequest { profile, wanted, starts, search: search.clone() };
        let (name, problem, meshes) = (name.to_owned(), row.problem, desk.meshes.clone());
        let job = NightSearchJob { machine: name, build, search: search.clone(), problem };
        let work = move || request.run_search(&meshes);
        start_search(desk.searches, desk.jobs, (build, &search), job, work);
    }
    Ok(())
}

/// The waiting parts with those of their copies that are `placed`.
fn keep_copies(waiting: Vec<WaitingPart>, placed: &BTreeSet<CopyId>) -> Vec<(PartRow, Vec<u32>)> {
    let kept = |WaitingPart { part, mut copies }: WaitingPart| {
        copies.retain(|&copy| placed.contains(&(part.id, copy)));
        (!copies.is_empty()).then_some((part, copies))
    };
    waiting.into_iter().filter_map(kept).collect()
}
