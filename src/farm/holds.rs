//! The folders of every station are shown to be served, at the start and at each beat of `owner`.

use std::time::{Duration, Instant};

use anyhow::Result;
use tracing::warn;

use super::{
    attention::Attention,
    event::Event,
    farm::Farm,
    jobs::JobKey,
    owner::{Hold, Owner, OwnerError},
    receive::Gate,
    station::Station,
};
use crate::settings::Profile;

/// The hold on both folders of a profile that others put things into or take things from.
#[derive(Debug, Clone)]
pub struct Holds {
    /// Of the hot folder.
    pub inbox: Hold,
    /// Of the queue folder.
    pub queue: Hold,
    /// What is wrong, of each; in plain words.
    pub wrong: [Option<String>; 2],
}

impl Holds {
    /// Holds that are not taken yet.
    pub fn new(owner: &Owner, profile: &Profile) -> Self {
        let hold = |folder| Hold::new(owner.clone(), folder);
        Self { inbox: hold(&profile.folders.inbox), queue: hold(&profile.folders.queue), wrong: [None, None] }
    }

    fn keep(&mut self) {
        self.wrong = [&mut self.inbox, &mut self.queue].map(|hold| hold.keep().err().map(|error| error.to_string()));
    }
}

impl Farm {
    /// Takes hold of every folder. One that another daemon serves refuses the start; one that is away is tried again.
    pub(super) fn hold_folders_at_start(&mut self) -> Result<()> {
        for station in self.stations.values_mut() {
            let Holds { inbox, queue, wrong } = &mut station.holds;
            for (hold, wrong) in [inbox, queue].into_iter().zip(wrong) {
                match hold.keep_at_start() {
                    Ok(()) => {}
                    Err(refused @ OwnerError::Other { .. }) => return Err(refused.into()),
                    Err(error) => *wrong = Some(error.to_string()),
                }
            }
        }
        Ok(())
    }

    /// Shows that every folder is still served.
    pub(super) fn keep_holds(&mut self) {
        for (name, station) in &self.stations {
            let (profile, mut holds) = (name.clone(), Box::new(station.holds.clone()));
            self.jobs.start(JobKey::Hold(name.clone()), move || {
                holds.keep();
                Event::Held { profile, holds }
            });
        }
    }

    /// Takes in what came of it.
    pub(super) fn on_held(&mut self, name: &str, holds: Holds) {
        self.jobs.ended(&JobKey::Hold(name.to_owned()));
        let wrong = holds.wrong.clone();
        // After a reload the folders may be others.
        let Some(station) = self.stations.get_mut(name).filter(|s| s.holds.inbox.is_of(&holds.inbox)) else { return };
        station.holds = holds;
        for (kind, wrong) in [Attention::HotFolderAway, Attention::QueueAway].into_iter().zip(wrong) {
            match wrong {
                Some(why) => self.notices.raise(kind, name, "its owner", &why),
                None => self.notices.clear(kind, name, "its owner"),
            }
        }
    }

    /// Lets the folders go.
    pub(super) fn end_holds(&mut self) {
        for station in self.stations.values_mut() {
            station.holds.inbox.end();
            station.holds.queue.end();
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
            JobKey::Purge | JobKey::Hold(_) | JobKey::Stray | JobKey::Tell(_) => {}
        }
    }
}
