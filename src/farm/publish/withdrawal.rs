//! Published builds that are taken back out of the queue: because a person says so, because a word of a person makes their copies wait
//! again (`operate`), or because the next build is better with their copies. `ledger/words/withdrawal` says in which steps, and
//! `queue/take_back` how the file is taken back.

use std::path::PathBuf;

use anyhow::{Context, Result};
use jobs::BackgroundJob;
use ledger::{
    BuildId, BuildRow, BuildState, FoundPlace, Ledger, LedgerError, OccupyingBuild, OperatorWord, TakenBackFor,
    WITHDRAWN_BY_NESTD, WithdrawalEnd,
};
use tracing::info;

use super::build_move::queue_with_marker;
use crate::{
    farm::{
        alerts::alert::AlertKind,
        core::{
            desks::{Building, Shared},
            farm::Farm,
            machine_state::MachineStates,
            state::CompletionState,
        },
        decisions::{
            printer_choice::printer_loads,
            withdrawal_decision::{WithdrawalFacts, decide_withdrawal},
        },
        leases::folder_leases::FolderLeases,
        operate::operate::operate,
        printers::{printers::occupation_of, release_preview::awaits_release},
        process::tick_tasks::TimedTask,
        records::{build_record::note_withdrawn, staged_build::is_of_hash},
        scanning::queue_contents,
    },
    queue::{FileState, OpenQueue, TakeBackOutcome},
    settings::WithdrawalPolicy,
};

/// Takes the file of a build one step further out of the queue.
#[derive(Clone)]
pub(crate) struct WithdrawBuildJob {
    build: BuildId,
}

/// How far the file has come.
#[derive(Debug)]
pub(crate) enum WithdrawalStep {
    /// Its printer took it before it was taken back.
    Taken,
    /// It is under a dot-name: its copies are to wait again.
    TakenBack,
    /// What lies under its name is not the proved file.
    Altered,
    /// It is in the queue folder no more.
    Removed,
    /// It is at another printer than the ledger says, as after a backup was put back.
    Elsewhere(FoundPlace),
}

impl BackgroundJob<Farm> for WithdrawBuildJob {
    const KIND: &'static str = "Withdraw";
    type Outcome = Result<WithdrawalStep>;
    type Desk<'f> = Building<'f>;

    fn subject(&self) -> String {
        self.build.to_string()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, step: Self::Outcome) -> Result<()> {
        on_withdrawal_step(&mut desk, self.build, step).await
    }

    async fn on_panic(self, mut desk: Self::Desk<'_>, message: &str) -> Result<()> {
        on_withdrawal_step(&mut desk, self.build, Err(anyhow::anyhow!("panicked: {message}"))).await
    }
}

/// A build that is taken back.
struct WithdrawnBuild {
    build: BuildRow,
    queue: OpenQueue,
    /// The open queues of its machine, by the names of its printers.
    all_queues: Vec<(String, OpenQueue)>,
    leases: FolderLeases,
    ledger: Ledger,
    /// The archive with its record.
    archive: PathBuf,
    is_carried_out: bool,
}

impl WithdrawnBuild {
    /// The next step, from what the ledger has recorded.
    fn go_on(&self) -> Result<WithdrawalStep> {
        self.ledger.ensure_served()?;
        self.leases.check_publishing(self.queue.address())?;
        let name = self.build.staged.file_name.as_deref().context("its row names no file")?;
        if self.is_carried_out {
            // Before nothing else tells any more that nobody printed it.
            if let Some(at) = self.build.place.withdrawn_at {
                note_withdrawn(&self.archive, name, at)?;
            }
            self.queue.remove_taken_back(name)?;
            return Ok(WithdrawalStep::Removed);
        }
        let proved = self.build.staged.file_hash.as_deref().context("its row does not say what was proved")?;
        Ok(match self.queue.take_back(name, &|file| is_of_hash(file, proved))? {
            TakeBackOutcome::TakenBack => WithdrawalStep::TakenBack,
            TakeBackOutcome::Altered => WithdrawalStep::Altered,
            TakeBackOutcome::Gone => self.find_elsewhere(name).map_or(WithdrawalStep::Taken, WithdrawalStep::Elsewhere),
        })
    }

    fn find_elsewhere(&self, name: &str) -> Option<FoundPlace> {
        let lies_in =
            |queue: &OpenQueue| matches!(queue.state(name), Ok(FileState::Visible)) || queue.holds_taken_back(name);
        let (printer, queue) = self.all_queues.iter().find(|(_, queue)| lies_in(queue))?;
        Some(FoundPlace {
            printer: printer.clone(),
            queue_id: queue.id().to_owned(),
            instead_of: self.build.staged.queue_id.clone(),
            is_taken_back: false,
        })
    }
}

/// Takes every build further that is being withdrawn.
pub(crate) async fn withdraw_builds(desk: &mut Building<'_>) -> Result<()> {
    let names: Vec<String> = desk.machines.keys().cloned().collect();
    for name in names {
        for build in desk.shared.ledger.builds_to_withdraw(&name).await? {
            let machine = &desk.machines[&name];
            let is_served = machine.agreed_folders.is_some() && machine.leases.are_fresh();
            if !is_served || desk.nesting.backoff.is_waiting(&build.id) {
                continue;
            }
            let Some(queue) = queue_with_marker(machine, build.staged.queue_id.as_deref()) else {
                if machine.printers.are_all_open() {
                    give_up_withdrawal(desk, &build).await?;
                }
                continue;
            };
            let all_queues = machine.printers.open_queues();
            let (id, leases, ledger) = (build.id, machine.leases.clone(), desk.shared.ledger.clone());
            let is_carried_out = ledger.taken_back_for(id).await? == Some(TakenBackFor::Nothing);
            let archive = machine.profile.folders.archive.clone();
            let withdrawn = WithdrawnBuild { build, queue, all_queues, leases, ledger, archive, is_carried_out };
            desk.jobs.start(WithdrawBuildJob { build: id }, move || withdrawn.go_on());
        }
    }
    Ok(())
}

/// The queue folder of the build is no printer's any more: nobody can say whether its file is there.
async fn give_up_withdrawal(desk: &mut Building<'_>, build: &BuildRow) -> Result<()> {
    let id = build.id;
    // No printer of the farm sees its file: another word is carried out, but who withdraws it does not say whether it was printed.
    if desk.shared.ledger.taken_back_for(id).await? == Some(TakenBackFor::Word) {
        desk.shared.ledger.finish_noted_word(id, false).await?;
    }
    desk.shared.ledger.end_withdrawal(id, WithdrawalEnd::Removed).await?;
    let text = format!(
        "build {id} is not taken back: it was published in a queue folder that is no printer's any more. Where its file is not \
         printed, `nestd outcome {id} failed` has its copies wait again"
    );
    desk.shared.alerts.raise(AlertKind::QueueReplaced, &build.profile, &format!("build {id}, withdrawn"), &text);
    Ok(())
}

/// Commits a step of a withdrawal.
async fn on_withdrawal_step(desk: &mut Building<'_>, id: BuildId, step: Result<WithdrawalStep>) -> Result<()> {
    let Some(build) = desk.shared.ledger.find_build(id).await? else { return Ok(()) };
    let profile = build.profile.clone();
    match step {
        Ok(WithdrawalStep::TakenBack) => {
            // It must be there to fire at once.
            desk.shared.ledger.open_build(&profile).await?;
            match desk.shared.ledger.finish_noted_word(id, true).await {
                Ok(told) => {
                    let told = told.unwrap_or_default().join(" ");
                    info!(build.id = %id, profile = %profile, "The file of build {id} is out of the queue. {told}");
                    return withdraw_builds(desk).await;
                }
                Err(failure) => return report_withdrawal_failure(desk, id, &profile, &failure.into()),
            }
        }
        Ok(WithdrawalStep::Altered) => {
            let why = "what lies in the queue under its name is not the file that was proved";
            let then = "Take that out of the queue, look whether it was printed, and say it once more";
            drop_word(desk, id, WithdrawalEnd::Altered, (why, then)).await?;
            look_again_at(desk, &build);
        }
        Ok(WithdrawalStep::Taken) => {
            let then = "Say it once more when it is known how it is printed";
            drop_word(desk, id, WithdrawalEnd::Taken, ("its printer took it first", then)).await?;
            info!(build.id = %id, profile = %profile, "Build {id} stays: its printer took it.");
        }
        Ok(WithdrawalStep::Removed) => desk.shared.ledger.end_withdrawal(id, WithdrawalEnd::Removed).await?,
        Ok(WithdrawalStep::Elsewhere(place)) => {
            let why = format!("it lies at {}, and not where it was published", place.printer);
            drop_word(desk, id, WithdrawalEnd::Removed, (&why, "Say it once more")).await?;
            desk.shared.ledger.correct_place(id, &place).await?;
            info!(build.id = %id, profile = %profile, "Build {id} was found at {} and is not taken back: withdraw it once more.", place.printer);
        }
        Err(failure) => return report_withdrawal_failure(desk, id, &profile, &failure),
    }
    desk.nesting.backoff.record_success(&id);
    desk.shared.alerts.clear(AlertKind::PublishingFails, &profile, &format!("build {id}"));
    Ok(())
}

/// What lies in the queue as a build is not the proved file: the next look reads it, and tells so until that is over.
fn look_again_at(desk: &mut Building<'_>, build: &BuildRow) {
    let Some(machine) = desk.machines.get(&build.profile) else { return };
    if let (Some(queue), Some(name)) =
        (queue_with_marker(machine, build.staged.queue_id.as_deref()), build.staged.file_name.as_deref())
    {
        queue_contents::forget(&*queue, name);
    }
    let now = desk.shared.now();
    desk.shared.schedule.tasks.make_due(TimedTask::CheckFolders, now);
}

fn report_withdrawal_failure(
    desk: &mut Building<'_>,
    id: BuildId,
    profile: &str,
    failure: &anyhow::Error,
) -> Result<()> {
    desk.nesting.backoff.record_failure(id);
    desk.shared.report_failure(AlertKind::PublishingFails, profile, &format!("build {id}"), failure);
    Ok(())
}

/// What was said of a build is not done: it was said of a file that lay untouched where it was published, and of another one it may not be
/// true. `why` it was not taken back, and what a person does `then`.
async fn drop_word(desk: &Building<'_>, id: BuildId, end: WithdrawalEnd, (why, then): (&str, &str)) -> Result<()> {
    if desk.shared.ledger.taken_back_for(id).await? == Some(TakenBackFor::Word) {
        let text = format!(
            "the file of build {id} was to be taken out of the queue, for its copies are to be printed again, but {why}: nothing was \
             changed. {then}"
        );
        desk.shared.ledger.record_dropped_word(id, &text).await?;
    }
    Ok(desk.shared.ledger.end_withdrawal(id, end).await?)
}

/// Withdraws the newest build in the queue of a machine where the settings say so, for what has arrived since.
pub(crate) async fn consider_withdrawal(
    shared: &Shared<'_>,
    machines: &MachineStates,
    completion: &CompletionState,
    name: &str,
) -> Result<()> {
    let Some(machine) = machines.get(name) else { return Ok(()) };
    if machine.profile.printing.withdraw == WithdrawalPolicy::Never || !shared.schedule.clock.is_date_trusted() {
        return Ok(());
    }
    let Some(queued) = shared.ledger.newest_queued(name, 1).await?.pop() else { return Ok(()) };
    let Some(build) = shared.ledger.find_build(queued.build).await? else { return Ok(()) };
    let is_ending = !shared.ledger.builds_to_withdraw(name).await?.is_empty()
        || shared.ledger.withdrawn_for_open(name).await?.is_some();
    let mut waiting = shared.ledger.waiting_copies(name).await?;
    waiting.retain(|waiting| !completion.deferred_refusals.contains_key(&waiting.part.id));
    let now = shared.date();
    let (builds, times) = occupation_of(shared.ledger, &machine.profile, now).await?;
    let waits_for_yes = shared.ledger.builds_in_state(BuildState::Verified).await?;
    let waits_for_yes =
        |id| waits_for_yes.iter().any(|build| build.id == id && awaits_release(&machine.profile, build));
    let is_made = |other: &OccupyingBuild| {
        matches!(other.state, BuildState::Nesting | BuildState::Verified) && !waits_for_yes(other.build)
    };
    let is_making = builds.iter().any(is_made);
    let others: Vec<_> = builds.into_iter().filter(|other| other.build != build.id).collect();
    let loads = printer_loads(&machine.profile, &others, &times, now);
    let open = &machine.open;
    let is_of_now = open.search.is_none() && !open.tried.is_empty();
    let facts = WithdrawalFacts {
        fired_at: build.times.nesting_at.or(build.times.published_at).map_or(now, |at| at.0),
        height_mm: build.measures.height_mm.unwrap_or(0.0),
        printer_free_at: loads.get(&queued.printer).map_or(now, |load| load.free_at),
        open_height_mm: open.layout.height_mm,
        standing: is_of_now.then_some(&open.standing),
        waiting: &waiting,
        is_hindered: machine.paused || machine.printers.are_all_down() || is_making || is_ending,
    };
    if let Some(why) = decide_withdrawal(&machine.profile, &facts, now) {
        let word = OperatorWord::Withdraw(build.id, why.to_owned());
        match operate(shared.ledger, shared.settings, &word, WITHDRAWN_BY_NESTD, false).await {
            // Its printer was first, or its file lies there under another name, which is told.
            Err(LedgerError::InQueue(_) | LedgerError::NotInQueue(_)) => {}
            said => {
                said?;
                info!(build.id = %build.id, profile = %name, "Build {} is taken back out of the queue: {why}.", build.id);
            }
        }
    }
    Ok(())
}
