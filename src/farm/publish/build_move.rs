//! A build that was published to a printer goes to another one of its machine if the printer went down before it took the
//! file. `ledger/builds/move_build` says in which steps, and `queue/take_back` how the file is taken back.

use anyhow::{Context, Result, ensure};
use jobs::BackgroundJob;
use ledger::{BuildId, BuildRow, BuildState, Ledger, LedgerError, MoveEnd};
use tokio::runtime::Handle;
use tracing::{info, warn};

use crate::{
    farm::{
        alerts::alert::AlertKind,
        core::{desks::Building, farm::Farm, machine_state::MachineState},
        leases::folder_leases::FolderLeases,
        printers::printers::choose_for_build,
        records::staged_build::{has_hash, is_of_hash},
        scanning::machine_fit::find_misfit,
    },
    queue::{FileState, OpenQueue, PrinterQueue, TakeBackOutcome},
};

/// Moves the file of a build one step further.
#[derive(Clone)]
pub(crate) struct MoveBuildJob {
    build: BuildId,
}

/// How far the file has come.
#[derive(Debug)]
pub(crate) enum MoveStep {
    /// Its printer took it before it was taken back.
    Taken,
    /// Its outcome was told meanwhile: it is not wanted any more, and in no queue.
    Dropped,
    /// Its outcome was told meanwhile, but the other printer has taken it.
    TakenThere,
    /// All of it is staged in the queue folder with this marker.
    Staged(String),
    /// It is visible at the other printer, or was.
    Published,
}

impl BackgroundJob<Farm> for MoveBuildJob {
    const KIND: &'static str = "Move";
    type Outcome = Result<MoveStep>;
    type Desk<'f> = Building<'f>;

    fn subject(&self) -> String {
        self.build.to_string()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, step: Self::Outcome) -> Result<()> {
        on_move_step(&mut desk, self.build, step).await
    }

    async fn on_panic(self, mut desk: Self::Desk<'_>, message: &str) -> Result<()> {
        on_move_step(&mut desk, self.build, Err(anyhow::anyhow!("panicked: {message}"))).await
    }
}

/// A build between two printers.
struct MovingBuild {
    build: BuildRow,
    source: OpenQueue,
    target: OpenQueue,
    /// The folder that it was to go to before another one was chosen.
    abandoned: Option<OpenQueue>,
    /// Why it does not fit its machine any more; `None` = it does.
    misfit: Option<String>,
    leases: FolderLeases,
    ledger: Ledger,
    runtime: Handle,
}

/// Moves every build further that lies at a printer that is down, or is between two printers.
pub(crate) async fn move_builds(desk: &mut Building<'_>) -> Result<()> {
    let names: Vec<String> = desk.machines.keys().cloned().collect();
    for name in names {
        for build in desk.shared.ledger.builds_to_move(&name).await? {
            let (id, is_begun) = (build.id, build.place.move_to.is_some());
            if desk.nesting.backoff.is_waiting(&id) || desk.jobs.is_running::<MoveBuildJob>(id) {
                continue;
            }
            match start_move(desk, build).await {
                // Before it has begun, the file lies where it was published: nobody needs to act on it.
                Err(failure) if is_begun => report_move_failure(desk, id, &name, &failure),
                Err(failure) => warn!(build.id = %id, "The build is not moved to another printer: {failure:#}."),
                Ok(()) => {}
            }
        }
    }
    Ok(())
}

async fn start_move(desk: &mut Building<'_>, build: BuildRow) -> Result<()> {
    let Some(machine) = desk.machines.get(&build.profile) else { return Ok(()) };
    if machine.agreed_folders.is_none() || !machine.leases.are_fresh() {
        return Ok(());
    }
    let source = queue_with_marker(machine, build.staged.queue_id.as_deref());
    let misfit = find_misfit(&machine.profile, &build);
    // What does not fit any more stays where it lies, and is told (`queue_files`).
    if build.place.move_to.is_none() && (source.is_none() || misfit.is_some()) {
        return Ok(());
    }
    if source.is_none() {
        check_missing_source(machine, &build)?;
    }
    let mut build = build;
    let open_queue = |machine: &MachineState, printer: &str| machine.printers.find(printer)?.opened.clone();
    let mut abandoned = None;
    let target = match (build.place.move_queue_id.clone(), build.place.move_to.clone()) {
        (Some(marker), _) => queue_with_marker(machine, Some(&marker)),
        // It is not wanted any more: what was taken back is removed.
        (None, Some(to)) if build.state != BuildState::Published => open_queue(machine, &to).or_else(|| source.clone()),
        (None, before) => {
            let Some(printer) = choose_for_build(desk.shared.ledger, desk.machines, &build, desk.shared.date()).await?
            else {
                ensure!(
                    before.is_none(),
                    "it was taken back from a printer that is down, and no printer of the machine can be given builds: \
                     `nestd printer NAME up`"
                );
                return Ok(());
            };
            let machine = &desk.machines[&build.profile];
            let chosen = open_queue(machine, &printer);
            if before.as_ref() != Some(&printer) {
                abandoned = before.and_then(|before| open_queue(machine, &before));
                desk.shared.ledger.begin_move(build.id, &printer).await?;
                build = desk.shared.ledger.find_build(build.id).await?.context("its row is gone")?;
            }
            chosen
        }
    };
    if build.place.move_to.is_none() {
        return Ok(());
    }
    let Some(target) = target else {
        ensure!(
            source.is_none(),
            "the queue folder that it goes to is not available; where its printer was removed from the machine's file, configure \
             that printer again: the file may be in its folder"
        );
        // Neither of the two printers is configured any more: nothing of it can be printed here.
        return Ok(desk.shared.ledger.end_move(build.id, MoveEnd::Dropped).await?);
    };
    // Without a folder of origin, it is only removed from the other one.
    let source = source.unwrap_or_else(|| target.clone());
    let (leases, ledger) = (desk.machines[&build.profile].leases.clone(), desk.shared.ledger.clone());
    let moving = MovingBuild { build, source, target, abandoned, misfit, leases, ledger, runtime: Handle::current() };
    desk.jobs.start(MoveBuildJob { build: moving.build.id }, move || moving.go_on());
    Ok(())
}

/// Fails unless a move can be ended without the folder where the build was published: if that is no printer's any more, and the
/// outcome was told.
fn check_missing_source(machine: &MachineState, build: &BuildRow) -> Result<()> {
    ensure!(machine.printers.are_all_open(), "the queue folder that it is taken from is not available");
    let id = build.id;
    ensure!(
        build.state != BuildState::Published,
        "its file was taken back in a queue folder that is no printer's any more: configure that printer again, or have its \
         parts printed again with `nestd outcome {id} failed`"
    );
    Ok(())
}

/// The open queue of a machine that has this id.
pub(super) fn queue_with_marker(machine: &MachineState, marker: Option<&str>) -> Option<OpenQueue> {
    let queues = machine.printers.0.iter().filter_map(|printer| printer.opened.as_ref());
    queues.into_iter().find(|queue| Some(queue.id()) == marker).cloned()
}

impl MovingBuild {
    /// Fails unless this daemon still serves both folders and the ledger.
    fn check_rights(&self) -> Result<()> {
        self.ledger.ensure_served()?;
        self.leases.check_publishing(self.source.address())?;
        Ok(self.leases.check_publishing(self.target.address())?)
    }

    /// The next step, from what the ledger has recorded.
    fn go_on(&self) -> Result<MoveStep> {
        self.check_rights()?;
        let name = self.build.staged.file_name.as_deref().context("its row names no file")?;
        match (self.build.place.move_queue_id.is_some(), self.build.state == BuildState::Published) {
            (false, true) => self.take_and_stage(name),
            (true, true) => self.publish_staged(name),
            (_, false) => self.drop_file(name),
        }
    }

    /// Whether its outcome is not told, as the ledger says at this moment.
    fn is_wanted(&self) -> Result<bool> {
        let now = self.runtime.block_on(self.ledger.find_build(self.build.id))?;
        Ok(now.is_some_and(|now| now.state == BuildState::Published))
    }

    /// Removes the file from both folders.
    fn drop_file(&self, name: &str) -> Result<MoveStep> {
        let may_be_visible = self.build.place.move_queue_id.is_some();
        let is_staged = self.target.state(name)? == FileState::Staged;
        if self.source.holds_taken_back(name) || may_be_visible && is_staged {
            self.runtime.block_on(self.ledger.record_dropped_move(self.build.id))?;
        }
        let step = if may_be_visible && !is_staged {
            match self.target.take_back(name, &|_| Ok(true))? {
                TakeBackOutcome::TakenBack => {
                    self.target.remove_taken_back(name)?;
                    MoveStep::Dropped
                }
                TakeBackOutcome::Gone | TakeBackOutcome::Altered => MoveStep::TakenThere,
            }
        } else {
            discard_staged(&*self.target, name)?;
            MoveStep::Dropped
        };
        self.source.remove_taken_back(name)?;
        Ok(step)
    }

    fn take_and_stage(&self, name: &str) -> Result<MoveStep> {
        let proved = self.build.staged.file_hash.as_deref().context("its row does not say what was proved")?;
        match self.source.take_back(name, &|file| is_of_hash(file, proved))? {
            TakeBackOutcome::TakenBack => {}
            TakeBackOutcome::Gone => return Ok(MoveStep::Taken),
            TakeBackOutcome::Altered => anyhow::bail!(self.not_proved_text()),
        }
        if let Some(why) = &self.misfit {
            anyhow::bail!(
                "it was taken back from a printer that is down and goes to no other one, for {why}. `nestd outcome {} failed` has its \
                 parts printed again for the machine as it is now",
                self.build.id
            );
        }
        if let Some(abandoned) = &self.abandoned {
            discard_staged(&**abandoned, name)?;
        }
        self.target.stage_taken_back(&*self.source, name)?;
        if !has_hash(&self.target.file(name, FileState::Staged)?, proved)? {
            self.target.discard(name)?;
            anyhow::bail!(self.not_proved_text());
        }
        Ok(MoveStep::Staged(self.target.id().to_owned()))
    }

    fn not_proved_text(&self) -> String {
        format!(
            "what lay in the queue folder {} is not the file that was proved; `nestd outcome {} failed` has its parts printed again",
            self.source.address(),
            self.build.id
        )
    }

    fn publish_staged(&self, name: &str) -> Result<MoveStep> {
        if let Some(why) = self.misfit.as_ref().filter(|_| matches!(self.target.state(name), Ok(FileState::Staged))) {
            anyhow::bail!(
                "it was on its way to another printer and is not put into its queue, for {why}. Undo that change of the machine's file and \
                 reload nestd; then `nestd withdraw {}`, and change the file again",
                self.build.id
            );
        }
        // First, so that what was taken back is never there when it may be visible at the other printer.
        self.source.remove_taken_back(name)?;
        self.check_rights()?;
        // The share may have hung since the row was read.
        if !self.is_wanted()? {
            return self.drop_file(name);
        }
        self.target.publish(name)?;
        Ok(MoveStep::Published)
    }
}

/// Removes a copy that was not visible yet.
fn discard_staged(queue: &dyn PrinterQueue, name: &str) -> Result<()> {
    if queue.state(name)? == FileState::Staged {
        queue.discard(name)?;
    }
    Ok(())
}

/// Commits a step of a move.
async fn on_move_step(desk: &mut Building<'_>, id: BuildId, step: Result<MoveStep>) -> Result<()> {
    let Some(build) = desk.shared.ledger.find_build(id).await? else { return Ok(()) };
    let to = build.place.move_to.clone().unwrap_or_default();
    match step {
        Ok(MoveStep::Staged(marker)) => {
            match desk.shared.ledger.record_move(id, &marker).await {
                // Where its outcome was told meanwhile, the next step drops it.
                Ok(()) | Err(LedgerError::WrongState { .. }) => {}
                Err(failure) => return Err(failure.into()),
            }
            return move_builds(desk).await;
        }
        Ok(MoveStep::Published) => {
            if !desk.shared.ledger.finish_move(id).await? {
                // Its outcome was told while it was renamed: it is taken back at once.
                return move_builds(desk).await;
            }
            let from = build.place.printer.clone().unwrap_or_default();
            info!(build.id = %id, profile = %build.profile, "Moved build {id} from the printer {from} to {to}.");
        }
        Ok(MoveStep::Taken) => {
            desk.shared.ledger.end_move(id, MoveEnd::Taken).await?;
            info!(build.id = %id, profile = %build.profile, "Build {id} stays: its printer took it.");
        }
        Ok(MoveStep::Dropped) => desk.shared.ledger.end_move(id, MoveEnd::Dropped).await?,
        Ok(MoveStep::TakenThere) => {
            desk.shared.ledger.end_move(id, MoveEnd::TakenThere).await?;
            report_taken_there(desk, &build, &to).await?;
        }
        Err(failure) => {
            report_move_failure(desk, id, &build.profile, &failure);
            return Ok(());
        }
    }
    desk.nesting.backoff.record_success(&id);
    desk.shared.alerts.clear(AlertKind::PublishingFails, &build.profile, &format!("build {id}"));
    Ok(())
}

/// A printed build whose copies wait again would be printed twice.
async fn report_taken_there(desk: &mut Building<'_>, build: &BuildRow, printer: &str) -> Result<()> {
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

fn report_move_failure(desk: &mut Building<'_>, id: BuildId, profile: &str, failure: &anyhow::Error) {
    desk.nesting.backoff.record_failure(id);
    desk.shared.report_failure(AlertKind::PublishingFails, profile, &format!("build {id}"), failure);
}
