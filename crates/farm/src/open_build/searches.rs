//! Starts a search for a build as a job.

use jobs::{BackgroundJob, Carried, JobRunner};
use ledger::BuildId;

use crate::{
    core::{desks::Searching, farm::Farm},
    nesting::{layout_search::LayoutSearch, running_searches::RunningSearches},
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
