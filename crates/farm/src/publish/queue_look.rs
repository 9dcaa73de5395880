//! Looks into the queue folders of the machines for their published builds: which were taken, and which are not where the
//! ledger has them. The latter happens where a ledger was put back from a backup, or is a new one.

use std::sync::Arc;

use anyhow::{Context, Result};
use build_file::format_count;
use delivery::queue::{FileState, OpenQueue, PrinterQueue};
use jobs::BackgroundJob;
use ledger::{BuildId, BuildRow, BuildState, FoundPlace, Ledger, QueuedBuild};
use settings::MachineProfile;
use tokio::runtime::Handle;
use tracing::{info, warn};

use crate::{
    alerts::{alert::AlertKind, alert_registry::AlertRegistry},
    core::{desks::Serving, farm::Farm, machine_state::QueuedRows, printer_state::MachinePrinters},
    leases::folder_leases::FolderLeases,
    printers::queue_alerts::report_wrong_files,
    scanning::{
        queue_contents::{BuildFiles, SoughtFile},
        queue_files::{QueueFileFindings, QueueFileLook},
    },
};

/// Newest builds of a machine whose files are looked for.
const MAX_LOOKED_FOR: u32 = 50;

/// Looks into the queue folders of a machine.
#[derive(Clone)]
struct QueueLookJob {
    machine: String,
}

/// What was found.
#[derive(Debug, Default)]
struct QueueFindings {
    /// The builds that were taken, each with the marker of the folder where it lay.
    taken: Vec<(BuildId, String)>,
    /// The builds that are elsewhere than the ledger has them.
    elsewhere: Vec<(BuildId, FoundPlace)>,
    /// The visible files; `None` = the ledger did not say whose they are.
    files: Option<QueueFileFindings>,
}

impl BackgroundJob<Farm> for QueueLookJob {
    const KIND: &'static str = "Look";
    const IS_LOOK: bool = true;
    type Outcome = QueueFindings;
    type Desk<'f> = Serving<'f>;

    fn subject(&self) -> String {
        self.machine.clone()
    }

    async fn on_done(self, desk: Self::Desk<'_>, found: Self::Outcome) -> Result<()> {
        for (build, queue_id) in found.taken {
            desk.shared.ledger.record_taken(build, &queue_id).await?;
        }
        for (build, place) in found.elsewhere {
            let what =
                if place.is_taken_back { "taken back, and goes into a queue again" } else { "in its queue folder" };
            info!(build.id = %build, machine = %self.machine, "Build {build} was found at {}: {what}.", place.printer);
            desk.shared.ledger.correct_place(build, &place).await?;
        }
        if let Some(files) = found.files {
            for (build, printer, queue_id) in files.back {
                info!(build.id = %build.id, machine = %self.machine, "The file of build {} lies in the queue of {printer} again.", build.id);
                desk.shared.ledger.record_back_in_queue(build.id, &printer, &queue_id).await?;
            }
            for (build, place) in files.second {
                info!(build.id = %build, machine = %self.machine, "A second file of build {build} lies in a queue: {place}.");
                desk.shared.ledger.record_second_file(build, &place).await?;
            }
            report_wrong_files(desk.shared.alerts, &self.machine, &files.wrong);
        }
        Ok(())
    }
}

/// Starts jobs that look into the queue folders.
pub(crate) async fn look_at_queues(desk: &mut Serving<'_>) -> Result<()> {
    for (name, machine) in desk.machines.iter_mut() {
        let QueuedRows { wanted, copied } = match &machine.queued {
            Some(known) => known.clone(),
            None => {
                let wanted = desk.shared.ledger.newest_queued(name, MAX_LOOKED_FOR).await?;
                let copied = desk.shared.ledger.builds_with_second_files(name, MAX_LOOKED_FOR).await?;
                machine.queued.insert(QueuedRows { wanted, copied }).clone()
            }
        };
        let look = QueueLook {
            profile: machine.profile.clone(),
            queues: machine.printers.open_queues(),
            leases: machine.leases.clone(),
            ledger: desk.shared.ledger.clone(),
            runtime: Handle::current(),
        };
        report_removed_printers(desk.shared.alerts, &machine.printers, name, &wanted);
        if !look.queues.is_empty() {
            desk.jobs.start(QueueLookJob { machine: name.clone() }, move || look.look_for(wanted, &copied));
        }
    }
    Ok(())
}

/// Builds in the queue folder of a printer that is configured no more are looked after by nobody.
fn report_removed_printers(
    alerts: &mut AlertRegistry,
    printers: &MachinePrinters,
    machine: &str,
    builds: &[QueuedBuild],
) {
    // The folder of a printer with another name may be opened yet.
    if !printers.are_all_open() {
        return;
    }
    let is_left_behind = |build: &&QueuedBuild| printers.find(&build.printer).is_none() && build.queue_id.is_some();
    let left: Vec<&QueuedBuild> = builds.iter().filter(is_left_behind).collect();
    let Some(first) = left.first() else {
        alerts.clear(AlertKind::QueueReplaced, machine, "removed printers");
        return;
    };
    let text = format!(
        "the printer {} is configured no more, and {} may lie in its queue folder, as build {}",
        first.printer,
        format_count(left.len(), "build", "builds"),
        first.build
    );
    alerts.raise(AlertKind::QueueReplaced, machine, "removed printers", &text);
}

/// The open queue folders of a machine, by the names of its printers.
struct QueueLook {
    profile: Arc<MachineProfile>,
    queues: Vec<(String, OpenQueue)>,
    leases: FolderLeases,
    ledger: Ledger,
    runtime: Handle,
}

impl QueueLook {
    fn look_for(&self, wanted: Vec<QueuedBuild>, copied: &[BuildRow]) -> QueueFindings {
        let files = match self.look_at_files(copied) {
            Ok(files) => Some(files),
            Err(failure) => {
                warn!(machine = %self.profile.name, "The files in the queues are looked at later: {failure:#}.");
                None
            }
        };
        let mut found = QueueFindings { files, ..QueueFindings::default() };
        for build in wanted {
            let own = self.queues.iter().find(|(_, queue)| Some(queue.id()) == build.queue_id.as_deref());
            // Another folder than the one that it was published in says nothing.
            let (Some((_, own)), Some(file)) = (own, build.file_name) else { continue };
            if !matches!(own.state(&file), Ok(FileState::Gone)) {
                continue;
            }
            let Ok(second) = self.second_files(build.build) else { continue };
            let sought = SoughtFile { name: &file, queue_id: build.queue_id.as_deref(), second: &second };
            match BuildFiles::find_named(&self.queues, &sought) {
                BuildFiles { own: Some(there), .. } => {
                    let place = FoundPlace {
                        printer: there.printer,
                        queue_id: there.queue.id().to_owned(),
                        instead_of: build.queue_id,
                        is_taken_back: false,
                    };
                    found.elsewhere.push((build.build, place));
                }
                BuildFiles { taken_back: Some(_), .. } => {}
                _ => found.taken.push((build.build, own.id().to_owned())),
            }
        }
        for (printer, queue) in &self.queues {
            // A folder that is away keeps nobody from looking into the others.
            for file in queue.names(FileState::TakenBack).unwrap_or_default() {
                match self.settle_withdrawn(printer, &**queue, &file) {
                    Ok(place) => found.elsewhere.extend(place),
                    Err(failure) => {
                        warn!(machine = %self.profile.name, "{file} was taken back and stays so: {failure:#}.")
                    }
                }
            }
        }
        found
    }

    fn second_files(&self, build: BuildId) -> Result<Vec<String>> {
        Ok(self.runtime.block_on(self.ledger.second_files(build))?)
    }

    /// Looks at the visible files.
    fn look_at_files(&self, copied: &[BuildRow]) -> Result<QueueFileFindings> {
        let look = QueueFileLook {
            profile: &self.profile,
            queues: &self.queues,
            find_build: &|name| Ok(self.runtime.block_on(self.ledger.find_build_of_file(name))?),
            has_bad_copies: &|build| Ok(self.runtime.block_on(self.ledger.has_bad_copies(build.id))?),
            second_files: &|build| self.second_files(build.id),
            copied,
        };
        look.look()
    }

    /// A file that was taken back belongs to a move or a withdrawal. Where the ledger knows of none, a file that is there was not printed: it goes
    /// into a queue again, unless the outcome of its build was told.
    fn settle_withdrawn(
        &self,
        printer: &str,
        queue: &dyn PrinterQueue,
        file: &str,
    ) -> Result<Option<(BuildId, FoundPlace)>> {
        let row = self.runtime.block_on(self.ledger.find_build_of_file(file))?;
        // Other farms and machines have files of their own.
        let Some(build) = row.filter(|build| build.machine == self.profile.name && !build.place.is_on_its_way()) else {
            return Ok(None);
        };
        if build.state == BuildState::Published {
            return self.find_withdrawn(printer, queue, build);
        }
        if build.times.published_at.is_some() {
            self.ledger.ensure_served()?;
            self.leases.check_publishing(queue.address())?;
            queue.remove_taken_back(file)?;
        }
        Ok(None)
    }

    fn find_withdrawn(
        &self,
        printer: &str,
        queue: &dyn PrinterQueue,
        build: BuildRow,
    ) -> Result<Option<(BuildId, FoundPlace)>> {
        let file = build.staged.file_name.as_deref().context("its row names no file")?;
        let place = FoundPlace {
            printer: printer.to_owned(),
            queue_id: queue.id().to_owned(),
            instead_of: build.staged.queue_id.clone(),
            is_taken_back: true,
        };
        // Once more: its move may have ended before the row was read.
        Ok(queue.holds_taken_back(file).then_some((build.id, place)))
    }
}
