//! Refusals of parts that have no original in the hot folder any more: their file is copied into the error folder before the
//! ledger says that they are refused. After a crash in between, the command, the read or the search asks for it again.

use anyhow::Result;
use jobs::{BackgroundJob, JobRunner};
use ledger::{CommandRow, LedgerError, PartId, PartRow, PartState, RefusalCause};
use tracing::info;

use super::{mark_note, refused_part::describe_refused_part};
use crate::{
    alerts::alert::AlertKind,
    core::{
        command_answer::CommandAnswer,
        desks::Receiving,
        farm::Farm,
        state::{CompletionState, DeferredRefusal},
    },
    files::error_folder,
};

/// Copies the stored file of a part that is refused into the error folder.
#[derive(Clone)]
pub(crate) struct RefusedCopyJob {
    part: PartId,
}

impl BackgroundJob<Farm> for RefusedCopyJob {
    const KIND: &'static str = "Copy";
    type Outcome = Result<()>;
    type Desk<'f> = Receiving<'f>;

    fn subject(&self) -> String {
        self.part.to_string()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, copied: Self::Outcome) -> Result<()> {
        on_refused_copied(&mut desk, self.part, copied).await
    }

    async fn on_panic(self, mut desk: Self::Desk<'_>, message: &str) -> Result<()> {
        on_refused_copied(&mut desk, self.part, Err(anyhow::anyhow!("panicked: {message}"))).await
    }

    fn on_not_started(self, mut desk: Self::Desk<'_>, why: &str) {
        if let Some(refusal) = desk.completion.deferred_refusals.remove(&self.part) {
            put_off(&mut desk, refusal, &anyhow::anyhow!("{why}"));
        }
    }
}

/// Removes the copy of a part that is not refused after all.
#[derive(Clone)]
pub(crate) struct StrayCopyRemovalJob {
    part: PartId,
    machine: String,
    name: String,
}

impl BackgroundJob<Farm> for StrayCopyRemovalJob {
    const KIND: &'static str = "StrayCopy";
    type Outcome = Result<()>;
    type Desk<'f> = Receiving<'f>;

    fn subject(&self) -> String {
        self.part.to_string()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, removed: Self::Outcome) -> Result<()> {
        if let Err(failure) = removed {
            desk.shared.report_failure(AlertKind::EndingFails, &self.machine, &self.name, &failure);
        }
        Ok(())
    }
}

/// Whether no original of a part is claimed in the hot folder: it was released after an earlier read.
pub(crate) fn is_without_original(completion: &CompletionState, part: &PartRow) -> bool {
    !completion.claims.contains_key(&part.file.claim)
}

/// Whether a part is being refused, or its copy in the error folder is being removed.
pub(super) fn is_refusing(completion: &CompletionState, jobs: &JobRunner<Farm>, part: PartId) -> bool {
    completion.deferred_refusals.contains_key(&part) || jobs.is_running::<StrayCopyRemovalJob>(part)
}

/// Changes a part that waits, or is read again, to refused once a copy of the original is in the error folder. After a crash
/// in between, the command or the search requests this again.
pub(crate) fn start_refusal(
    desk: &mut Receiving<'_>,
    part: PartRow,
    cause: RefusalCause,
    reason: &str,
    command: Option<&CommandRow>,
) {
    let Some(refused) = describe_refused_part(desk, &part, Some(cause), reason) else { return };
    let id = part.id;
    desk.completion
        .deferred_refusals
        .insert(id, DeferredRefusal { part, cause, reason: reason.to_owned(), command: command.cloned() });
    desk.jobs.start(RefusedCopyJob { part: id }, move || refused.copy_before_cancel());
}

/// Processes the outcome of copying the original of a waiting part into the error folder. What fails, the ledger's change
/// included, is done again later.
async fn on_refused_copied(desk: &mut Receiving<'_>, id: PartId, copied: Result<()>) -> Result<()> {
    let Some(refusal) = desk.completion.deferred_refusals.remove(&id) else { return Ok(()) };
    let refused = match copied {
        Ok(()) => record_refusal(desk, &refusal).await,
        failed => failed,
    };
    if let Err(failure) = refused {
        put_off(desk, refusal, &failure);
    }
    Ok(())
}

/// claimed, waiting -> refused, as a command, a read or a search asked for.
async fn record_refusal(desk: &mut Receiving<'_>, refusal: &DeferredRefusal) -> Result<()> {
    let DeferredRefusal { part, cause, reason, command } = refusal;
    let ledger = desk.shared.ledger.for_command(command.as_ref().map(|command| command.id));
    let left = match (command, part.state) {
        (None, PartState::Claimed) => ledger.refuse_claim(part.id, *cause, reason).await,
        _ => ledger.cancel_part(part.id, *cause, reason).await,
    };
    if left.is_ok() {
        mark_note::update_decision_count(desk, part).await;
    }
    let Some(command) = command else { return Ok(left?) };
    match left {
        Ok(()) => {
            let done = CommandAnswer::PartCancelled(part.id);
            info!(part.id = %part.id, asked_by = %command.asked_by, "A command was carried out: {done}.");
            desk.shared.ledger.answer_command(command.id, done.is_done(), &done.to_string()).await?;
        }
        Err(error) if error.is_trouble() => return Err(error.into()),
        Err(refused) => {
            remove_stray_copy(desk, part, &refused);
            desk.shared.ledger.answer_command(command.id, false, &refused.to_string()).await?;
        }
    }
    Ok(())
}

/// A cancel was refused: a build may have taken the part while its file was copied, now or before a crash. The copy goes.
pub(crate) fn remove_stray_copy(desk: &mut Receiving<'_>, part: &PartRow, refused: &LedgerError) {
    let is_printed = matches!(refused, LedgerError::AlreadyBuilt(_) | LedgerError::BeingBuilt { .. });
    let Some(machine) = desk.machines.get(&part.machine).filter(|_| is_printed) else { return };
    let (leases, error_dir, row) = (machine.leases.clone(), machine.profile.folders.error.clone(), part.clone());
    let job = StrayCopyRemovalJob { part: part.id, machine: part.machine.clone(), name: part.name.clone() };
    desk.jobs.start(job, move || {
        leases.check_error_folder()?;
        error_folder::remove_refused_files(&error_dir, &row)
    });
}

/// Keeps the command open. If no command asked for the refusal, a read or a search tries the part once more.
fn put_off(desk: &mut Receiving<'_>, refusal: DeferredRefusal, failure: &anyhow::Error) {
    let DeferredRefusal { part, command, .. } = refusal;
    if let Some(command) = command {
        let about = format!("command {}", command.id);
        desk.shared.report_failure(AlertKind::StepFails, &command.machine, &about, failure);
        return desk.shared.schedule.step_backoff.record_failure(about);
    }
    desk.shared.report_failure(AlertKind::EndingFails, &part.machine, &part.name, failure);
    if part.state == PartState::Claimed {
        desk.reading.backoff.record_failure(part.id);
    } else if let Some(machine) = desk.machines.get_mut(&part.machine) {
        machine.open.retry_tried_later(desk.shared.now());
    }
}
