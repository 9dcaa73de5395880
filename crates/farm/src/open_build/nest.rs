//! The steps "nested" and "verified" of a fired build: one job searches, writes and proves. Each check of the ledger
//! finds the builds that need nesting, so that work continues where a crash interrupted it.

use std::{
    collections::{BTreeSet, HashMap, HashSet},
    sync::Arc,
};

use anyhow::{Context, Result, ensure};
use build_file::{PLACEMENT_TABLE_ENDING, format_count};
use delivery::queue::FileState;
use jobs::BackgroundJob;
use ledger::{
    BuildId, BuildRow, BuildState, EventKind, Ledger, PartId, PartRow, PauseCause, PlacementRow, WaitingPart,
    rank_waiting_copies,
};
use settings::MachineProfile;
use tracing::{info, warn};

use super::{batch, searches::start_search};
use crate::{
    alerts::alert::AlertKind,
    core::{crash_guard, desks::Building, farm::Farm, state::NestingState},
    decisions::{
        layout::{CopyId, placed_from_json, placed_from_rows},
        left_out::find_left_out,
    },
    files::mesh_source::MeshSource,
    leases::folder_lease::FolderLease,
    nesting::{
        layout_search::{LayoutSearch, NestingRequest, NestingResult, SearchCutShort},
        nest_decision::{
            AttemptDecision, AttemptFacts, FailedSearch, NoPlaceError, classify_failure, decide_attempt, give_up_reason,
        },
        search_policy::SearchPolicy,
        write_build::{BuildWriteRequest, WrittenBuild, queue_file_stem, write_and_prove},
    },
    printers::{
        printers,
        queues::{self, demand_staged},
    },
    publish::publish,
    receive::damaged_files,
    records::kept_build::{self, KeptBuild},
    scanning::machine_fit::report_changed_machine,
};

/// The name under which the daemon pauses a machine after a failed build, for people.
const PAUSED_BY_NESTD: &str = "nestd";

/// Nests, writes and proves a build.
#[derive(Clone)]
pub(crate) struct FinalNestingJob {
    build: BuildId,
}

impl BackgroundJob<Farm> for FinalNestingJob {
    const KIND: &'static str = "Final";
    type Outcome = Result<Box<WrittenBuild>>;
    type Desk<'f> = Building<'f>;

    fn subject(&self) -> String {
        self.build.to_string()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, written: Self::Outcome) -> Result<()> {
        let taken = on_written(&mut desk, self.build, written).await;
        if taken.is_err()
            && let Ok(Some(row)) = desk.shared.ledger.find_build(self.build).await
            && row.state == BuildState::Nesting
        {
            // The ledger has not taken it in: no attempt of its own has failed.
            desk.nesting.just_fired.insert(self.build);
            desk.nesting.backoff.record_failure(self.build);
        }
        taken
    }

    async fn on_panic(self, mut desk: Self::Desk<'_>, message: &str) -> Result<()> {
        on_final_panicked(&mut desk, self.build, message).await
    }

    fn on_not_started(self, desk: Self::Desk<'_>, _why: &str) {
        desk.nesting.just_fired.insert(self.build);
        desk.nesting.backoff.record_failure(self.build);
    }
}

/// Starts the final search of every fired build that has none. A build that cannot be started does not hold up the
/// others.
pub(crate) async fn nest_fired_builds(desk: &mut Building<'_>) -> Result<()> {
    let mut builds = desk.shared.ledger.builds_in_state(BuildState::Nesting).await?;
    // A build that ends the daemon each time must not keep the others from their turn.
    builds.sort_by_key(|build| (build.attempts, build.id));
    for build in builds {
        let (id, machine) = (build.id, build.machine.clone());
        if let Err(failure) = nest_build(desk, build).await {
            desk.shared.report_failure(AlertKind::NestingFails, &machine, &format!("build {id}"), &failure);
        }
    }
    Ok(())
}

async fn nest_build(desk: &mut Building<'_>, build: BuildRow) -> Result<()> {
    let ledger = desk.shared.ledger;
    if publish::is_build_resting(desk.nesting, build.id)
        || desk.jobs.is_running::<FinalNestingJob>(build.id)
        || !desk.nesting.searches.has_free_slot()
    {
        return Ok(());
    }
    let now = desk.shared.date();
    let Some(printer) = printers::choose_for_build(ledger, desk.machines, &build, now).await? else { return Ok(()) };
    let parts = ledger.parts_of_build(build.id).await?;
    if parts.is_empty() {
        // A repair of the ledger has taken its copies out: no fault that a person must mend.
        return Ok(ledger.fail_build(build.id, "none of its copies is left in it").await?);
    }
    // The originals of a build that is issued once more are being fetched from the archive.
    if parts.iter().any(|part| part.owed.fetch_at.is_some()) {
        return Ok(());
    }
    let rows: Vec<&PartRow> = parts.iter().collect();
    if crash_guard::must_wait_after_crashes(&mut desk.shared, &build, build.searches, &rows) {
        return Ok(());
    }
    ledger.begin_search(build.id).await?;
    let attempts = match desk.nesting.just_fired.remove(&build.id) {
        true => build.attempts,
        false => ledger.begin_attempt(build.id).await?,
    };
    let search = &desk.machines[&build.machine].profile.search;
    let decision = decide_attempt(&AttemptFacts {
        build: build.id,
        attempts,
        failures: desk.nesting.failures.get(&build.id).map_or(0, |(count, _)| *count),
        max_attempts: search.max_attempts,
        final_secs: search.final_secs,
        searched_secs: build.search.wall_secs.unwrap_or(0.0),
        seed: search.nest.seed,
    });
    match decision {
        AttemptDecision::GiveUp => {
            let reason = give_up_reason(attempts - 1, desk.nesting.failures.get(&build.id));
            give_up_build(desk, &build, &reason).await
        }
        AttemptDecision::Search { secs, seed } => {
            ledger.assign_printer(build.id, &printer).await?;
            start_final_search(desk, build, &printer, (secs, seed)).await
        }
    }
}

async fn start_final_search(
    desk: &mut Building<'_>,
    build: BuildRow,
    printer: &str,
    (secs, seed): (f64, u64),
) -> Result<()> {
    let ledger = desk.shared.ledger;
    let wanted = parts_with_copies(ledger, build.id).await?;
    let machine = &desk.machines[&build.machine];
    let profile = machine.profile.clone();
    let queue = machine.printers.find(printer).and_then(|printer| printer.opened.clone());
    let queue = queue.context("the queue folder is not open")?;
    // The proved layout of an earlier build is issued once more: there is nothing to search.
    let secs = if build.search.repeats.is_some() { 0.0 } else { secs };
    let search = LayoutSearch::begin(SearchPolicy::Final { secs, seed });
    let start = match build.kept.layout.as_deref() {
        Some(layout) => placed_from_json(layout),
        // The build was proved before, but must be made again.
        None => placed_from_rows(&ledger.placements_of_build(build.id).await?, profile.origin_mm()),
    };
    let stands: HashSet<CopyId> = start.iter().map(|placed| placed.copy).collect();
    let wanted = rank_waiting_copies(wanted, |part, copy| stands.contains(&(part, copy)));
    let mut leases = machine.leases.clone();
    let claims = wanted.iter().map(|wanted| wanted.part.file.claim.clone());
    let unsure = claims.filter(|claim| !desk.released.contains(claim)).collect();
    let request = NestingRequest {
        profile: profile.clone(),
        wanted: wanted.into_iter().map(|wanted| (wanted.part, wanted.copies)).collect(),
        starts: vec![start],
        search: search.clone(),
    };
    let write = BuildWriteRequest { profile, queue, build, seed, limits: desk.meshes.limits.clone() };
    let meshes = desk.meshes.clone();
    let kept = find_kept_build(desk, &write.build).await?;
    let id = write.build.id;
    let work = move || {
        crate::nodes::adopt::check_claims_released(&request.profile, leases.inbox.farm_id(), &unsure)?;
        if let Some((kept, placements)) = kept {
            let gone = request.wanted.iter().map(|(part, _)| part);
            let gone: Vec<PartRow> = gone.filter(|part| !meshes.has_file(part)).cloned().collect();
            // Parts without a file are then asked for, as always.
            if !gone.is_empty()
                && let Err(failure) = kept.load_meshes(&gone, &placements, &meshes)
            {
                warn!("The kept build file cannot be used: {failure:#}.");
            }
        }
        nest_write_and_prove(&request, &write, &mut leases.archive, &meshes).map(Box::new)
    };
    start_search(&mut desk.nesting.searches, desk.jobs, (id, &search), FinalNestingJob { build: id }, work);
    Ok(())
}

/// The kept file of the build that is issued once more with this one, and the placements in it.
async fn find_kept_build(desk: &Building<'_>, build: &BuildRow) -> Result<Option<(KeptBuild, Vec<PlacementRow>)>> {
    let Some(printed) = build.search.repeats else { return Ok(None) };
    let Some(row) = desk.shared.ledger.find_build(printed).await? else { return Ok(None) };
    let archive = &desk.machines[&build.machine].profile.folders.archive;
    let Some(kept) = KeptBuild::of_build(archive, &row) else { return Ok(None) };
    Ok(Some((kept, desk.shared.ledger.placements_of_build(printed).await?)))
}

/// The parts of a build with their copies in it, in order of precedence.
async fn parts_with_copies(ledger: &Ledger, build: BuildId) -> Result<Vec<WaitingPart>> {
    let mut copies: HashMap<PartId, Vec<u32>> = HashMap::new();
    for (part, copy) in ledger.copies_of_build(build).await? {
        copies.entry(part).or_default().push(copy);
    }
    let parts = ledger.parts_of_build(build).await?;
    let with_copies = |part: PartRow| Some(WaitingPart { copies: copies.remove(&part.id)?, part });
    Ok(parts.into_iter().filter_map(with_copies).collect())
}

/// Tells of the copies that the final search of a build left out although they stood in the open build, or must be in
/// the next one.
async fn report_left_out_of_build(desk: &mut Building<'_>, build: BuildId, unplaced: &[CopyId]) -> Result<()> {
    let parts = parts_with_copies(desk.shared.ledger, build).await?;
    let Some(row) = desk.shared.ledger.find_build(build).await? else { return Ok(()) };
    let parts: Vec<_> = parts.iter().map(|wanted| (&wanted.part, &wanted.copies[..])).collect();
    let all = parts.iter().flat_map(|(part, copies)| copies.iter().map(|&copy| (part.id, copy)));
    let placed: BTreeSet<CopyId> = all.filter(|copy| !unplaced.contains(copy)).collect();
    let stood = row.kept.layout.as_deref().map(placed_from_json).unwrap_or_default();
    let stood: BTreeSet<CopyId> = stood.iter().map(|placed| placed.copy).collect();
    let left_out = find_left_out(&parts, &placed, &stood);
    batch::report_left_out(desk.shared.ledger, desk.machines, &row.machine, Some(build), left_out).await
}

/// Commits a written and proved build; publishing follows in the same tick.
async fn on_written(desk: &mut Building<'_>, build: BuildId, written: Result<Box<WrittenBuild>>) -> Result<()> {
    let ledger = desk.shared.ledger;
    if let Some(build) = ledger.find_build(build).await? {
        crash_guard::record_search_end(ledger, desk.shared.alerts, &build).await?;
    }
    if written.is_ok() {
        desk.nesting.failures.remove(&build);
        desk.nesting.backoff.record_success(&build);
        let name = ledger.find_build(build).await?.map(|b| b.machine).unwrap_or_default();
        desk.shared.alerts.clear(AlertKind::NestingFails, &name, &format!("build {build}"));
    }
    let written = match written {
        Ok(written) => written,
        Err(failure) => return on_search_failed(desk, build, &failure).await,
    };
    if let Err(why) = queues::demand_same_queue(ledger, desk.machines, build, &written.verified).await {
        return record_attempt_failure(ledger, desk.nesting, build, &format!("{why:#}")).await;
    }
    if !written.unplaced.is_empty() {
        info!(build.id = %build, "{} in build {build}: left for the next.", format_count(written.unplaced.len(), "copy found no place", "copies found no place"));
        report_left_out_of_build(desk, build, &written.unplaced).await?;
        ledger.release_copies(build, &written.unplaced, "found no place").await?;
    }
    ledger.verify_build(build, &written.verified, &written.placed).await?;
    if let Some(row) = ledger.find_build(build).await?
        && let Some(machine) = desk.machines.get(&row.machine)
    {
        report_changed_machine(ledger, &machine.profile, &row).await?;
    }
    if !written.locked.is_empty() {
        warn!(build.id = %build, "Parts of build {build} are locked into each other: {}.", written.locked);
        let name = ledger.find_build(build).await?.map(|b| b.machine).unwrap_or_default();
        ledger.write_event(EventKind::Locked, &name, None, Some(build), &written.locked).await?;
    }
    publish::publish_verified_builds(desk).await
}

async fn on_search_failed(desk: &mut Building<'_>, build: BuildId, failure: &anyhow::Error) -> Result<()> {
    let decision = classify_failure(failure, desk.shared.lifecycle.is_stopping);
    let machine = desk.shared.ledger.find_build(build).await?.map(|b| b.machine).unwrap_or_default();
    match decision {
        FailedSearch::LeaveForNextStart => {
            info!(build.id = %build, "Build {build} was left for the next start: {failure:#}.");
            match failure.downcast_ref() {
                Some(cut_short) => batch::leave_search(desk.shared.ledger, build, cut_short).await,
                None => Ok(()),
            }
        }
        FailedSearch::ContinueWithoutPart => damaged_files::continue_without_faulty_part(desk, build, failure).await,
        FailedSearch::GiveUp => match desk.shared.ledger.find_build(build).await? {
            Some(row) => give_up_build(desk, &row, &format!("is given up: {failure:#}")).await,
            None => Ok(()),
        },
        FailedSearch::RetryLater => {
            // The parts stay in it.
            desk.nesting.just_fired.insert(build);
            desk.nesting.backoff.record_failure(build);
            desk.shared.report_failure(AlertKind::NestingFails, &machine, &format!("build {build}"), failure);
            Ok(())
        }
        FailedSearch::CountAttempt { is_unproved } => {
            warn!(build.id = %build, "A build could not be made; it is tried again: {failure:#}.");
            let why = format!("{failure:#}");
            if is_unproved {
                desk.shared.ledger.write_event(EventKind::ProofFailed, &machine, None, Some(build), &why).await?;
            }
            record_attempt_failure(desk.shared.ledger, desk.nesting, build, &why).await
        }
    }
}

/// Fails a build that cannot be made. Its parts wait again, and its machine is paused, since a person must act.
async fn give_up_build(desk: &mut Building<'_>, build: &BuildRow, reason: &str) -> Result<()> {
    desk.nesting.failures.remove(&build.id);
    warn!(build.id = %build.id, machine = %build.machine, "Build {} failed, and its machine is paused: {reason}.", build.id);
    queues::discard_staged(desk.machines, desk.jobs, build);
    // Paused first: the alert names what has failed since.
    desk.shared.ledger.pause_machine(&build.machine, PAUSED_BY_NESTD, PauseCause::BuildFailed).await?;
    Ok(desk.shared.ledger.fail_build(build.id, reason).await?)
}

async fn record_attempt_failure(ledger: &Ledger, nesting: &mut NestingState, build: BuildId, why: &str) -> Result<()> {
    let failure = nesting.failures.entry(build).or_default();
    *failure = (failure.0 + 1, why.to_owned());
    nesting.backoff.record_failure(build);
    let machine = ledger.find_build(build).await?.map(|b| b.machine).unwrap_or_default();
    Ok(ledger.write_event(EventKind::AttemptFailed, &machine, None, Some(build), why).await?)
}

/// A build's job panicked.
async fn on_final_panicked(desk: &mut Building<'_>, build: BuildId, message: &str) -> Result<()> {
    desk.shared.ledger.end_search(build).await?;
    record_attempt_failure(desk.shared.ledger, desk.nesting, build, &format!("panicked: {message}")).await
}

/// The whole final job: search, write, prove, and archive the originals.
fn nest_write_and_prove(
    request: &NestingRequest,
    write: &BuildWriteRequest,
    archive: &mut FolderLease,
    meshes: &MeshSource,
) -> Result<WrittenBuild> {
    let mut nested = request.run_search(meshes)?;
    if request.search.is_cut_short() {
        let NestingResult { layout, cpu_secs, wall_secs, .. } = nested;
        return Err(SearchCutShort { layout: Some(layout), cpu_secs, wall_secs }.into());
    }
    // A build that is issued once more stays as it is.
    if write.build.search.repeats.is_none() {
        nested.set_look_alikes_apart(&write.profile)?;
    }
    ensure!(!nested.layout.placed.is_empty(), NoPlaceError);
    let written = write_and_prove(write, &nested)?;
    archive.check_usable()?;
    archive_originals(&write.profile, &write.build, &nested, meshes)?;
    let file = &written.verified.file;
    demand_staged(&write.queue, &file.file_name)?;
    let staged = write.queue.file(&file.file_name, FileState::Staged)?;
    kept_build::keep_staged_file(&write.profile, &staged, &file.file_name, &file.file_hash);
    let tables = file.sidecars.iter().filter(|(name, _)| name.ends_with(PLACEMENT_TABLE_ENDING));
    for (name, hash) in tables {
        kept_build::keep_staged_file(&write.profile, &write.queue.file(name, FileState::Staged)?, name, hash);
    }
    Ok(written)
}

/// Copies the originals into the archive before the build is verified, so that every published build has them.
/// Repeating this changes nothing.
fn archive_originals(
    profile: &Arc<MachineProfile>,
    build: &BuildRow,
    nested: &NestingResult,
    meshes: &MeshSource,
) -> Result<()> {
    let stem = &queue_file_stem(&profile.name, build);
    for part in &nested.batch.parts {
        let is_placed = nested.layout.placed.iter().any(|p| p.copy.0 == part.part.id);
        // A build that is issued once more from its kept file may have parts whose originals nobody has any more.
        if is_placed && (build.search.repeats.is_none() || meshes.has_file(&part.part)) {
            let stored = meshes.verified_file(&part.part)?;
            intake::archive_file(&stored, &profile.folders.archive, stem, &part.part.name)
                .with_context(|| format!("archiving {}", part.part.name))?;
        }
    }
    Ok(())
}
