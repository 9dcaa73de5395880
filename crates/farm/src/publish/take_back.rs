//! Published files that are taken back out of their queues, for one of two targets. Their copies wait again: because a person says so,
//! because a word of a person makes them wait (`operate`), or because the next build is better with them (`withdrawal`). Or another printer
//! gets the file, where its own went down before it took it (`build_move`). `ledger/builds/take_back` says in which steps, `taken_file`
//! does them, and `queue/take_back` says how a file leaves a queue.

use anyhow::Result;
use delivery::queue::OpenQueue;
use jobs::BackgroundJob;
use ledger::{BuildId, BuildRow, BuildState, LedgerError, TakeBackEnd, TakenBackFor};
use tokio::runtime::Handle;
use tracing::{info, warn};

use super::{
    build_move::find_other_printer,
    taken_file::{TakeBackStep, TakeBackTarget, TakenFile},
};
use crate::{
    alerts::alert::AlertKind,
    core::{desks::Building, farm::Farm},
    process::tick_tasks::TimedTask,
    scanning::queue_contents,
};

/// Takes the file of a build one step further out of its queue.
#[derive(Clone)]
pub(crate) struct TakeBackJob {
    build: BuildId,
}

impl BackgroundJob<Farm> for TakeBackJob {
    const KIND: &'static str = "TakeBack";
    type Outcome = Result<TakeBackStep>;
    type Desk<'f> = Building<'f>;

    fn subject(&self) -> String {
        self.build.to_string()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, step: Self::Outcome) -> Result<()> {
        on_step(&mut desk, self.build, step).await
    }

    async fn on_panic(self, mut desk: Self::Desk<'_>, message: &str) -> Result<()> {
        on_step(&mut desk, self.build, Err(anyhow::anyhow!("panicked: {message}"))).await
    }
}

/// Takes every build further whose file is taken back, or lies at a printer that is down.
pub(crate) async fn take_back_builds(desk: &mut Building<'_>) -> Result<()> {
    let names: Vec<String> = desk.machines.keys().cloned().collect();
    for name in names {
        for build in desk.shared.ledger.builds_to_take_back(&name).await? {
            let (id, is_begun) = (build.id, build.place.is_on_its_way());
            let machine = &desk.machines[&name];
            let is_served = machine.agreed_folders.is_some() && machine.leases.are_fresh();
            if !is_served || desk.nesting.backoff.is_waiting(&id) || desk.jobs.is_running::<TakeBackJob>(id) {
                continue;
            }
            match start(desk, build).await {
                // Before it has begun, the file lies where it was published: nobody needs to act on it.
                Err(failure) if is_begun => report_failure(desk, id, &name, &failure),
                Err(failure) => warn!(build.id = %id, "The build is not moved to another printer: {failure:#}."),
                Ok(()) => {}
            }
        }
    }
    Ok(())
}

/// Starts the next step of a build.
async fn start(desk: &mut Building<'_>, build: BuildRow) -> Result<()> {
    let source = desk.machines[&build.machine].printers.queue_with_id(build.staged.queue_id.as_deref());
    let found = match build.place.withdraw_by.is_some() {
        true => find_waiting(desk, build, source).await?,
        false => find_other_printer(desk, build, source).await?,
    };
    let Some((build, source, target)) = found else { return Ok(()) };
    let machine = &desk.machines[&build.machine];
    let (queues, leases, ledger) = (machine.printers.open_queues(), machine.leases.clone(), desk.shared.ledger.clone());
    let second = ledger.second_files(build.id).await?;
    let file = TakenFile { build, second, source, target, queues, leases, ledger, runtime: Handle::current() };
    desk.jobs.start(TakeBackJob { build: file.build.id }, move || file.go_on());
    Ok(())
}

/// The target of a file that a word waits for.
async fn find_waiting(
    desk: &mut Building<'_>,
    build: BuildRow,
    source: Option<OpenQueue>,
) -> Result<Option<(BuildRow, OpenQueue, TakeBackTarget)>> {
    let machine = &desk.machines[&build.machine];
    let Some(source) = source else {
        if machine.printers.are_all_open() {
            give_up(desk, &build).await?;
        }
        return Ok(None);
    };
    let is_carried_out = desk.shared.ledger.taken_back_for(build.id).await? == Some(TakenBackFor::Nothing);
    let archive = machine.profile.folders.archive.clone();
    Ok(Some((build, source, TakeBackTarget::Waiting { is_carried_out, archive })))
}

/// The queue of the build is no printer's any more: nobody can say whether its file is there.
async fn give_up(desk: &mut Building<'_>, build: &BuildRow) -> Result<()> {
    let id = build.id;
    // No printer of the farm sees its file: another word is carried out, but who withdraws it does not say whether it was printed.
    if desk.shared.ledger.taken_back_for(id).await? == Some(TakenBackFor::Word) {
        desk.shared.ledger.finish_noted_word(id, false).await?;
    }
    desk.shared.ledger.end_take_back(id, TakeBackEnd::Removed).await?;
    let text = format!(
        "build {id} is not taken back: it was published in a queue folder that is no printer's any more. Where its file is not \
         printed, `nestd outcome {id} failed` has its copies wait again"
    );
    desk.shared.alerts.raise(AlertKind::QueueReplaced, &build.machine, &format!("build {id}, withdrawn"), &text);
    Ok(())
}

/// Commits a step.
async fn on_step(desk: &mut Building<'_>, id: BuildId, step: Result<TakeBackStep>) -> Result<()> {
    let Some(build) = desk.shared.ledger.find_build(id).await? else { return Ok(()) };
    let step = match step {
        Ok(step) => step,
        Err(failure) => {
            report_failure(desk, id, &build.machine, &failure);
            return Ok(());
        }
    };
    match commit_step(desk, &build, step).await? {
        NextStep::AtOnce => return take_back_builds(desk).await,
        NextStep::Later => {}
        NextStep::Never => {
            desk.nesting.backoff.record_success(&id);
            desk.shared.alerts.clear(AlertKind::PublishingFails, &build.machine, &format!("build {id}"));
        }
    }
    Ok(())
}

/// When the next step of a file is done.
enum NextStep {
    AtOnce,
    /// After a failure.
    Later,
    /// Nothing is left to do.
    Never,
}

/// The file is out of the printer's reach: the word that waited for it is carried out.
async fn carry_word_out(desk: &Building<'_>, build: &BuildRow) -> Result<()> {
    // It must be there to fire at once.
    desk.shared.ledger.open_build(&build.machine).await?;
    let told = desk.shared.ledger.finish_noted_word(build.id, true).await?.unwrap_or_default().join(" ");
    info!(build.id = %build.id, machine = %build.machine, "The file of build {} is out of the queue. {told}", build.id);
    Ok(())
}

async fn commit_step(desk: &mut Building<'_>, build: &BuildRow, step: TakeBackStep) -> Result<NextStep> {
    let (id, machine, to) = (build.id, &build.machine, build.place.move_to.clone().unwrap_or_default());
    let ledger = desk.shared.ledger;
    match step {
        TakeBackStep::TakenBack => {
            if let Err(failure) = carry_word_out(desk, build).await {
                report_failure(desk, id, machine, &failure);
                return Ok(NextStep::Later);
            }
            return Ok(NextStep::AtOnce);
        }
        TakeBackStep::Free(printer) => match ledger.begin_move(id, &printer).await {
            Ok(()) | Err(LedgerError::WrongState { .. }) => return Ok(NextStep::AtOnce),
            Err(failure) => return Err(failure.into()),
        },
        TakeBackStep::Held => {
            desk.nesting.backoff.record_failure(id);
            desk.shared.alerts.clear(AlertKind::PublishingFails, machine, &format!("build {id}"));
            return Ok(NextStep::Later);
        }
        TakeBackStep::Staged { printer, queue_id } => match ledger.record_move(id, &printer, &queue_id).await {
            // Where its outcome was told meanwhile, the next step drops it.
            Ok(()) | Err(LedgerError::WrongState { .. }) => return Ok(NextStep::AtOnce),
            Err(failure) => return Err(failure.into()),
        },
        TakeBackStep::Published => {
            if !ledger.finish_move(id).await? {
                // Its outcome was told while it was renamed: it is taken back at once.
                return Ok(NextStep::AtOnce);
            }
            let from = build.place.printer.clone().unwrap_or_default();
            info!(build.id = %id, machine = %machine, "Moved build {id} from the printer {from} to {to}.");
        }
        TakeBackStep::Removed => ledger.end_take_back(id, TakeBackEnd::Removed).await?,
        TakeBackStep::TakenThere => {
            ledger.end_take_back(id, TakeBackEnd::TakenThere).await?;
            report_taken_there(desk, build, &to).await?;
        }
        TakeBackStep::Altered => {
            let why = "what lies in the queue under its name is not the file that was proved";
            let then = "Take that out of the queue, look whether it was printed, and say it once more";
            drop_word(desk, id, TakeBackEnd::Altered, (why, then)).await?;
            look_again_at(desk, build);
        }
        TakeBackStep::Copied(places) => {
            let why = format!("its copies lie in the queue as {places}");
            let then = "Take that out of the queue, and say it once more";
            drop_word(desk, id, TakeBackEnd::Copied(places), (&why, then)).await?;
        }
        TakeBackStep::Taken => {
            let then = "Say it once more when it is known how it is printed";
            drop_word(desk, id, TakeBackEnd::Taken, ("its printer took it first", then)).await?;
            info!(build.id = %id, machine = %machine, "Build {id} stays: its printer took it.");
        }
        TakeBackStep::Elsewhere(place) => {
            let at = &place.printer;
            let why = format!("it lies at {at}, and not where it was published");
            drop_word(desk, id, TakeBackEnd::Removed, (&why, "Say it once more")).await?;
            ledger.correct_place(id, &place).await?;
            info!(build.id = %id, machine = %machine, "Build {id} was found at {at} and is not taken back from where it was published.");
        }
    }
    Ok(NextStep::Never)
}

/// What was said of a build is not done: it was said of a file that lay untouched where it was published, and of another one it may not be
/// true. `why` it was not taken back, and what a person does `then`.
async fn drop_word(desk: &Building<'_>, id: BuildId, end: TakeBackEnd, (why, then): (&str, &str)) -> Result<()> {
    if desk.shared.ledger.taken_back_for(id).await? == Some(TakenBackFor::Word) {
        let text = format!(
            "the file of build {id} was to be taken out of the queue, for its copies are to be printed again, but {why}: nothing was \
             changed. {then}"
        );
        desk.shared.ledger.record_dropped_word(id, &text).await?;
    }
    Ok(desk.shared.ledger.end_take_back(id, end).await?)
}

/// What lies in the queue as a build is not the proved file: the next look reads it, and tells so until that is over.
fn look_again_at(desk: &mut Building<'_>, build: &BuildRow) {
    let Some(machine) = desk.machines.get(&build.machine) else { return };
    let queue = machine.printers.queue_with_id(build.staged.queue_id.as_deref());
    if let (Some(queue), Some(name)) = (queue, build.staged.file_name.as_deref()) {
        queue_contents::forget(&*queue, name);
    }
    let now = desk.shared.now();
    desk.shared.schedule.tasks.make_due(TimedTask::CheckFolders, now);
}

/// A printed build whose copies wait again would be printed twice.
async fn report_taken_there(desk: &Building<'_>, build: &BuildRow, printer: &str) -> Result<()> {
    if matches!(build.state, BuildState::Printing | BuildState::Complete) {
        return Ok(());
    }
    let (id, state) = (build.id, build.state);
    let text = format!(
        "build {id} was told to be {state} while it went to the printer {printer}, which has taken it: look whether {printer} \
         prints it, and tell the outcome once more, with --correct"
    );
    Ok(desk.shared.ledger.record_dropped_word(id, &text).await?)
}

fn report_failure(desk: &mut Building<'_>, id: BuildId, machine: &str, failure: &anyhow::Error) {
    desk.nesting.backoff.record_failure(id);
    desk.shared.report_failure(AlertKind::PublishingFails, machine, &format!("build {id}"), failure);
}
