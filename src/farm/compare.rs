//! The folders of every machine are held against the ledger while the farm runs.

use anyhow::Result;

use super::{
    attention::Attention,
    current::{Compared, compare},
    farm::Farm,
    jobs::Job,
};

/// Holding a profile's folders against the ledger.
#[derive(Clone)]
pub(super) struct CompareJob {
    profile: String,
}

impl Job<Farm> for CompareJob {
    const KIND: &'static str = "Compare";
    type Outcome = Compared;

    fn about(&self) -> String {
        self.profile.clone()
    }

    async fn done(self, farm: &mut Farm, compared: Self::Outcome) -> Result<()> {
        farm.on_compared(&self.profile, compared);
        Ok(())
    }
}

impl Farm {
    /// Starts to hold the folders of every machine against the ledger. Until they agree, nothing is
    /// printed, and where they disagree, nothing is taken.
    pub(super) fn compare_folders(&mut self) {
        for (name, station) in &self.stations {
            let (settings, ledger, profile) = (self.settings.clone(), self.ledger.clone(), station.profile.clone());
            let (before, runtime) = (station.agrees, tokio::runtime::Handle::current());
            self.jobs.start(CompareJob { profile: name.clone() }, move || {
                runtime.block_on(compare(&settings, &ledger, &profile, before))
            });
        }
    }

    /// Takes in what came of it.
    fn on_compared(&mut self, name: &str, compared: Compared) {
        let Some(station) = self.stations.get_mut(name) else { return };
        let (behind, away) = match compared {
            Compared::AsBefore => return,
            Compared::Agrees(seen) => {
                station.agrees = Some(seen);
                station.batch_at = self.schedule.time.instant();
                (None, None)
            }
            Compared::Behind(detail) => (Some(detail), None),
            Compared::Away(why) => (None, Some(why)),
        };
        station.may_take = behind.is_none();
        if behind.is_some() || away.is_some() {
            station.agrees = None;
        }
        for (kind, detail) in [(Attention::LedgerBehind, behind), (Attention::FoldersMissing, away)] {
            match detail {
                Some(detail) => self.notices.raise(kind, name, "told", &detail),
                None => self.notices.clear(kind, name, "told"),
            }
        }
    }
}
