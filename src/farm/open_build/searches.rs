//! Starts a search for a build as a job, and keeps what one found that a stop cut short.

use anyhow::Result;
use jobs::{BackgroundJob, Carried, JobRunner};
use ledger::{BuildId, BuildState, Ledger};

use super::batch;
use crate::farm::{
    core::{desks::Searching, farm::Farm},
    nesting::{
        layout_search::{LayoutSearch, SearchCutShort},
        running_searches::RunningSearches,
    },
};

/// The mark that a search runs.
struct SearchMark(LayoutSearch);

impl Carried<Farm> for SearchMark {
    type Desk<'f> = Searching<'f>;

    fn give_back(self, desk: Self::Desk<'_>) {
        desk.searches.remove(&self.0);
    }
}

/// Starts the job of a search for a build: `work` runs with the priority of the search. Until the job has ended, the search counts
/// among those that run.
pub(super) fn start_search<J: BackgroundJob<Farm>>(
    searches: &mut RunningSearches,
    jobs: &mut JobRunner<Farm>,
    (build, search): (BuildId, &LayoutSearch),
    job: J,
    work: impl FnOnce() -> J::Outcome + Send + 'static,
) {
    searches.add(build, search.clone());
    let policy = search.policy;
    jobs.start_with(job, SearchMark(search.clone()), move |_| {
        policy.lower_priority();
        work()
    });
}

/// Keeps what the search of a fired build has found that was stopped: it goes on from there. Nothing is published of it, for it could be
/// lower.
pub(crate) async fn leave_search(ledger: &Ledger, build: BuildId, cut_short: &SearchCutShort) -> Result<()> {
    if ledger.find_build(build).await?.is_none_or(|row| row.state != BuildState::Nesting) {
        return Ok(());
    }
    if let Some(layout) = &cut_short.layout {
        batch::save_layout(ledger, build, layout).await?;
    }
    Ok(ledger.leave_search(build, cut_short.cpu_secs, cut_short.wall_secs).await?)
}
