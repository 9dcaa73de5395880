//! The printer queue folders: opened anew when one was away, swept of what a crash left half written, and rid of the files of a
//! build that is given up. All on threads, for a queue folder may be a share that hangs.

use std::time::Duration;

use anyhow::{Context, Result, ensure};
use tracing::{info, warn};

use super::{attention::Attention, failure::chain, farm::Farm, jobs::Job, owner::Hold, prove::file_name, record};
use crate::{
    ledger::{BuildId, BuildRow, BuildState, Ledger, Verified},
    queue::{Queue, QueueError, StagedState},
};

/// A queue folder that cannot be opened is tried again after so long.
const OPEN_AGAIN: Duration = Duration::from_secs(1);

/// Opening a profile's queue folder.
#[derive(Clone)]
pub(super) struct OpenQueueJob {
    profile: String,
}

impl Job<Farm> for OpenQueueJob {
    const KIND: &'static str = "Queue";
    /// The folder, or why it cannot be used.
    type Outcome = Result<Queue, String>;

    fn about(&self) -> String {
        self.profile.clone()
    }

    async fn done(self, farm: &mut Farm, opened: Self::Outcome) -> Result<()> {
        farm.on_queue_opened(&self.profile, opened);
        Ok(())
    }
}

/// Removing what is staged of a build that is given up.
#[derive(Clone)]
struct DiscardJob {
    build: BuildId,
}

impl Job<Farm> for DiscardJob {
    const KIND: &'static str = "Discard";
    type Outcome = Result<bool, QueueError>;

    fn about(&self) -> String {
        self.build.to_string()
    }

    async fn done(self, _farm: &mut Farm, discarded: Self::Outcome) -> Result<()> {
        // What cannot be removed now is swept when the folder is opened next.
        if let Err(failure) = discarded {
            warn!(build.id = %self.build, "The build's dot-file could not be removed: {failure}.");
        }
        Ok(())
    }
}

impl Farm {
    /// Starts to open the queue folders that are not open.
    pub(super) async fn open_queues(&mut self) -> Result<()> {
        let now = self.now();
        let is_due = |station: &super::station::Station| station.queue.opened.is_none() && now >= station.queue.open_at;
        if !self.stations.values().any(is_due) {
            return Ok(());
        }
        let mut staged = Vec::new();
        // A build that is being nested may have been staged already: only what no build names is swept.
        for state in [BuildState::Nesting, BuildState::Verified] {
            for build in self.ledger.builds_in_state(state).await? {
                staged.push(build.staged.file_name.clone().unwrap_or_else(|| file_name(&build.profile, &build)));
            }
        }
        for (name, station) in self.stations.iter_mut().filter(|(_, station)| is_due(station)) {
            station.queue.open_at = now + OPEN_AGAIN;
            let opening = QueueOpening {
                profile: name.clone(),
                hold: station.holds.queue.clone(),
                staged: staged.clone(),
                ledger: self.ledger.clone(),
            };
            let runtime = tokio::runtime::Handle::current();
            self.jobs.start(OpenQueueJob { profile: name.clone() }, move || runtime.block_on(opening.open_and_sweep()));
        }
        Ok(())
    }

    fn on_queue_opened(&mut self, name: &str, opened: Result<Queue, String>) {
        let Some(station) = self.stations.get_mut(name) else { return };
        match opened {
            // After a reload the folder may be another.
            Ok(queue) if queue.dir() != station.profile.folders.queue => {}
            Ok(queue) => {
                station.queue.opened = Some(queue);
                self.notices.clear(Attention::QueueAway, name, "");
            }
            Err(why) => self.notices.raise(Attention::QueueAway, name, "", &why),
        }
    }

    /// Whether builds can be written into the queue folder of a profile, as it was when it was last looked at. One that is away
    /// costs no attempt.
    pub(super) fn has_queue(&self, profile: &str) -> bool {
        let Some(station) = self.stations.get(profile) else { return false };
        station.agrees.is_some() && station.queue.opened.is_some() && station.holds.are_fresh()
    }

    /// A written build is taken into the ledger only where its queue folder is the one that is configured now.
    pub(super) async fn demand_same_queue(&self, build: BuildId, verified: &Verified) -> Result<()> {
        let profile = self.ledger.build(build).await?.map(|b| b.profile).unwrap_or_default();
        let queue = self.stations.get(&profile).and_then(|s| s.queue.opened.as_ref());
        let queue = queue.context("the queue folder is not available any more")?;
        ensure!(queue.id() == verified.file.queue_id, "the queue folder has changed since the build was written");
        Ok(())
    }

    /// Starts to remove what is staged of a build that is given up.
    pub(super) fn discard_staged(&mut self, build: &BuildRow) {
        let Some(queue) = self.stations.get(&build.profile).and_then(|s| s.queue.opened.clone()) else { return };
        let name = file_name(&build.profile, build);
        self.jobs.start(DiscardJob { build: build.id }, move || queue.discard(&name));
    }
}

/// What opening a queue folder needs.
struct QueueOpening {
    profile: String,
    hold: Hold,
    /// The builds that may be staged.
    staged: Vec<String>,
    ledger: Ledger,
}

impl QueueOpening {
    /// Opens the folder and sweeps what a crash left half written in it.
    async fn open_and_sweep(mut self) -> Result<Queue, String> {
        // An empty mount point is not marked as a queue.
        self.hold.check().map_err(|error| error.to_string())?;
        let queue = Queue::open(self.hold.folder()).map_err(|error| chain(&error))?;
        // What this farm has not fired is staged by another one, and left alone.
        for file in queue.staged_builds().unwrap_or_default() {
            if !is_own(&self.ledger, &self.profile, &file).await.map_err(|error| format!("{error:#}"))? {
                self.staged.push(file);
            }
        }
        let swept = queue.sweep(&self.staged).map_err(|error| chain(&error))?;
        if !swept.is_empty() {
            info!(profile = %self.profile, files = swept.len(), "Removed half-written files of an earlier run.");
        }
        Ok(queue)
    }
}

/// Whether a build file is one of the builds that this farm has fired. An open one has no file yet: what bears the name that it
/// would have now is another farm's.
async fn is_own(ledger: &Ledger, profile: &str, file: &str) -> Result<bool> {
    let Some((_, number)) = record::fired_and_number(file) else { return Ok(false) };
    let build = ledger.build(BuildId(number)).await?;
    Ok(build.is_some_and(|build| build.state != BuildState::Open && file_name(profile, &build) == file))
}

/// A build that was written lies under its dot-name in the queue, or something took it away at once.
///
/// # Errors
/// The queue folder cannot be looked at, or the file is not there.
pub(super) fn demand_staged(queue: &Queue, name: &str) -> Result<()> {
    ensure!(queue.state(name)? == StagedState::Staged, "the written build is gone from the queue folder");
    Ok(())
}
