//! The event loop's side of "claimed" and "read": records claimed files in the ledger, and takes in what was read.

use std::{sync::Arc, time::Duration};

use anyhow::{Context, Result};
use build_file::format_count;
use tracing::{debug, info, warn};

use super::{
    alert::AlertKind,
    arriving_lines::ArrivingLines,
    claim_completion,
    claim_note::ClaimNote,
    control_files, damaged_files,
    duplicates::{self, DuplicateDecision},
    error_folder::{self, COPIES_UNKNOWN},
    farm::Farm,
    folder_leases::FolderLeases,
    hot_folder_scanner::{ClaimedDrop, HotFolderScan, HotFolderScanner},
    jobs::BackgroundJob,
    late_tickets,
    mesh_source::READS_IN_THE_DAEMON,
    read::{PartReadOutcome, read_part},
    read_turn::{READERS, ReadTurn},
    standing_claim::StandingClaim,
};
use crate::{
    intake::{self, PutContents, TicketError},
    ledger::{NewPartRow, PartId, PartRow, PartState, RecordedPart, RefusalCause, TakenOver, UtcTimestamp},
    settings::MachineProfile,
};

/// Delay of a scan after a file-system event, so that a burst of events causes one scan.
const SCAN_DELAY_AFTER_EVENT: Duration = Duration::from_millis(200);

/// Scans a profile's hot folder; returns the scanner with its memory, and the result.
#[derive(Clone)]
pub(super) struct HotFolderScanJob {
    profile: String,
}

impl BackgroundJob<Farm> for HotFolderScanJob {
    const KIND: &'static str = "Scan";
    type Outcome = (Box<HotFolderScanner>, HotFolderScan);

    fn subject(&self) -> String {
        self.profile.clone()
    }

    async fn on_done(self, farm: &mut Farm, (scanner, scan): Self::Outcome) -> Result<()> {
        on_scan_done(farm, &self.profile, scanner, scan).await
    }

    async fn on_panic(self, farm: &mut Farm, _message: &str) -> Result<()> {
        reset_scanner(farm, &self.profile);
        Ok(())
    }

    fn on_not_started(self, farm: &mut Farm, _why: &str) {
        reset_scanner(farm, &self.profile);
    }
}

/// Reads a part's file.
#[derive(Clone)]
pub(super) struct PartReadJob {
    part: PartId,
}

impl BackgroundJob<Farm> for PartReadJob {
    const KIND: &'static str = "Read";
    type Outcome = PartReadOutcome;

    fn subject(&self) -> String {
        self.part.to_string()
    }

    async fn on_done(self, farm: &mut Farm, outcome: Self::Outcome) -> Result<()> {
        on_part_read(farm, self.part, outcome).await
    }

    async fn on_panic(self, farm: &mut Farm, message: &str) -> Result<()> {
        let reason = format!(
            "The reader failed on it: {message}. Export it again, as STL or 3MF; where that fails too, send it to nestd's makers."
        );
        on_part_read(farm, self.part, PartReadOutcome::Refused(RefusalCause::Failure, reason)).await
    }

    fn on_not_started(self, farm: &mut Farm, _why: &str) {
        farm.reading.backoff.record_failure(self.part);
    }
}

/// Something changed: schedules a scan soon.
pub(super) fn schedule_scan(farm: &mut Farm) {
    let soon = farm.now() + SCAN_DELAY_AFTER_EVENT;
    farm.machines.values_mut().for_each(|s| s.inbox.next_scan_at = s.inbox.next_scan_at.min(soon));
}

/// Starts a scan of every hot folder that is due.
pub(super) fn start_scans(farm: &mut Farm) {
    let (now, orphan_secs) = (farm.now(), farm.settings.orphan_ticket_secs);
    for (name, machine) in &mut farm.machines {
        if !machine.may_claim
            || !machine.leases.are_fresh()
            || now < machine.inbox.next_scan_at
            || farm.jobs.is_running::<HotFolderScanJob>(name)
        {
            continue;
        }
        let Some(mut scanner) = machine.inbox.scanner.take() else { continue };
        if std::mem::take(&mut machine.inbox.relist) {
            scanner.relist_claims();
        }
        let (profile, store) = (machine.profile.clone(), farm.meshes.store.clone());
        let mut leases = machine.leases.clone();
        let (name, status) = (name.clone(), machine.status_files(&farm.alerts, farm.settings.scan_secs));
        let (ledger, runtime) = (farm.ledger.clone(), tokio::runtime::Handle::current());
        let contents = PutContents::of_farm(&farm.settings.state_dir);
        farm.jobs.start(HotFolderScanJob { profile: name }, move || {
            let find_part = |part| runtime.block_on(ledger.find_part(part));
            let ordered = runtime.block_on(ArrivingLines::read_from(&ledger, &profile.name, contents));
            let mut scan = scanner.scan_and_claim(&profile, &mut leases, &store, orphan_secs, &ordered, find_part);
            // The status is not written into an empty mount point that has replaced the folder meanwhile.
            if status.1.is_empty() || scan.unavailable.is_some() || leases.inbox.check_usable().is_err() {
                return (scanner, scan);
            }
            if let Err(failure) = intake::write_status(&profile.folders.inbox, &status.0, &status.1) {
                scan.warnings.push(format!("writing STATUS.txt: {failure}"));
            }
            (scanner, scan)
        });
    }
}

/// Gives a hot folder a new scanner without memory.
fn reset_scanner(farm: &mut Farm, name: &str) {
    let (now, scan_secs) = (farm.now(), farm.settings.scan_secs);
    if let Some(machine) = farm.machines.get_mut(name) {
        machine.inbox.scanner = Some(Box::new(HotFolderScanner::new(
            &machine.profile,
            farm.settings.orphan_ticket_secs,
            farm.schedule.time.clone(),
        )));
        machine.inbox.next_scan_at = now + Duration::from_secs_f64(scan_secs);
    }
}

/// Takes in a scan: each claimed file gets its row, and is read later. A file that cannot be recorded now is
/// retried at the next scan.
async fn on_scan_done(
    farm: &mut Farm,
    name: &str,
    mut scanner: Box<HotFolderScanner>,
    mut scan: HotFolderScan,
) -> Result<()> {
    let (early, drops): (Vec<ClaimedDrop>, Vec<ClaimedDrop>) = std::mem::take(&mut scan.drops)
        .into_iter()
        .partition(|drop| farm.completion.forgetting.is_under_way(&drop.stored.hash));
    for drop in early {
        // Its stored copy is being removed, for it was an earlier part's: the next look copies it in again.
        scanner.retry_claim(drop.claim);
        scan.next_secs = Some(0.0);
    }
    let recorded = record_all(farm, name, &drops).await;
    control_files::obey_controls(farm, name, std::mem::take(&mut scan.controls)).await?;
    late_tickets::apply_late_tickets(farm, name, std::mem::take(&mut scan.late_tickets)).await?;
    for (at, drop) in drops.into_iter().enumerate() {
        if let Err(failure) = record_claimed_file(farm, name, &drop, recorded.get(at).copied()).await {
            farm.report_failure(AlertKind::TakingFails, name, "recording a drop", &failure);
            scanner.retry_claim(drop.claim);
        }
    }
    let (now, scan_secs) = (farm.now(), farm.settings.scan_secs);
    if let Some(machine) = farm.machines.get_mut(name) {
        if scanner.is_for_profile(&machine.profile) {
            machine.inbox.scanner = Some(scanner);
        }
        let next_secs = scan.next_secs.unwrap_or(scan_secs).clamp(0.05, scan_secs);
        machine.inbox.next_scan_at = now + Duration::from_secs_f64(next_secs);
        machine.inbox.refused_file_count = scan.refused_file_count.unwrap_or(machine.inbox.refused_file_count);
        let error_dir = machine.profile.folders.error.display();
        match scan.is_truncated || scan.unavailable.is_some() {
            true => {}
            false if scan.waiting_reasons.is_empty() => farm.alerts.clear(AlertKind::Incomplete, name, ""),
            false => farm.alerts.raise(AlertKind::Incomplete, name, "", &join_first_few(&scan.waiting_reasons)),
        }
        match machine.inbox.refused_file_count {
            0 => farm.alerts.clear(AlertKind::Refused, name, ""),
            files => {
                let detail = format!("{} in {error_dir}", format_count(files, "file", "files"));
                farm.alerts.raise(AlertKind::Refused, name, "", &detail);
            }
        }
    }
    match &scan.unavailable {
        Some(away) if away.is_lease_refused => farm.alerts.clear(AlertKind::HotFolderAway, name, ""),
        Some(away) => farm.alerts.raise(AlertKind::HotFolderAway, name, "", &away.reason),
        None => mark_scanned(farm, name),
    }
    if let Some(warning) = scan.warnings.first() {
        let more = scan.warnings.len() - 1;
        let more = if more > 0 { format!(", and {more} more") } else { String::new() };
        farm.alerts.report_failure(AlertKind::TakingFails, name, "", &format!("{warning}{more}"));
    }
    for (file, cause, reason) in &scan.refused {
        warn!(profile = %name, "Refused {file} in {name}: {reason}");
        farm.ledger.record_file_refusal(name, *cause, &format!("{file}: {reason}")).await?;
    }
    Ok(())
}

/// Writes the rows of all drops of a scan in one transaction, which costs as much as one row. Empty = each is written by
/// itself: there is one alone, it failed (failures are reported then), or one may replace a damaged file and be no order.
async fn record_all(farm: &Farm, name: &str, drops: &[ClaimedDrop]) -> Vec<RecordedPart> {
    if drops.len() < 2 || !farm.machines.contains_key(name) {
        return Vec::new();
    }
    let record = async {
        let asked_for = farm.ledger.damaged_parts().await?;
        if drops.iter().any(|drop| asked_for.iter().any(|part| part.file.content_hash == drop.stored.hash)) {
            return Ok(Vec::new());
        }
        let rows: Vec<&NewPartRow> = drops.iter().map(|drop| &drop.row).collect();
        farm.ledger.record_claims(&rows).await
    };
    record.await.unwrap_or_else(|failure| {
        debug!("The rows of a scan are written one by one: {failure}.");
        Vec::new()
    })
}

/// A hot folder is available and was scanned.
fn mark_scanned(farm: &mut Farm, name: &str) {
    farm.alerts.clear(AlertKind::HotFolderAway, name, "");
    let date = farm.date();
    if let Some(machine) = farm.machines.get_mut(name) {
        machine.inbox.scanned_at = Some(UtcTimestamp(date));
    }
}

/// Writes the row of a claimed file; an earlier run or the transaction for the whole scan may have written it
/// already.
async fn record_claimed_file(
    farm: &mut Farm,
    name: &str,
    drop: &ClaimedDrop,
    recorded: Option<RecordedPart>,
) -> Result<()> {
    if !farm.machines.contains_key(name) {
        return Ok(());
    }
    let ClaimedDrop { claim, stored, part_spec, row } = drop;
    if part_spec.is_ok() && damaged_files::take_as_replacement(farm, name, claim, stored).await? {
        return Ok(());
    }
    let recorded = match recorded {
        Some(recorded) => recorded,
        None => farm.ledger.record_claim(row).await?,
    };
    let part = farm.ledger.find_part(recorded.id).await?.context("a recorded part has no row")?;
    // One that was cancelled while its claim was made is refused already.
    if recorded.is_new && part.state == PartState::Claimed {
        farm.reading.counted_reads.insert(recorded.id);
        if part_spec.is_ok() {
            let earlier = farm.ledger.find_revised_parts(recorded.id).await?;
            let takes_over = TakenOver::of_claim(&row.name, row.ticket.is_some(), earlier.len());
            for old in earlier {
                farm.ledger.record_revision(old.id, recorded.id, takes_over).await?;
            }
        }
    }
    let part = farm.ledger.find_part(recorded.id).await?.context("a recorded part has no row")?;
    if part.file.content_hash != stored.hash {
        claim_completion::give_back_claim(farm, name, claim, stored);
        return Ok(());
    }
    let note = ClaimNote::new(farm.lifecycle.holder.farm_id(), row.clone(), part_spec.as_ref().err()).to_text();
    farm.completion.claims.insert(claim.id.clone(), StandingClaim { claim: claim.clone(), note });
    match (part.state, part_spec) {
        (PartState::Claimed, Err(error)) => {
            let remedy = match error {
                TicketError::Unlisted(_) => {
                    "drop it again together with a list that has a row for it, or with a ticket of its own"
                }
                _ => "mend the ticket and drop both again",
            };
            let reason = format!("{error}. {COPIES_UNKNOWN}: {remedy}.");
            claim_completion::refuse_part(farm, &part, RefusalCause::Ticket, &reason).await
        }
        _ => {
            claim_completion::complete_claim(farm, &part);
            Ok(())
        }
    }
}

/// Starts to read claimed parts.
pub(super) async fn start_reading(farm: &mut Farm) -> Result<()> {
    let profiles: Vec<Arc<MachineProfile>> =
        (farm.machines.values()).filter(|s| s.may_claim && s.leases.are_fresh()).map(|s| s.profile.clone()).collect();
    // Another machine comes first each time, so that none waits until another one's queue is empty.
    farm.reading.rounds = farm.reading.rounds.wrapping_add(1);
    for at in 0..profiles.len() {
        let profile = &profiles[(farm.reading.rounds + at) % profiles.len()];
        let reading = farm.jobs.running_subjects::<PartReadJob>().count();
        if reading >= READERS {
            break;
        }
        let parts = farm.ledger.claimed_parts(&profile.name, READERS + reading + farm.reading.backoff.len()).await?;
        for part in parts {
            start_part_read(farm, part, profile).await?;
        }
    }
    Ok(())
}

async fn start_part_read(farm: &mut Farm, mut part: PartRow, profile: &Arc<MachineProfile>) -> Result<()> {
    let turn = ReadTurn {
        reads: part.file.reads,
        is_resting: farm.reading.backoff.is_waiting(&part.id),
        is_ending: claim_completion::is_completing(&farm.completion, &farm.jobs, &part),
        is_being_read: farm.jobs.is_running::<PartReadJob>(part.id),
        readers: farm.jobs.running_subjects::<PartReadJob>().count(),
        is_reader_alone: farm.reading.reads_alone,
    };
    if !turn.has_come() {
        return Ok(());
    }
    let was_rejected = farm.ledger.was_rejected(part.id).await?;
    if !farm.reading.counted_reads.remove(&part.id) {
        part.file.reads = farm.ledger.begin_read(part.id).await?;
    }
    farm.reading.reads_alone = part.file.reads > READS_IN_THE_DAEMON;
    let (profile, meshes) = (profile.clone(), farm.meshes.clone());
    let claim = farm.completion.claims.get(&part.file.claim).cloned();
    let leases = farm.machines.get(&profile.name).map(|machine| machine.leases.clone());
    // After a retry the refused file and its reason must leave the error folder.
    let refused_before = leases.filter(|_| was_rejected);
    farm.jobs.start(PartReadJob { part: part.id }, move || {
        let mut outcome = read_part(&part, claim.as_ref(), &profile, &meshes);
        // Removed before the part becomes waiting: a crash later must not leave its file in two places.
        if let (Some(leases), PartReadOutcome::Solids(_)) = (refused_before, &outcome)
            && let Err(failure) = remove_refused(&leases, &profile, &part)
        {
            outcome = PartReadOutcome::TryLater(format!("removing what was refused of it: {failure:#}"));
        }
        outcome
    });
    Ok(())
}

/// Takes in the result of reading a part.
async fn on_part_read(farm: &mut Farm, id: PartId, outcome: PartReadOutcome) -> Result<()> {
    let part = farm.ledger.find_part(id).await?.context("a part that was read has no row")?;
    if part.state != PartState::Claimed {
        return Ok(());
    }
    match outcome {
        PartReadOutcome::Solids(mut solids) => {
            match duplicates::decide_on_duplicate(&farm.ledger, &farm.machines, &part, &solids).await? {
                DuplicateDecision::None => {}
                DuplicateDecision::Warn(warning) => solids[0].warnings.push(warning),
                DuplicateDecision::Refuse(reason) => {
                    return claim_completion::refuse_part(farm, &part, RefusalCause::Duplicate, &reason).await;
                }
            }
            let ids = farm.ledger.accept_solids(id, &solids).await?;
            let copies = format_count(solids.iter().map(|s| s.copies).sum::<u32>(), "copy", "copies");
            let parts = format_count(ids.len(), "part", "parts");
            info!(part.id = %id, profile = %part.profile, "{} waits in {}: {parts}, {copies}.", part.name, part.profile);
            claim_completion::release_claim(farm, &part);
            Ok(())
        }
        PartReadOutcome::Refused(cause, reason) => claim_completion::refuse_part(farm, &part, cause, &reason).await,
        PartReadOutcome::LostFile(lost) => damaged_files::request_file_again(farm, &lost).await,
        PartReadOutcome::TryLater(why) => {
            farm.reading.backoff.record_failure(id);
            farm.ledger.uncount_read(id).await?;
            let about = format!("part {id} ({})", part.name);
            farm.alerts.report_failure(AlertKind::ReadingFails, &part.profile, &about, &format!("{about}: {why}"));
            Ok(())
        }
    }
}

/// Joins the first of many texts.
fn join_first_few(held: &[String]) -> String {
    const MOST: usize = 5;
    match held.len() {
        0..=MOST => held.join("; "),
        all => format!("{}; and {} more", held[..MOST].join("; "), all - MOST),
    }
}

fn remove_refused(leases: &FolderLeases, profile: &MachineProfile, part: &PartRow) -> Result<()> {
    leases.check_error_folder()?;
    error_folder::remove_refused_files(&profile.folders.error, part)
}
