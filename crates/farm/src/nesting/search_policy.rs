//! What the searches of the farm differ in: one driver makes them all (`layout_search`), and whoever begins one says what it is for.
//!
//! | | arrival | waiting | final | quote |
//! |---|---|---|---|---|
//! | begins when | other copies wait than were tried | nothing is wanted of the open build | a build has fired | somebody asks |
//! | time | `arrival_secs`, at least 0.02 s a copy | CPU time of a round that doubles | `final_secs`, half of it at each attempt after a crash or a failure, without what was searched before a stop | a share of the time in which an answer is due |
//! | threads | one search's share of the farm's | the same, while nobody else needs it | the same | one, beside all others |
//! | priority | low | lowest | normal | low |
//! | begins from | the lower of the open build's layout and the kept one | the open build's layout and the kept pool | the layout that the build fired with, or its poses | the open build's layout, which stays |
//! | stops before | other copies wait | anything else is wanted | - | - |
//! | what it finds | is the open build's layout (`open_build/batch`) | is taken if it is lower, with the pool (`open_build/night_search`) | is written and proved (`open_build/nest`) | is a height (`planning/quote_insertion`) |
//! | after a restart | begins from the layout in the ledger | goes on with its round and pool in the ledger | goes on from its layout in the ledger | - |
//!
//! All of them end when the daemon stops, and their best layout so far is kept. Nothing of a final search is published before its time is
//! over: a lower build is worth more than one that comes a minute sooner.

use std::time::Instant;

use nester::{
    ImprovedLayouts, InterlockRule, ItemPlacement, NestingConfig, NestingInstance, NestingMethod, NestingSolution,
    PreparedMeshes, ProgressListener, SearchBudget, StopCondition,
};
use settings::MachineProfile;

use crate::{
    decisions::layout::{LayoutPlacement, NestingBatch},
    process::thread_priority::{ARRIVAL_NICENESS, NIGHT_NICENESS, lower_thread_priority},
};

/// Minimum time of a search for each copy, seconds: long enough to try all of them.
const SECS_PER_COPY: f64 = 0.02;
/// Share of the time that is left in which parts make room for quoted ones. A copy that is being placed is placed to the end.
const QUOTE_SHARE: f64 = 0.3;
/// The seeds of the searches while a build waits begin here, far from those of the searches for arrivals.
const FIRST_WAITING_SEED: u64 = 1 << 40;

/// What a search is for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SearchPolicy {
    /// Parts have arrived, and get their places in the open build.
    Arrival {
        /// Its time, seconds.
        secs: f64,
        /// Number of searches for open builds of this machine, with this one.
        round: u64,
    },
    /// Nothing is wanted of the open build: it is lowered while it waits.
    Waiting {
        /// Its time, CPU seconds.
        cpu_secs: f64,
        /// What earlier ones took since the last arrival, CPU seconds.
        earlier_cpu_secs: f64,
    },
    /// The build has fired: its last search.
    Final {
        /// Its time, seconds; 0 = the layout stays as it is.
        secs: f64,
        /// Seed of every random choice.
        seed: u64,
    },
    /// Somebody asks what parts would do to the open build. What is found is never printed.
    Quote {
        /// When the answer is due.
        until: Instant,
    },
}

/// What is searched.
pub(super) struct SearchProblem<'a> {
    pub(super) batch: &'a NestingBatch,
    pub(super) instance: &'a NestingInstance,
    pub(super) config: &'a NestingConfig,
    /// Earlier layouts.
    pub(super) starts: &'a [Vec<LayoutPlacement>],
    pub(super) prepared: &'a PreparedMeshes,
}

/// Time of a search for an arrival, seconds.
pub(crate) fn arrival_search_secs(profile: &MachineProfile, copies: usize) -> f64 {
    profile.search.arrival_secs.max(SECS_PER_COPY * copies as f64)
}

impl SearchPolicy {
    /// The time in which a search ends, from now on, and by which it is stopped.
    pub(super) fn begin_budget(self) -> SearchBudget {
        match self {
            Self::Arrival { secs, .. } | Self::Final { secs, .. } => SearchBudget::of_secs(secs),
            Self::Waiting { .. } => SearchBudget::until_cancelled(),
            Self::Quote { until } => {
                let left = until.saturating_duration_since(Instant::now());
                SearchBudget::of_secs(QUOTE_SHARE * left.as_secs_f64())
            }
        }
    }

    /// The CPU time after which it ends, seconds.
    pub(crate) fn limit_cpu_secs(self) -> f64 {
        if let Self::Waiting { cpu_secs, .. } = self { cpu_secs } else { f64::INFINITY }
    }

    /// Whether it only uses threads that nothing else needs.
    pub(super) fn gives_way(self) -> bool {
        matches!(self, Self::Waiting { .. })
    }

    /// Gives this thread, and those that it starts, the priority of the search.
    pub(crate) fn lower_priority(self) {
        match self {
            Self::Arrival { .. } | Self::Quote { .. } => lower_thread_priority(ARRIVAL_NICENESS),
            Self::Waiting { .. } => lower_thread_priority(NIGHT_NICENESS),
            Self::Final { .. } => {}
        }
    }

    /// The configuration of the search, from that of the machine.
    pub(super) fn config(self, of_machine: &NestingConfig) -> NestingConfig {
        let config = of_machine.clone();
        match self {
            Self::Arrival { round, .. } => NestingConfig { seed: config.seed.wrapping_add(round), ..config },
            Self::Waiting { earlier_cpu_secs, .. } => {
                let further = FIRST_WAITING_SEED.wrapping_add((1e3 * earlier_cpu_secs) as u64);
                NestingConfig { seed: config.seed.wrapping_add(further), ..config }
            }
            Self::Final { seed, .. } => NestingConfig { seed, ..config },
            // Whether parts come apart is not worth its time.
            Self::Quote { .. } => {
                NestingConfig { method: NestingMethod::Nestd, interlock: InterlockRule::Allow, threads: 1, ..config }
            }
        }
    }

    /// Searches until `stop`. Returns the best layout, and a pool of layouts to go on from, if it leaves one.
    pub(super) fn search(
        self,
        problem: &SearchProblem<'_>,
        stop: &dyn StopCondition,
        listener: &mut dyn ProgressListener,
    ) -> (NestingSolution, Vec<Vec<ItemPlacement>>) {
        let SearchProblem { batch, instance, config, starts, prepared } = *problem;
        match self {
            Self::Arrival { .. } | Self::Final { .. } => {
                let start = batch.lowest_start(starts);
                (nester::nest_with_cache(instance, config, &start, prepared, stop, listener), Vec::new())
            }
            Self::Waiting { .. } => {
                let pool: Vec<_> = starts.iter().map(|placed| batch.matching_placements(placed)).collect();
                let ImprovedLayouts { best, pool } =
                    nester::improve_layouts(instance, config, &pool, prepared, stop, listener);
                (best, pool)
            }
            Self::Quote { .. } => {
                let standing = batch.lowest_start(starts);
                (nester::insert_copies(instance, config, &standing, prepared, stop, listener), Vec::new())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_search_has_a_seed_of_its_own_and_only_the_quote_another_question() {
        let machine = NestingConfig { seed: 7, threads: 4, ..NestingConfig::default() };
        let arrival = SearchPolicy::Arrival { secs: 2.0, round: 3 }.config(&machine);
        let waiting = SearchPolicy::Waiting { cpu_secs: 20.0, earlier_cpu_secs: 1.5 }.config(&machine);
        let last = SearchPolicy::Final { secs: 60.0, seed: 8 }.config(&machine);
        assert_eq!([arrival.seed, waiting.seed, last.seed], [10, 7 + (1 << 40) + 1500, 8]);
        assert!([arrival, waiting, last].iter().all(|config| NestingConfig { seed: 7, ..config.clone() } == machine));
        let quote = SearchPolicy::Quote { until: Instant::now() }.config(&machine);
        assert_eq!((quote.threads, quote.interlock, quote.seed), (1, InterlockRule::Allow, 7));
    }

    #[test]
    fn only_what_lowers_a_waiting_build_has_no_end_of_its_own_in_wall_time_and_gives_way() {
        let waiting = SearchPolicy::Waiting { cpu_secs: 20.0, earlier_cpu_secs: 0.0 };
        assert_eq!(
            (waiting.begin_budget().secs_left(), waiting.limit_cpu_secs(), waiting.gives_way()),
            (None, 20.0, true)
        );
        let secs = 0.0;
        let others = [
            SearchPolicy::Arrival { secs, round: 1 },
            SearchPolicy::Final { secs, seed: 1 },
            SearchPolicy::Quote { until: Instant::now() },
        ];
        for other in others {
            let end = (other.begin_budget().secs_left(), other.limit_cpu_secs(), other.gives_way());
            assert_eq!(end, (Some(0.0), f64::INFINITY, false), "{other:?}");
        }
    }
}
