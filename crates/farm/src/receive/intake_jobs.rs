//! The event loop's side of "claimed" and "read": records claimed files in the ledger, and takes in what was read.

use std::sync::Arc;

use anyhow::{Context, Result};
use build_file::{MESH_FORMATS, format_count};
use intake::TicketError;
use jobs::BackgroundJob;
use ledger::{PartId, PartRow, PartState, RecordedAs, RecordedPart, RefusalCause};
use settings::MachineProfile;
use tracing::{debug, info};

use super::{
    claim_completion, damaged_files, doubtful_drops,
    duplicates::{self, DuplicateDecision},
    mark_note,
};
use crate::{
    alerts::alert::AlertKind,
    core::{desks::Receiving, farm::Farm},
    files::{
        claim_note::ClaimNote,
        error_folder::{self, ASKED_UNCLEARLY},
        isolated_read::READS_IN_THE_DAEMON,
        read::{PartReadOutcome, read_part},
        read_turn::{READERS, ReadTurn},
        standing_claim::StandingClaim,
    },
    leases::folder_leases::FolderLeases,
    scanning::hot_folder_scan::ClaimedDrop,
};

/// Reads a part's file.
#[derive(Clone)]
pub(crate) struct PartReadJob {
    part: PartId,
}

impl BackgroundJob<Farm> for PartReadJob {
    const KIND: &'static str = "Read";
    type Outcome = PartReadOutcome;
    type Desk<'f> = Receiving<'f>;

    fn subject(&self) -> String {
        self.part.to_string()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, outcome: Self::Outcome) -> Result<()> {
        let taken = on_part_read(&mut desk, self.part, outcome).await;
        if taken.is_err() {
            // It is read again because of the ledger, and not because its file ended the process.
            desk.reading.counted_reads.insert(self.part);
        }
        taken
    }

    async fn on_panic(self, mut desk: Self::Desk<'_>, message: &str) -> Result<()> {
        let reason = format!(
            "The reader failed on it: {message}. Export it again, as {MESH_FORMATS}; where that fails too, send it to nestd's makers."
        );
        on_part_read(&mut desk, self.part, PartReadOutcome::Refused(RefusalCause::Failure, reason)).await
    }

    fn on_not_started(self, desk: Self::Desk<'_>, _why: &str) {
        desk.reading.backoff.record_failure(self.part);
    }
}

/// Writes the rows of all drops of a scan in one transaction, which costs as much as one row. Empty = each is written by
/// itself: there is one alone, or it failed (failures are reported then).
pub(super) async fn record_all(desk: &Receiving<'_>, name: &str, drops: &[ClaimedDrop]) -> Vec<RecordedPart> {
    if drops.len() < 2 || !desk.machines.contains_key(name) {
        return Vec::new();
    }
    let rows: Vec<_> = drops.iter().map(ClaimedDrop::row_to_record).collect();
    desk.shared.ledger.record_drops(&rows).await.unwrap_or_else(|failure| {
        debug!("The rows of a scan are written one by one: {failure}.");
        Vec::new()
    })
}

/// Writes the row of a claimed file; an earlier run or the transaction for the whole scan may have written it
/// already.
pub(super) async fn record_claimed_file(
    desk: &mut Receiving<'_>,
    name: &str,
    drop: &ClaimedDrop,
    recorded: Option<RecordedPart>,
) -> Result<()> {
    if !desk.machines.contains_key(name) {
        return Ok(());
    }
    let ClaimedDrop { claim, stored, part_spec, row } = drop;
    let recorded = match recorded {
        Some(recorded) => recorded,
        None => {
            desk.shared.ledger.record_drops(&[drop.row_to_record()]).await?.pop().context("a drop was not recorded")?
        }
    };
    if recorded.outcome == RecordedAs::Replacement {
        return damaged_files::go_on_with_replacement(desk, name, (claim, stored), recorded.id).await;
    }
    if recorded.is_new() {
        desk.reading.counted_reads.insert(recorded.id);
    }
    let note = ClaimNote::new(desk.shared.lifecycle.holder.farm_id(), row.clone(), part_spec.as_ref().err()).to_text();
    if recorded.outcome == RecordedAs::New && part_spec.is_ok() {
        // It is as it was recorded, and is read next.
        desk.completion.claims.insert(claim.id.clone(), StandingClaim { claim: claim.clone(), note });
        return Ok(());
    }
    let part = desk.shared.ledger.find_part(recorded.id).await?.context("a recorded part has no row")?;
    if part.file.content_hash != stored.hash {
        claim_completion::give_back_claim(desk, name, claim, stored);
        return Ok(());
    }
    desk.completion.claims.insert(claim.id.clone(), StandingClaim { claim: claim.clone(), note });
    if recorded.outcome == RecordedAs::Revision {
        // What it took over stands nowhere in what was dropped.
        mark_note::update_decision_count(desk, &part).await;
        return Ok(());
    }
    match (part.state, part_spec) {
        (PartState::Claimed, Err(error)) if !intake::is_document(&part.name) => {
            let remedy = match error {
                TicketError::Unlisted(_) => {
                    "drop it again together with a list that has a row for it, or with a ticket of its own"
                }
                _ => "mend the ticket and drop both again",
            };
            let reason = format!("{error}. {ASKED_UNCLEARLY}: {remedy}.");
            claim_completion::refuse_part(desk, &part, RefusalCause::Ticket, &reason).await
        }
        _ => {
            claim_completion::complete_claim(desk, &part);
            Ok(())
        }
    }
}

/// Starts to read claimed parts.
pub(crate) async fn start_reading(desk: &mut Receiving<'_>) -> Result<()> {
    let profiles: Vec<Arc<MachineProfile>> =
        (desk.machines.values()).filter(|s| s.may_claim && s.leases.are_fresh()).map(|s| s.profile.clone()).collect();
    // Another machine comes first each time, so that none waits until another one's queue is empty.
    desk.reading.rounds = desk.reading.rounds.wrapping_add(1);
    for at in 0..profiles.len() {
        let profile = &profiles[(desk.reading.rounds + at) % profiles.len()];
        let reading = desk.jobs.running_subjects::<PartReadJob>().count();
        if reading >= READERS {
            break;
        }
        let parts =
            desk.shared.ledger.claimed_parts(&profile.name, READERS + reading + desk.reading.backoff.len()).await?;
        for part in parts {
            start_part_read(desk, part, profile).await?;
        }
    }
    Ok(())
}

async fn start_part_read(desk: &mut Receiving<'_>, mut part: PartRow, profile: &Arc<MachineProfile>) -> Result<()> {
    let turn = ReadTurn {
        reads: part.file.reads,
        is_resting: desk.reading.backoff.is_waiting(&part.id),
        is_ending: claim_completion::is_completing(desk.completion, desk.jobs, &part),
        is_being_read: desk.jobs.is_running::<PartReadJob>(part.id),
        readers: desk.jobs.running_subjects::<PartReadJob>().count(),
        is_reader_alone: desk.reading.reads_alone,
    };
    if !turn.has_come() {
        return Ok(());
    }
    let was_refused = desk.shared.ledger.was_refused(part.id).await?;
    if !desk.reading.counted_reads.remove(&part.id) {
        part.file.reads = desk.shared.ledger.begin_read(part.id).await?;
    }
    desk.reading.reads_alone = part.file.reads > READS_IN_THE_DAEMON;
    let (profile, meshes) = (profile.clone(), desk.meshes.clone());
    let claim = desk.completion.claims.get(&part.file.claim).cloned();
    let leases = desk.machines.get(&profile.name).map(|machine| machine.leases.clone());
    // After a retry the refused file and its reason must leave the error folder.
    let refused_before = leases.filter(|_| was_refused);
    desk.jobs.start(PartReadJob { part: part.id }, move || {
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
async fn on_part_read(desk: &mut Receiving<'_>, id: PartId, outcome: PartReadOutcome) -> Result<()> {
    let part = desk.shared.ledger.find_part(id).await?.context("a part that was read has no row")?;
    if part.state != PartState::Claimed {
        return Ok(());
    }
    match outcome {
        PartReadOutcome::Solids(mut solids) => {
            match duplicates::decide_on_duplicate(desk.shared.ledger, desk.machines, &part, &solids).await? {
                DuplicateDecision::Refuse(reason) => {
                    return claim_completion::refuse_part(desk, &part, RefusalCause::Duplicate, &reason).await;
                }
                accepted => accepted.note_on(&mut solids),
            }
            doubtful_drops::ask_about_doubts(desk.shared.ledger, &part, &mut solids, desk.shared.date()).await?;
            let ids = desk.shared.ledger.accept_solids(id, &solids).await?;
            let copies = format_count(solids.iter().map(|s| s.copies).sum::<u32>(), "copy", "copies");
            let parts = format_count(ids.len(), "part", "parts");
            info!(part.id = %id, machine = %part.machine, "{} waits in {}: {parts}, {copies}.", part.name, part.machine);
            claim_completion::release_claim(desk, &part);
            Ok(())
        }
        PartReadOutcome::Refused(cause, reason) => claim_completion::refuse_part(desk, &part, cause, &reason).await,
        PartReadOutcome::LostFile(lost) => {
            damaged_files::request_file_again(&mut desk.shared, desk.machines, desk.meshes, &lost).await
        }
        PartReadOutcome::TryLater(why) => {
            desk.reading.backoff.record_failure(id);
            desk.shared.ledger.uncount_read(id).await?;
            let about = format!("part {id} ({})", part.name);
            desk.shared.alerts.report_failure(
                AlertKind::ReadingFails,
                &part.machine,
                &about,
                &format!("{about}: {why}"),
            );
            Ok(())
        }
    }
}

fn remove_refused(leases: &FolderLeases, profile: &MachineProfile, part: &PartRow) -> Result<()> {
    leases.check_error_folder()?;
    error_folder::remove_refused_files(&profile.folders.error, part)
}
