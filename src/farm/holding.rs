//! The folders of every machine are shown to be served, at the start and at each beat of `owner`.

use std::time::Duration;

use anyhow::Result;
use tracing::info;

use super::{attention::Attention, farm::Farm, holds::Holds, jobs::Job, lease, notices::Notices, owner::Hold};

/// What is told of each, in the order of [`Holds::all`].
const AWAY: [Attention; 4] =
    [Attention::HotFolderAway, Attention::QueueAway, Attention::ArchiveAway, Attention::ErrorFolderAway];

/// Showing that a profile's folders are served; gives the holds, with what is wrong with each, and whether its queue folder is
/// the one that was opened.
#[derive(Clone)]
pub(super) struct HoldJob {
    profile: String,
}

impl Job<Farm> for HoldJob {
    const KIND: &'static str = "Hold";
    type Outcome = (Box<Holds>, bool);

    fn about(&self) -> String {
        self.profile.clone()
    }

    async fn done(self, farm: &mut Farm, (holds, is_same_queue): Self::Outcome) -> Result<()> {
        farm.on_held(&self.profile, *holds, is_same_queue).await
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
            self.schedule.last_hold = self.now();
        }
        for (name, station) in self.stations.iter().filter(|(_, s)| is_due || !s.holds.are_fresh()) {
            let (profile, mut holds) = (name.clone(), Box::new(station.holds.clone()));
            let queue = station.queue.opened.clone();
            self.jobs.start(HoldJob { profile }, move || {
                holds.keep();
                let is_same_queue = queue.is_none_or(|queue| queue.check().is_ok());
                (holds, is_same_queue)
            });
        }
    }

    /// Takes in what came of it.
    async fn on_held(&mut self, name: &str, holds: Holds, is_same_queue: bool) -> Result<()> {
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
            if !is_same_queue || !holds.can_publish() {
                // It is opened anew; until then nothing is nested for it.
                station.queue.opened = None;
            }
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
}

fn tell_of_holds(notices: &mut Notices, name: &str, holds: &Holds) {
    for (kind, wrong) in AWAY.into_iter().zip(&holds.wrong) {
        match wrong {
            Some(why) => notices.raise(kind, name, "its owner", why),
            None => notices.clear(kind, name, "its owner"),
        }
    }
}
