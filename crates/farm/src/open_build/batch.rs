//! The step "batched": waiting parts are kept nested in the open build, which fires when a trigger holds.

use std::{
    collections::BTreeSet,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use build_file::format_count;
use jiff::Timestamp;
use jobs::BackgroundJob;
use ledger::{BuildId, BuildState, Ledger, MachineStatus, OpenLayout, PartId, PartRow, RefusalCause, WaitingPart};
use tracing::{info, warn};

use super::searches::start_search;
use crate::{
    again::fetch_originals,
    alerts::failure::PartFault,
    core::{
        command_answer::CommandAnswer,
        crash_guard,
        desks::Batching,
        farm::Farm,
        machine_state::{ArrivalSearch, MachineStates},
        state::ReadingState,
    },
    decisions::{
        batch_decision::{BatchDecision, BatchFacts, decide_batch},
        kept_layouts::find_kept_layout,
        layout::{BatchLayout, CopyId, waiting_copy_ids},
        left_out::{LeftOutNotice, find_cut_off, find_left_out},
        queue_depth::has_queue_room,
        trigger::{FireTrigger, next_timed},
    },
    nesting::{
        layout_search::{LayoutSearch, NestingRequest, NestingResult, SearchCutShort},
        search_policy::{SearchPolicy, arrival_search_secs},
    },
    operate::commands,
    printers::printers,
    publish::withdrawal,
    receive::{damaged_files, deferred_refusal, intake_jobs::PartReadJob},
};

/// After batching, a machine rests for this many times the time that it took: a long queue of parts must not occupy the
/// farm.
const BATCH_REST_FACTOR: u32 = 9;
/// The same while parts are read one after the other: each of them makes the queue longer, and all of it is looked at each time.
const REST_FACTOR_WHILE_READING: u32 = 29;

/// Improves the layout of a machine's open build.
#[derive(Clone)]
pub(crate) struct ImproveLayoutJob {
    machine: String,
    search: LayoutSearch,
}

impl BackgroundJob<Farm> for ImproveLayoutJob {
    const KIND: &'static str = "Improve";
    type Outcome = Result<NestingResult>;
    type Desk<'f> = Batching<'f>;

    fn subject(&self) -> String {
        self.machine.clone()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, nested: Self::Outcome) -> Result<()> {
        let taken = on_layout_improved(&mut desk, &self.machine, &self.search, nested).await;
        self.search_again_unless(taken, &mut desk)
    }

    async fn on_panic(self, mut desk: Self::Desk<'_>, message: &str) -> Result<()> {
        let taken = on_search_panicked(&mut desk, &self.machine, &self.search, message).await;
        self.search_again_unless(taken, &mut desk)
    }

    fn on_not_started(self, desk: Self::Desk<'_>, _why: &str) {
        if let Some(machine) = desk.machines.get_mut(&self.machine) {
            machine.open.take_search_result(&self.search, None, desk.shared.now());
        }
    }
}

impl ImproveLayoutJob {
    /// If its end could not be taken in, because the ledger cannot be reached, the same copies are searched again after a
    /// while.
    fn search_again_unless(&self, taken: Result<()>, desk: &mut Batching<'_>) -> Result<()> {
        if let (Err(_), Some(machine)) = (&taken, desk.machines.get_mut(&self.machine)) {
            let now = desk.shared.now();
            machine.open.take_search_result(&self.search, None, now);
            machine.open.retry_tried_later(now);
        }
        taken
    }
}

/// While parts wait, the passing of time alone may change what the printers can do: this is looked at so often.
const LOOK_WHILE_WAITING: Duration = Duration::from_secs(30);

/// [`update_open_build`], and then a look whether a published build is better taken back; skipped while the rest after a slow run is not
/// over, and where without news of the ledger there is nothing to do.
pub(crate) async fn batch_if_rested(desk: &mut Batching<'_>, name: &str, has_news: bool) -> Result<()> {
    let (began, now) = (Instant::now(), desk.shared.now());
    let Some(machine) = desk.machines.get_mut(name) else { return Ok(()) };
    if !has_news && machine.pacing.is_at_rest(now) && machine.pending_flushes.is_empty() {
        return Ok(());
    }
    if now < machine.pacing.next_batch_at || machine.agreed_folders.is_none() {
        machine.pacing.is_idle = false;
        return Ok(());
    }
    let result = match update_open_build(desk, name).await {
        Ok(()) => withdrawal::consider_withdrawal(&desk.shared, desk.machines, desk.completion, name).await,
        failed => failed,
    };
    let is_reading = desk.jobs.running_subjects::<PartReadJob>().next().is_some();
    let rest = if is_reading { REST_FACTOR_WHILE_READING } else { BATCH_REST_FACTOR };
    if let Some(machine) = desk.machines.get_mut(name) {
        machine.pacing.next_batch_at = desk.shared.now() + rest * began.elapsed();
    }
    result
}

/// Keeps a machine's open build up to date and fires it when a trigger holds.
pub(crate) async fn update_open_build(desk: &mut Batching<'_>, name: &str) -> Result<()> {
    if desk.machines.get(name).is_some_and(|machine| !machine.leases.are_fresh()) {
        return Ok(());
    }
    let mut waiting = desk.shared.ledger.waiting_copies(name).await?;
    waiting.retain(|waiting| !desk.completion.deferred_refusals.contains_key(&waiting.part.id));
    let flush = desk.machines.get(name).is_some_and(|machine| !machine.pending_flushes.is_empty());
    let takes_over = takes_over_withdrawn(desk, name, waiting.is_empty()).await?;
    let has_unread_claims = flush
        && (has_unread_claims(desk.shared.ledger, desk.reading, name).await?
            || fetch_originals::awaits_original(&desk.shared, name).await?);
    if waiting.is_empty() {
        empty_open_build(desk, name).await?;
    }
    let Some(machine) = desk.machines.get_mut(name) else { return Ok(()) };
    let waiting_ids: BTreeSet<CopyId> = waiting_copy_ids(&waiting).into_iter().collect();
    machine.left_out.retain_copies(|copy| waiting_ids.contains(copy));
    let waiting = machine.open.rank_queue(waiting);
    let head = machine.open.truncate_queue(&waiting, &machine.profile);
    let wanted: BTreeSet<CopyId> = waiting_copy_ids(&head).into_iter().collect();
    machine.pacing.is_idle = waiting.is_empty() || machine.open.covers_copies(&wanted);
    if !machine.pacing.is_idle {
        machine.open.end_night();
    }
    let cut_off = if machine.open.covers_copies(&wanted) { find_cut_off(&waiting, &wanted) } else { Vec::new() };
    report_left_out(desk.shared.ledger, desk.machines, name, None, cut_off).await?;
    let is_held = is_queue_full(desk, name).await?;
    let newest = desk.shared.ledger.newest_arrival(name).await?.map_or(Timestamp::UNIX_EPOCH, |at| at.0);
    let outlook =
        printers::printer_outlook(desk.shared.ledger, &desk.machines[name], &waiting, desk.shared.date()).await?;
    let now = desk.shared.date();
    let Some(machine) = desk.machines.get_mut(name) else { return Ok(()) };
    let is_date_trusted = desk.shared.schedule.clock.is_date_trusted();
    let open = machine.trigger_facts(&waiting, &wanted, newest, &outlook, (flush, takes_over), is_date_trusted);
    let is_paused = machine.paused || machine.printers.are_all_down();
    machine.pacing.is_held = is_held;
    let facts = BatchFacts { open, has_unread_claims, is_paused, is_held };
    machine.pacing.wakes_at = (open.copies > 0).then(|| {
        let rest = next_timed(&machine.profile, &open, now).and_then(|at| at.duration_since(now).try_into().ok());
        desk.shared.now() + rest.map_or(LOOK_WHILE_WAITING, |rest: Duration| rest.min(LOOK_WHILE_WAITING))
    });
    match decide_batch(&machine.profile, &facts, now) {
        BatchDecision::AwaitClaims => Ok(()),
        BatchDecision::AnswerFlushes if machine.pending_flushes.is_empty() => Ok(()),
        BatchDecision::AnswerFlushes => {
            let status = MachineStatus::of_machine(&desk.shared.ledger.machine_statuses().await?, name);
            let answer = match status.awaiting {
                none if none.is_empty() => CommandAnswer::NothingWaits(name.to_owned()),
                awaited => CommandAnswer::AwaitsMaterial(name.to_owned(), awaited),
            };
            while let Some(&flush) = machine.pending_flushes.first() {
                commands::answer_command(desk.shared.ledger, flush, &answer).await?;
                machine.pending_flushes.remove(0);
            }
            Ok(())
        }
        BatchDecision::Fire(by) => fire_build(desk, name, by, &wanted).await,
        BatchDecision::Search => start_layout_search(desk, name, head, wanted).await,
    }
}

/// No part waits any more: nothing is told of a layout.
async fn empty_open_build(desk: &mut Batching<'_>, name: &str) -> Result<()> {
    if let Some(machine) = desk.machines.get_mut(name) {
        machine.open.reset();
    }
    Ok(desk.shared.ledger.forget_layout(name).await?)
}

/// Whether the open build fires at once because it holds the copies of a build that nestd withdrew: as soon as their originals are
/// there. Nothing is taken over where nothing waits any more.
async fn takes_over_withdrawn(desk: &Batching<'_>, name: &str, is_nothing_waiting: bool) -> Result<bool> {
    let Some(build) = desk.shared.ledger.withdrawn_for_open(name).await? else { return Ok(false) };
    let awaits_originals = desk.shared.ledger.awaits_originals_of(build).await?;
    if is_nothing_waiting && !awaits_originals {
        desk.shared.ledger.forget_withdrawn(name).await?;
    }
    Ok(!awaits_originals)
}

/// Whether every printer that can be given a build has as many ahead as may lie in its queue. While none can be given one, builds
/// wait after they fired, as without a limit.
async fn is_queue_full(desk: &Batching<'_>, name: &str) -> Result<bool> {
    let Some(machine) = desk.machines.get(name) else { return Ok(false) };
    let (depth, usable) = (machine.profile.printing.queue_depth, printers::usable_printers(machine));
    Ok(depth > 0
        && !usable.is_empty()
        && !has_queue_room(depth, &usable, &desk.shared.ledger.builds_ahead(name).await?))
}

/// Whether a part of the machine is claimed but not read. A flush command waits for such parts, except for those
/// that the disk keeps from being read.
async fn has_unread_claims(ledger: &Ledger, reading: &ReadingState, name: &str) -> Result<bool> {
    let claimed = ledger.claimed_parts(name, reading.backoff.len() + 1).await?;
    Ok(claimed.iter().any(|part| !reading.backoff.is_failing(&part.id)))
}

/// Starts a search for the open build if one is needed and a slot is free.
async fn start_layout_search(
    desk: &mut Batching<'_>,
    name: &str,
    head: Vec<WaitingPart>,
    wanted: BTreeSet<CopyId>,
) -> Result<()> {
    if !desk.nesting.searches.has_free_slot() {
        return Ok(());
    }
    let meshes = desk.meshes.clone();
    let Some(machine) = desk.machines.get_mut(name) else { return Ok(()) };
    if !machine.open.wants_search(&wanted, desk.shared.now()) || desk.jobs.is_running::<ImproveLayoutJob>(name) {
        return Ok(());
    }
    let build = desk.shared.ledger.open_build(name).await?;
    let parts: Vec<&PartRow> = head.iter().map(|waiting| &waiting.part).collect();
    if crash_guard::must_wait_after_crashes(&mut desk.shared, &build, build.searches, &parts) {
        return Ok(());
    }
    let parts: Vec<(PartRow, Vec<u32>)> = head.into_iter().map(|w| (w.part, w.copies)).collect();
    let kept = find_kept_layout(desk.shared.ledger, build.id, &desk.machines[name].profile, &parts).await?;
    desk.shared.ledger.begin_search(build.id).await?;
    let Some(machine) = desk.machines.get_mut(name) else { return Ok(()) };
    let open = &mut machine.open;
    open.rounds += 1;
    let secs = arrival_search_secs(&machine.profile, wanted.len());
    let search = LayoutSearch::begin(SearchPolicy::Arrival { secs, round: open.rounds });
    let request = NestingRequest {
        profile: machine.profile.clone(),
        wanted: parts,
        starts: std::iter::once(open.layout.placed.clone()).chain(kept).collect(),
        search: search.clone(),
    };
    open.search = Some(ArrivalSearch { search: search.clone(), copies: wanted });
    let job = ImproveLayoutJob { machine: name.to_owned(), search: search.clone() };
    let work = move || request.run_search(&meshes);
    start_search(&mut desk.nesting.searches, desk.jobs, (build.id, &search), job, work);
    Ok(())
}

/// Takes in the result of a search for an open build.
async fn on_layout_improved(
    desk: &mut Batching<'_>,
    name: &str,
    search: &LayoutSearch,
    nested: Result<NestingResult>,
) -> Result<()> {
    let build = desk.shared.ledger.open_build(name).await?;
    crash_guard::record_search_end(desk.shared.ledger, desk.shared.alerts, &build).await?;
    let Some(machine) = desk.machines.get_mut(name) else { return Ok(()) };
    if machine.open.running(search).is_none() {
        return Ok(());
    }
    let is_complete = !search.is_stopped();
    let nested = match nested {
        Ok(nested) => nested,
        Err(failure) => {
            machine.open.take_search_result(search, None, desk.shared.now());
            if let Some(fault) = PartFault::find_in_chain(&failure) {
                return damaged_files::hold_faulty_part(&mut desk.shared, desk.machines, desk.meshes, fault).await;
            }
            warn!(machine = %name, "The open build could not be nested: {failure:#}.");
            return Ok(());
        }
    };
    let stood = machine.open.standing.clone();
    machine.open.take_search_result(search, Some(nested.layout.clone()), desk.shared.now());
    if is_complete {
        let placed = machine.open.standing.clone();
        machine.left_out.retain_copies(|copy| !placed.contains(copy));
        let parts: Vec<_> = nested.batch.parts.iter().map(|part| (&part.part, &part.copies[..])).collect();
        let left_out = find_left_out(&parts, &placed, &stood);
        report_left_out(desk.shared.ledger, desk.machines, name, Some(build.id), left_out).await?;
    }
    save_layout(desk.shared.ledger, build.id, &nested.layout).await?;
    desk.shared.ledger.add_cpu_secs(build.id, nested.cpu_secs).await?;
    refuse_unplaceable_part(desk, name, &nested.layout).await
}

/// Tells of copies that are not in the next build, each once.
pub(super) async fn report_left_out(
    ledger: &Ledger,
    machines: &mut MachineStates,
    name: &str,
    build: Option<BuildId>,
    notices: Vec<LeftOutNotice>,
) -> Result<()> {
    let Some(machine) = machines.get_mut(name) else { return Ok(()) };
    for notice in machine.left_out.add_new(notices) {
        warn!(part.id = %notice.part, machine = %name, "{}", notice.text);
        ledger.write_event(notice.cause.event_kind(), name, Some(notice.part), build, &notice.text).await?;
    }
    Ok(())
}

/// A part that finds no place in an empty volume would wait for ever: it is refused once it was tried alone.
async fn refuse_unplaceable_part(desk: &mut Batching<'_>, name: &str, layout: &BatchLayout) -> Result<()> {
    let (true, Some(&(part, _))) = (layout.placed.is_empty(), layout.unplaced.first()) else { return Ok(()) };
    let Some(machine) = desk.machines.get_mut(name) else { return Ok(()) };
    if !machine.open.halve_after_empty_search(layout.unplaced.len()) {
        return Ok(());
    }
    let reason = format!(
        "It was tried and found no place in the empty build volume of {name}. Drop it for a larger machine, or with a freer \
         orientation or a smaller clearance_mm in its ticket."
    );
    warn!(part.id = %part, machine = %name, "Refused part {part}. {reason}");
    refuse_waiting_part(desk, part, RefusalCause::TooLarge, &reason).await
}

/// A part that makes the search panic must not block the others: half of the queue is tried next, and a part that
/// panics alone is refused.
async fn on_search_panicked(desk: &mut Batching<'_>, name: &str, search: &LayoutSearch, message: &str) -> Result<()> {
    let build = desk.shared.ledger.open_build(name).await?;
    crash_guard::record_search_end(desk.shared.ledger, desk.shared.alerts, &build).await?;
    let Some(machine) = desk.machines.get_mut(name) else { return Ok(()) };
    let copies = machine.open.running(search).map(|running| running.copies.clone()).unwrap_or_default();
    machine.open.take_search_result(search, None, desk.shared.now());
    let (true, Some(&(part, _))) = (machine.open.halve_after_empty_search(copies.len()), copies.first()) else {
        return Ok(());
    };
    let reason = format!(
        "The search failed on it: {message}. Take it back to try once more; where that fails too, export it again."
    );
    refuse_waiting_part(desk, part, RefusalCause::Failure, &reason).await
}

/// waiting -> refused, with a copy of the original in the error folder.
async fn refuse_waiting_part(desk: &mut Batching<'_>, part: PartId, cause: RefusalCause, reason: &str) -> Result<()> {
    let row = desk.shared.ledger.find_part(part).await?.context("a part that waits has no row")?;
    deferred_refusal::start_refusal(&mut desk.receiving(), row, cause, reason, None);
    Ok(())
}

/// Stores a layout in the ledger, so that the search continues from it after a restart.
pub(crate) async fn save_layout(ledger: &Ledger, build: BuildId, layout: &BatchLayout) -> Result<()> {
    let row = OpenLayout {
        layout: layout.to_json(),
        height_mm: layout.height_mm,
        density: layout.density,
        copies: layout.placed.len() as u32,
        part_volume_mm3: layout.part_volume_mm3,
    };
    Ok(ledger.save_layout(build, &row).await?)
}

/// Keeps what the search of a fired build has found that was stopped: it goes on from there. Nothing is published of it, for it could be
/// lower.
pub(crate) async fn leave_search(ledger: &Ledger, build: BuildId, cut_short: &SearchCutShort) -> Result<()> {
    if ledger.find_build(build).await?.is_none_or(|row| row.state != BuildState::Nesting) {
        return Ok(());
    }
    if let Some(layout) = &cut_short.layout {
        save_layout(ledger, build, layout).await?;
    }
    Ok(ledger.leave_search(build, cut_short.cpu_secs, cut_short.wall_secs).await?)
}

/// Turns the open build into a batch: its copies are taken, and the next open build starts with the rest.
async fn fire_build(desk: &mut Batching<'_>, name: &str, by: FireTrigger, wanted: &BTreeSet<CopyId>) -> Result<()> {
    let Some(machine) = desk.machines.get_mut(name) else { return Ok(()) };
    machine.open.end_night();
    let (copies, layout) = machine.open.taken_by(by, wanted);
    if copies.is_empty() {
        return Ok(());
    }
    let build = desk.shared.ledger.open_build(name).await?.id;
    // Fired and answered in one change: no flush fires twice.
    let answer = CommandAnswer::BuildFired(build, copies.len()).to_string();
    let ledger = desk.shared.ledger.for_commands(&machine.pending_flushes, &answer);
    ledger.begin_nesting(build, &by.to_string(), &copies).await?;
    desk.nesting.just_fired.insert(build);
    machine.open.reset();
    machine.pending_flushes.clear();
    info!(build.id = %build, machine = %name, "Fired build {build} of {name} with {}: {by}.", format_count(copies.len(), "copy", "copies"));
    save_layout(desk.shared.ledger, build, &layout).await
}
