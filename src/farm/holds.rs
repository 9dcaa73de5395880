//! The folders of every station are shown to be served, at the start and at each beat of `owner`.

use std::time::{Duration, Instant};

use anyhow::Result;
use tracing::{info, warn};

use super::{
    attention::Attention,
    event::Event,
    farm::Farm,
    jobs::JobKey,
    lease::{self, Stamp},
    notices::Notices,
    owner::{Hold, Owner, OwnerError},
    receive::Gate,
    station::Station,
};
use crate::{
    intake,
    settings::{Folders, Profile},
};

/// The hold on the folders of a profile.
#[derive(Debug, Clone)]
pub struct Holds {
    /// Of the hot folder.
    pub inbox: Hold,
    /// Of the queue folder.
    pub queue: Hold,
    /// Of the archive.
    pub archive: Hold,
    /// Of the error folder.
    pub error: Hold,
    /// What is wrong, of each; in plain words.
    pub wrong: [Option<String>; 4],
    /// When they were looked at last; `None` = never.
    looked: Option<Stamp>,
    /// Claims of this farm that another one has taken over.
    taken_over: Vec<String>,
    /// How many claims of other farms lie in the hot folder.
    foreign: usize,
}

/// What is told of each, in the order of [`Holds::all`].
const AWAY: [Attention; 4] =
    [Attention::HotFolderAway, Attention::QueueAway, Attention::ArchiveAway, Attention::ErrorFolderAway];

impl Holds {
    /// Holds that are not taken yet.
    pub fn new(owner: &Owner, profile: &Profile) -> Self {
        let hold = |folder| Hold::new(owner.clone(), folder);
        let Folders { inbox, queue, error, archive } = &profile.folders;
        Self {
            inbox: hold(inbox),
            queue: hold(queue),
            archive: hold(archive),
            error: hold(error),
            wrong: Default::default(),
            looked: None,
            taken_over: Vec::new(),
            foreign: 0,
        }
    }

    fn all(&mut self) -> [&mut Hold; 4] {
        [&mut self.inbox, &mut self.queue, &mut self.archive, &mut self.error]
    }

    /// Whether they were looked at a moment ago, so that nobody else can have taken them since.
    pub fn are_fresh(&self) -> bool {
        self.looked.is_some_and(Stamp::holds)
    }

    fn keep(&mut self) {
        self.looked = Some(Stamp::now());
        self.wrong = self.all().map(|hold| hold.keep().err().map(|error| error.to_string()));
        if let Ok(taken_over) = intake::taken_over(self.inbox.folder(), self.inbox.farm()) {
            self.taken_over = taken_over;
        }
        if let Ok(foreign) = intake::foreign(self.inbox.folder(), self.inbox.farm()) {
            self.foreign = foreign.len();
        }
    }

    /// Takes hold of the folders that are not held yet; whether it is clear of each.
    fn keep_at_start(&mut self) -> Result<bool, OwnerError> {
        let (mut wrong, mut is_clear) = (self.wrong.clone(), true);
        for (hold, wrong) in self.all().into_iter().zip(&mut wrong).filter(|(hold, _)| hold.seen().is_none()) {
            *wrong = match hold.keep() {
                Ok(()) => None,
                Err(refused @ OwnerError::Other { .. }) => return Err(refused),
                Err(error) => {
                    is_clear &= !matches!(error, OwnerError::Unclear { .. });
                    Some(error.to_string())
                }
            };
        }
        self.wrong = wrong;
        Ok(is_clear)
    }

    /// Whether queue and archive are those of before: a build is published into both.
    pub fn demand_published(&self) -> Result<(), OwnerError> {
        self.archive.demand_mine()?;
        self.queue.demand_mine()
    }

    /// Whether files may be taken out of the hot folder at this moment.
    pub fn may_take(&self) -> bool {
        self.are_fresh() || self.inbox.demand_mine().is_ok()
    }

    /// Whether what is in the error folder can be relied on, and things can be put there.
    pub fn demand_error(&self) -> Result<(), OwnerError> {
        self.error.clone().check()
    }
}

impl Farm {
    /// Takes hold of every folder. One that another daemon serves refuses the start; one that is away is tried again. Waits
    /// until it is clear whether another daemon that is named somewhere lives.
    pub(super) fn hold_folders_at_start(&mut self) -> Result<()> {
        let mut is_told = false;
        loop {
            let mut unclear = None;
            for station in self.stations.values_mut() {
                if !station.holds.keep_at_start()? {
                    unclear = station.holds.wrong.iter().flatten().next().cloned();
                }
            }
            let Some(unclear) = unclear else { break };
            if !is_told {
                info!("{unclear}; that takes up to {} s.", lease::dead_after().as_secs());
            }
            is_told = true;
            std::thread::sleep(Duration::from_secs(1));
        }
        for (name, station) in &self.stations {
            tell_of_holds(&mut self.notices, name, &station.holds);
        }
        Ok(())
    }

    /// Shows that every folder is still served, when it is time to; of a machine whose folders were not looked at for too long
    /// at once. Nothing is done with its parts meanwhile.
    pub(super) fn keep_holds(&mut self, is_due: bool) {
        if is_due {
            self.last_hold = Instant::now();
        }
        for (name, station) in self.stations.iter().filter(|(_, s)| is_due || !s.holds.are_fresh()) {
            let (profile, mut holds) = (name.clone(), Box::new(station.holds.clone()));
            self.jobs.start(JobKey::Hold(name.clone()), move || {
                holds.keep();
                Event::Held { profile, holds }
            });
        }
    }

    /// Takes in what came of it.
    pub(super) async fn on_held(&mut self, name: &str, holds: Holds) -> Result<()> {
        self.jobs.ended(&JobKey::Hold(name.to_owned()));
        // After a reload the folders may be others.
        let Some(station) = self.stations.get_mut(name).filter(|s| s.holds.inbox.is_of(&holds.inbox)) else {
            return Ok(());
        };
        tell_of_holds(&mut self.notices, name, &holds);
        let (before, now) = (station.holds.foreign, holds.foreign);
        let taken_over = holds.taken_over.clone();
        self.give_up_claims(name, &taken_over).await?;
        // Only now its folders count as looked at.
        if let Some(station) = self.stations.get_mut(name) {
            station.holds = holds;
        }
        self.tell_of_foreign_claims(name, before, now);
        Ok(())
    }

    /// Lets the folders go.
    pub(super) fn end_holds(&mut self) {
        for station in self.stations.values_mut() {
            station.holds.all().into_iter().for_each(Hold::end);
        }
    }

    /// A hot folder is looked at by a gate that remembers nothing.
    pub(super) fn new_gate(&mut self, name: &str) {
        let scan_secs = self.settings.scan_secs;
        if let Some(station) = self.stations.get_mut(name) {
            station.gate = Some(Box::new(Gate::new(&station.profile, self.settings.orphan_ticket_secs)));
            station.look_at = Instant::now() + Duration::from_secs_f64(scan_secs);
        }
    }

    /// There was no thread for a job: its step finds the work again.
    pub(super) fn on_not_started(&mut self, key: JobKey, why: &str) {
        warn!("A job could not be started ({key:?}): {why}.");
        self.jobs.ended(&key);
        match key {
            JobKey::Receive(name) => self.new_gate(&name),
            JobKey::Read(part) => self.read_again.failed(part),
            JobKey::Improve(name) => {
                if let Some(Station { open, .. }) = self.stations.get_mut(&name) {
                    open.ended(open.rounds, None);
                }
            }
            JobKey::Final(build) => {
                self.finals.remove(&build);
                self.fresh_builds.insert(build);
                self.resting.failed(build);
            }
            JobKey::Publish(build) => self.resting.failed(build),
            JobKey::Copy(part) => self.on_not_copied(part, &anyhow::anyhow!("{why}")),
            JobKey::End(_)
            | JobKey::Damaged
            | JobKey::Purge
            | JobKey::Hold(_)
            | JobKey::Compare(_)
            | JobKey::Stray
            | JobKey::Tell(_) => {}
        }
    }
}

fn tell_of_holds(notices: &mut Notices, name: &str, holds: &Holds) {
    for (kind, wrong) in AWAY.into_iter().zip(&holds.wrong) {
        match wrong {
            Some(why) => notices.raise(kind, name, "its owner", why),
            None => notices.clear(kind, name, "its owner"),
        }
    }
}
