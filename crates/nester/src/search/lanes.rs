//! A search over lanes: several searches of the same instance run side by side, and exchange their layouts between
//! rounds. After each round the better half of the lanes goes on, and the other lanes start again from the layouts of
//! the better half.
//!
//! A lane's round is a pure function of the instance, the configuration and its [`LaneTask`]. So it does not matter
//! which thread, process or machine runs it, or how often: a lane that was lost is simply run again. Only the ends of a
//! whole round decide how the next one begins, so the result of a plan does not depend on the number of workers.

use serde::{Deserialize, Serialize};

use crate::{
    DescentPace, ItemPlacement, NestingConfig, NestingInstance, NestingSolution, PreparedMeshes, StopCondition,
    prepare::prepared_instance::solution_from_items, start::nesting_run::NestingRun,
};

/// How a search is divided into lanes and rounds.
///
/// ```
/// use std::sync::Arc;
/// use nester::{BuildVolume, LaneEnd, LanePlan, NestingConfig, NestingInstance, NestingItem, PreparedMeshes, SearchBudget};
///
/// let ring = Arc::new(sample_parts::ring(30.0, 20.0, 6.0));
/// let volume = BuildVolume { size_mm: glam::DVec3::new(60.0, 60.0, 200.0) };
/// let instance = NestingInstance::new(volume, 2.0, vec![NestingItem::new("ring", ring, 8)])?;
/// let (config, prepared, stop) =
///     (NestingConfig::default(), PreparedMeshes::default(), SearchBudget::until_cancelled());
///
/// let plan = LanePlan { lanes: 2, rounds: 2, evaluations: 600, seed: 1 };
/// let (mut round, mut tasks, mut ends) = (0, plan.first_tasks(&[]), Vec::new());
/// while !tasks.is_empty() {
///     // Each of them could run on another machine.
///     ends = tasks.iter().map(|task| nester::run_lane(&instance, &config, &prepared, task, &stop)).collect();
///     tasks = plan.next_tasks(round, &ends);
///     round += 1;
/// }
/// let lowest = LanePlan::best_end(&ends).expect("every lane has an end");
/// let solution = nester::finish_lanes(&instance, &config, &prepared, &lowest.placements, &stop);
/// assert!(solution.unplaced.is_empty() && solution.height_mm <= lowest.height_mm + 1e-9);
/// # Ok::<(), nester::InstanceError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LanePlan {
    /// Number of lanes, 1 or more.
    pub lanes: u32,
    /// Number of rounds, 1 or more. Between two rounds the lanes exchange their layouts.
    pub rounds: u32,
    /// Evaluations of one lane over all rounds. All lanes together make `lanes` times as many.
    pub evaluations: u64,
    /// Seed of every random choice of all lanes.
    pub seed: u64,
}

/// One round of one lane: everything that [`run_lane`] must know besides the instance and the configuration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaneTask {
    /// Number of the round, from 0.
    pub round: u32,
    /// Number of rounds of the plan.
    pub rounds: u32,
    /// Number of the lane, from 0.
    pub lane: u32,
    /// Seed of every random choice in this round of this lane; it replaces the seed of the configuration.
    pub seed: u64,
    /// Evaluations of this round.
    pub evaluations: u64,
    /// The layout to continue from. In the first round it may lack copies, or be empty: then the lane builds first
    /// layouts of its own.
    pub start: Vec<ItemPlacement>,
    /// The pace at which the descent to this layout ended.
    pub pace: DescentPace,
}

impl LaneTask {
    /// The shares of the budget of the whole lane, of which each round has an equal part.
    pub(crate) fn round_shares(&self) -> RoundShares {
        let until = f64::from(self.round + 1) / f64::from(self.rounds.max(1));
        RoundShares { begun: 0.0, until, whole: 1.0 }
    }
}

/// How a round of a lane ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaneEnd {
    /// Number of the lane.
    pub lane: u32,
    /// The lane's best layout, which is valid; in order of item and copy. It may lack copies that found no place, and it
    /// is empty if the search was cancelled before the lane had checked its start.
    pub placements: Vec<ItemPlacement>,
    /// Top of the highest placement, mm; 0 when nothing is placed.
    pub height_mm: f64,
    /// Evaluations made in this round. It exceeds the number of the task by a few, because a step is not interrupted.
    pub evaluations: u64,
    /// The pace of the descent at its end.
    pub pace: DescentPace,
}

impl LanePlan {
    /// The number of rounds unless there is a reason for another one.
    pub const USUAL_ROUNDS: u32 = 4;

    /// The tasks of the first round: every lane starts from `start`, with a seed of its own. `start` may be empty.
    pub fn first_tasks(&self, start: &[ItemPlacement]) -> Vec<LaneTask> {
        (0..self.lanes).map(|lane| self.lane_task(0, lane, start, DescentPace::default())).collect()
    }

    /// The tasks of the round after `round`, whose ends are `ends`: of all lanes, in any order. Empty after the last
    /// round, and if there are no ends.
    pub fn next_tasks(&self, round: u32, ends: &[LaneEnd]) -> Vec<LaneTask> {
        if round + 1 >= self.rounds || ends.is_empty() {
            return Vec::new();
        }
        let mut ranked: Vec<&LaneEnd> = ends.iter().collect();
        ranked.sort_by(|one, other| compare_ends(one, other));
        let task = |lane: u32| {
            // Ends may be missing.
            let end = ranked[continued_rank(lane, self.lanes).min(ranked.len() - 1)];
            self.lane_task(round + 1, lane, &end.placements, end.pace)
        };
        (0..self.lanes).map(task).collect()
    }

    /// The best of the ends: the one that places most copies, then the lowest, then the one of the lowest lane number.
    pub fn best_end(ends: &[LaneEnd]) -> Option<&LaneEnd> {
        ends.iter().min_by(|one, other| compare_ends(one, other))
    }

    fn lane_task(&self, round: u32, lane: u32, start: &[ItemPlacement], pace: DescentPace) -> LaneTask {
        let (before, after) = (self.evaluations_until(round), self.evaluations_until(round + 1));
        LaneTask {
            round,
            rounds: self.rounds,
            lane,
            seed: lane_seed(self.seed, round, lane),
            evaluations: after - before,
            start: start.to_vec(),
            pace,
        }
    }

    /// Evaluations of one lane in all rounds before `round`.
    fn evaluations_until(&self, round: u32) -> u64 {
        let part = u128::from(self.evaluations) * u128::from(round) / u128::from(self.rounds.max(1));
        u64::try_from(part).unwrap_or(u64::MAX)
    }
}

/// The seed of a round of a lane. The first round of the first lane has the seed of the plan.
pub(crate) fn lane_seed(seed: u64, round: u32, lane: u32) -> u64 {
    let of_lane = u64::from(lane).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    seed.wrapping_add(of_lane).wrapping_add(u64::from(round).wrapping_mul(0xbf58_476d_1ce4_e5b9))
}

/// The rank, from 0, of the end whose layout a lane continues with in the next round: the better half of the ends is
/// continued twice.
pub(crate) fn continued_rank(lane: u32, lanes: u32) -> usize {
    (lane % lanes.div_ceil(2)) as usize
}

/// The better end is less.
fn compare_ends(one: &LaneEnd, other: &LaneEnd) -> std::cmp::Ordering {
    let count = other.placements.len().cmp(&one.placements.len());
    count.then(one.height_mm.total_cmp(&other.height_mm)).then(one.lane.cmp(&other.lane))
}

/// The budget of a lane in one of its rounds: its evaluations, or whatever else ends the search.
struct LaneBudget<'a> {
    task: &'a LaneTask,
    stop: &'a dyn StopCondition,
}

impl StopCondition for LaneBudget<'_> {
    fn spent_share_at(&self, evaluations: u64) -> f64 {
        let of_round = evaluations as f64 / self.task.evaluations.max(1) as f64;
        let share = (f64::from(self.task.round) + of_round) / f64::from(self.task.rounds.max(1));
        // Whatever stops the lane stops it for good; a clock that still runs does not change its course.
        if self.stop.spent_share_at(evaluations) >= 1.0 { f64::INFINITY } else { share }
    }
}

/// Runs one round of a lane on the calling thread: [`LaneTask::evaluations`] evaluations from [`LaneTask::start`].
/// `stop` can end it earlier; it is asked for the evaluations of this round. Otherwise the end depends on the instance,
/// the configuration (but not its seed, threads and lanes) and the task only, not on `prepared` or the machine.
///
/// Placements of the start that are not valid are dropped. If the start lacks copies, the first round inserts them or
/// builds first layouts; later rounds leave them out. The criteria that count after the height are left to
/// [`finish_lanes`]. Lanes always run the project's own search, whatever the method of the configuration.
pub fn run_lane(
    instance: &NestingInstance,
    config: &NestingConfig,
    prepared: &PreparedMeshes,
    task: &LaneTask,
    stop: &dyn StopCondition,
) -> LaneEnd {
    let config = NestingConfig { seed: task.seed, threads: 1, lanes: 1, ..config.clone() };
    let budget = LaneBudget { task, stop };
    let mut listener = ();
    let mut run = NestingRun::new(instance, &config, prepared, &budget, &mut listener);
    let pace = run.search_lane_round(task);
    let NestingSolution { placements, height_mm, evaluations, .. } =
        solution_from_items(instance, &run.best_items, run.evaluations);
    LaneEnd { lane: task.lane, placements, height_mm, evaluations, pace }
}

/// Completes the best layout of a search over lanes: improves the criteria that count after the height, and if not all
/// copies are in, makes it keep the order of precedence. The height only grows if copies of higher precedence come in.
pub fn finish_lanes(
    instance: &NestingInstance,
    config: &NestingConfig,
    prepared: &PreparedMeshes,
    placements: &[ItemPlacement],
    stop: &dyn StopCondition,
) -> NestingSolution {
    let mut listener = ();
    let mut run = NestingRun::new(instance, config, prepared, stop, &mut listener);
    run.finish_search(placements);
    solution_from_items(instance, &run.best_items, run.evaluations)
}

/// Shares of the budget that divide a search into rounds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RoundShares {
    /// Share at which the first round begins.
    pub(crate) begun: f64,
    /// Share at which this round ends.
    pub(crate) until: f64,
    /// Share at which the last round ends.
    pub(crate) whole: f64,
}

impl RoundShares {
    /// A share of the budget as the share of all rounds, 0 to 1.
    pub(super) fn of_rounds(&self, share: f64) -> f64 {
        let begun = self.begun / self.whole;
        (share / self.whole - begun) / (1.0 - begun).max(1e-9)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use crate::{
        SearchBudget,
        tests::{
            nester_tests::{asked, assert_good, item},
            testing::{block, tetrahedron},
        },
    };

    fn end(lane: u32, copies: usize, height_mm: f64) -> LaneEnd {
        let placement =
            |copy: usize| ItemPlacement { item: lane as usize, copy: copy as u32, pose: solids::Pose::IDENTITY };
        LaneEnd {
            lane,
            placements: (0..copies).map(placement).collect(),
            height_mm,
            evaluations: 1,
            pace: DescentPace::default(),
        }
    }

    #[test]
    fn the_rounds_of_a_lane_make_exactly_the_evaluations_of_the_plan() {
        for (rounds, evaluations) in [(1, 7), (3, 1000), (7, 100_003), (4, u64::MAX)] {
            let plan = LanePlan { lanes: 1, rounds, evaluations, seed: 1 };
            let mut made = plan.first_tasks(&[])[0].evaluations;
            for round in 0..rounds {
                made += plan.next_tasks(round, &[end(0, 1, 1.0)]).iter().map(|task| task.evaluations).sum::<u64>();
            }
            assert_eq!(made, evaluations, "{rounds} rounds");
        }
    }

    #[test]
    fn more_copies_then_less_height_then_the_lower_number_is_better() {
        let ends = [end(3, 2, 10.0), end(2, 3, 12.0), end(1, 3, 11.0), end(0, 3, 11.0)];
        assert_eq!(LanePlan::best_end(&ends).map(|end| end.lane), Some(0));
        assert_eq!(LanePlan::best_end(&ends[..2]).map(|end| end.lane), Some(2));
        assert_eq!(LanePlan::best_end(&[]), None);
    }

    #[test]
    fn the_better_half_goes_on_whatever_the_order_of_the_ends() {
        let plan = LanePlan { lanes: 5, rounds: 2, evaluations: 100, seed: 1 };
        let heights = [5.0, 3.0, 9.0, 1.0, 7.0];
        let mut ends: Vec<LaneEnd> = (0..5).map(|lane| end(lane, 1, heights[lane as usize])).collect();
        let tasks = plan.next_tasks(0, &ends);
        let from: Vec<usize> = tasks.iter().map(|task| task.start[0].item).collect();
        assert_eq!(from, [3, 1, 0, 3, 1]);
        ends.reverse();
        assert_eq!(plan.next_tasks(0, &ends), tasks);
        assert!(plan.next_tasks(1, &ends).is_empty() && plan.next_tasks(0, &[]).is_empty());
    }

    /// Three shapes, of which the volume holds `height_mm` millimetres.
    fn mixed(height_mm: f64) -> NestingInstance {
        let corners = [DVec3::ZERO, DVec3::X * 25.0, DVec3::Y * 20.0, DVec3::Z * 15.0];
        let meshes = [block(DVec3::new(12.0, 30.0, 6.0)), tetrahedron(corners), block(DVec3::new(9.0, 9.0, 14.0))];
        let items = meshes.map(|mesh| item(mesh, 4, crate::OrientationRule::Free));
        asked(DVec3::new(45.0, 45.0, height_mm), 1.5, items.into())
    }

    #[test]
    fn a_lost_lane_that_is_run_again_elsewhere_has_the_same_end() {
        let instance = mixed(90.0);
        let plan = LanePlan { lanes: 2, rounds: 2, evaluations: 16_000, seed: 3 };
        let (config, never) = (NestingConfig::default(), SearchBudget::until_cancelled());
        let here = PreparedMeshes::default();
        let run = |task: &LaneTask| run_lane(&instance, &config, &here, task, &never);
        let firsts = plan.first_tasks(&[]);
        let mut ends: Vec<LaneEnd> = firsts.iter().map(run).collect();
        assert_ne!(ends[0].placements, ends[1].placements, "lanes differ");
        let seconds = plan.next_tasks(0, &ends);
        ends.extend(seconds.iter().map(run));
        let elsewhere = NestingConfig { seed: 77, threads: 2, lanes: 3, ..NestingConfig::default() };
        for (task, end) in firsts.iter().chain(&seconds).zip(&ends) {
            let again = Arc::new(instance.clone());
            assert_eq!(&run_lane(&again, &elsewhere, &PreparedMeshes::default(), task, &never), end);
        }
        let before_mm = LanePlan::best_end(&ends[..2]).expect("two ends").height_mm;
        let best = LanePlan::best_end(&ends[2..]).expect("two ends");
        assert!(best.height_mm <= before_mm, "a round never loses height");
        assert!((8000..8400).contains(&ends[2].evaluations), "{}", ends[2].evaluations);
        let solution = finish_lanes(&instance, &config, &here, &best.placements, &never);
        assert_good(&instance, &solution);
        assert!(solution.unplaced.is_empty() && solution.height_mm <= best.height_mm + 1e-9);
    }

    #[test]
    fn a_lane_of_too_many_copies_keeps_those_that_are_in_and_the_end_keeps_the_order_of_precedence() {
        let instance = mixed(22.0);
        let plan = LanePlan { lanes: 1, rounds: 2, evaluations: 2000, seed: 3 };
        let (config, never) = (NestingConfig::default(), SearchBudget::until_cancelled());
        let prepared = PreparedMeshes::default();
        let run = |task: &LaneTask| run_lane(&instance, &config, &prepared, task, &never);
        let first = run(&plan.first_tasks(&[])[0]);
        let second = run(&plan.next_tasks(0, std::slice::from_ref(&first))[0]);
        let copies = |end: &LaneEnd| end.placements.iter().map(|p| (p.item, p.copy)).collect::<Vec<_>>();
        assert!(first.placements.len() < 12 && !first.placements.is_empty(), "{}", first.placements.len());
        assert_eq!(copies(&first), copies(&second));
        let solution = finish_lanes(&instance, &config, &prepared, &second.placements, &never);
        assert_good(&instance, &solution);
    }

    #[test]
    fn a_cancelled_lane_ends_at_once() {
        let cancelled = SearchBudget::until_cancelled();
        cancelled.cancel();
        let plan = LanePlan { lanes: 1, rounds: 1, evaluations: u64::MAX, seed: 3 };
        let (config, prepared) = (NestingConfig::default(), PreparedMeshes::default());
        let end = run_lane(&mixed(90.0), &config, &prepared, &plan.first_tasks(&[])[0], &cancelled);
        assert!(end.evaluations < 1000, "{}", end.evaluations);
    }
}
