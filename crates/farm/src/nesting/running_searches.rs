//! The searches that run for builds, and how they share the threads of the farm.

use ledger::BuildId;

use super::{
    layout_search::{LayoutSearch, SearchCutShort},
    search_policy::SearchPolicy,
};

/// A search may end so much after its time before others begin beside it, seconds: a build that takes long to prove or prepare must not
/// block other machines.
const OVERDUE_SECS: f64 = 2.0;

/// The searches that run, each until its job has ended.
#[derive(Debug, Default)]
pub(crate) struct RunningSearches {
    /// Maximum number of searches at once.
    pub(crate) slots: usize,
    running: Vec<(BuildId, LayoutSearch)>,
}

impl RunningSearches {
    /// No search yet, of which so many may run at once.
    pub(crate) fn of_slots(slots: usize) -> Self {
        Self { slots, running: Vec::new() }
    }

    /// Adds one that begins.
    pub(crate) fn add(&mut self, build: BuildId, search: LayoutSearch) {
        self.running.push((build, search));
    }

    /// Removes one whose job has ended.
    pub(crate) fn remove(&mut self, search: &LayoutSearch) {
        self.running.retain(|(_, other)| !other.is(search));
    }

    /// Whether a search for an arrival or a fired build may begin. Those that give way do not count.
    pub(crate) fn has_free_slot(&self) -> bool {
        self.holding_slots() < self.slots
    }

    /// Whether a search that gives way may begin.
    pub(crate) fn has_idle_slot(&self) -> bool {
        self.holding_slots() + self.giving_way().count() < self.slots
    }

    /// Stops searches that give way where others need their threads.
    pub(crate) fn stop_surplus(&self) {
        let may_run = self.slots.saturating_sub(self.holding_slots());
        self.giving_way().skip(may_run).for_each(LayoutSearch::stop);
    }

    /// Stops all of them.
    pub(crate) fn stop_all(&self) {
        self.running.iter().for_each(|(_, search)| search.stop());
    }

    /// Stops that for a build.
    pub(crate) fn stop_for(&self, build: BuildId) {
        self.running.iter().filter(|(of, _)| *of == build).for_each(|(_, search)| search.stop());
    }

    /// The fired builds whose final search runs.
    pub(crate) fn finals(&self) -> impl Iterator<Item = (BuildId, &LayoutSearch)> {
        let finals = self.running.iter().filter(|(_, search)| matches!(search.policy, SearchPolicy::Final { .. }));
        finals.map(|(build, search)| (*build, search))
    }

    /// What is kept of the final searches, for the builds that will be searched again.
    pub(crate) fn cut_short(&self) -> Vec<(BuildId, SearchCutShort)> {
        self.finals().map(|(build, search)| (build, search.cut_short())).collect()
    }

    fn holding_slots(&self) -> usize {
        let holds = |search: &LayoutSearch| !search.policy.gives_way() && search.secs_over() <= OVERDUE_SECS;
        self.running.iter().filter(|(_, search)| holds(search)).count()
    }

    fn giving_way(&self) -> impl Iterator<Item = &LayoutSearch> {
        let searches = self.running.iter().map(|(_, search)| search);
        searches.filter(|search| search.policy.gives_way() && !search.is_stopped())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_gives_way_takes_no_slot_and_is_stopped_when_others_need_its_thread() {
        let waiting = || LayoutSearch::begin(SearchPolicy::Waiting { cpu_secs: 9.0, earlier_cpu_secs: 0.0 });
        let [first, second] = [waiting(), waiting()];
        let last = LayoutSearch::begin(SearchPolicy::Final { secs: 60.0, seed: 1 });
        let mut searches = RunningSearches::of_slots(2);
        searches.add(BuildId(1), first.clone());
        assert_eq!((searches.has_free_slot(), searches.has_idle_slot()), (true, true));
        searches.add(BuildId(2), second.clone());
        assert_eq!((searches.has_free_slot(), searches.has_idle_slot()), (true, false));
        searches.stop_surplus();
        assert!(!first.is_stopped() && !second.is_stopped());
        searches.add(BuildId(3), last.clone());
        searches.stop_surplus();
        assert_eq!((first.is_stopped(), second.is_stopped()), (false, true));
        assert!(searches.has_free_slot());
        searches.add(BuildId(4), LayoutSearch::begin(SearchPolicy::Arrival { secs: 60.0, round: 1 }));
        assert!(!searches.has_free_slot());
        searches.remove(&last);
        assert!(searches.has_free_slot() && searches.finals().next().is_none());
        searches.stop_for(BuildId(1));
        assert!(first.is_stopped());
    }
}
