//! The lanes of one search on the threads of this process. With fewer threads than lanes, the lanes take turns, so the
//! result depends on the number of lanes and not on the number of threads.

use std::sync::{
    Condvar, Mutex, MutexGuard, PoisonError,
    atomic::{AtomicU64, Ordering},
    mpsc,
};

use super::{
    compression::DescentPace,
    tournament::{DescentEnd, DescentStart, run_descent, run_tournament},
};
use crate::{
    prepare::prepared_instance::{PlacedItem, PreparedInstance, height_mm},
    start::nesting_run::{MAX_HEIGHT_RATIO, NestingRun},
};

/// Rounds of a search in several lanes. Between two of them the lanes exchange their layouts.
const ROUNDS: u32 = 4;
/// Evaluations after which a lane gives way to the next one where there are fewer threads than lanes.
const TURN_EVALUATIONS: u64 = 200;

/// Shares of the budget that divide a search into rounds.
#[derive(Debug, Clone, Copy)]
struct RoundShares {
    /// Share at which the first round begins.
    begun: f64,
    /// Share at which this round ends.
    until: f64,
    /// Share at which the last round ends.
    whole: f64,
}

impl RoundShares {
    /// A share of the budget as the share of all rounds, 0 to 1.
    fn of_rounds(&self, share: f64) -> f64 {
        let begun = self.begun / self.whole;
        (share / self.whole - begun) / (1.0 - begun).max(1e-9)
    }
}

/// The seed of a round of a lane. The first round of the first lane has the seed of the search.
pub(super) fn lane_seed(seed: u64, round: u32, lane: u32) -> u64 {
    let of_lane = u64::from(lane).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    seed.wrapping_add(of_lane).wrapping_add(u64::from(round).wrapping_mul(0xbf58_476d_1ce4_e5b9))
}

/// The rank, from 0, of the end whose layout a lane continues with in the next round: the better half of the ends is
/// continued twice.
fn continued_rank(lane: u32, lanes: u32) -> usize {
    (lane % lanes.div_ceil(2)) as usize
}

impl NestingRun<'_> {
    /// Lowers the height limit of the best layouts in rounds of lanes, until the share `until` of the budget is used up.
    pub(super) fn compress_layouts(&mut self, task: &PreparedInstance, until: f64) {
        let begun = self.stop.spent_share_at(self.evaluations);
        if !self.can_compress() || begun >= until {
            return;
        }
        let (floor_mm, starts) = (self.floor_mm(task), self.starting_layouts());
        let least_runs = 1 + usize::from(self.around_dominating.is_some());
        let lanes = u32::try_from(self.config.lane_count()).unwrap_or(u32::MAX);
        let rounds = if lanes == 1 { 1 } else { ROUNDS };
        // The first layouts are shared out: each lane prefers another one.
        let first = |lane: u32| (rotated(&starts, lane), DescentPace::default());
        let mut goes_on: Vec<(Vec<Vec<PlacedItem>>, DescentPace)> = (0..lanes).map(first).collect();
        for round in 0..rounds {
            let starts = goes_on.iter().zip(0..).map(|((layouts, pace), lane)| {
                let seed = lane_seed(self.config.seed, round, lane);
                DescentStart { prepared: task, layouts, floor_mm, seed, pace: *pace, least_runs }
            });
            let end = until - (until - begun) * f64::from(rounds - 1 - round) / f64::from(rounds);
            let shares = RoundShares { begun, until: end, whole: until };
            let mut ends = self.run_round(&starts.collect::<Vec<_>>(), shares, rounds);
            // The sort is stable: of equally high layouts that of the lowest lane comes first.
            ends.sort_by(|one, other| height_mm(&one.items).total_cmp(&height_mm(&other.items)));
            self.other_ends = ends.iter().flat_map(|end| end.others.iter().chain([&end.items])).cloned().collect();
            let continued = |lane: u32| &ends[continued_rank(lane, lanes)];
            goes_on = (0..lanes).map(continued).map(|end| (vec![end.items.clone()], end.pace)).collect();
            if self.is_lowest(task) {
                break;
            }
        }
    }

    fn can_compress(&self) -> bool {
        !self.best_items.is_empty() && self.config.components.separation
    }

    /// Runs one round of all lanes. Returns the ends in the order of the lanes; the best of them is the best layout if it
    /// is not higher than the one before. If there is one round only, a lane is a tournament of its own. The round ends
    /// when a lane has found that no lower layout exists.
    fn run_round(&mut self, starts: &[DescentStart<'_>], shares: RoundShares, rounds: u32) -> Vec<DescentEnd> {
        let (stop, before, lanes) = (self.stop, self.evaluations, starts.len() as u64);
        // Evaluations after which a lane had the lowest layout that exists.
        let reached = AtomicU64::new(u64::MAX);
        // As all lanes make the same number of evaluations, each of them knows how many all have made.
        let spent = |made: u64| match made >= reached.load(Ordering::Relaxed) {
            true => f64::INFINITY,
            false => shares.of_rounds(stop.spent_share_at(before + made * lanes)),
        };
        let tell = |run: &mut Self, pieces: Vec<PlacedItem>, made: u64| {
            run.evaluations = before + made * lanes;
            run.offer_layout(pieces);
        };
        let descend =
            |start: &DescentStart<'_>, spent: &dyn Fn(u64) -> f64, found: &mut dyn FnMut(&[PlacedItem], u64)| {
                let until = if shares.until < shares.whole { shares.of_rounds(shares.until) } else { 1.0 };
                let end = match rounds {
                    1 => run_tournament(start, spent, found),
                    _ => run_descent(start, until, spent, found),
                };
                if start.is_lowest(&end.items) {
                    reached.fetch_min(end.made, Ordering::Relaxed);
                }
                end
            };
        let ends: Vec<DescentEnd> = if let [start] = starts {
            vec![descend(start, &spent, &mut |pieces, made| tell(self, pieces.to_vec(), made))]
        } else {
            let turns = TurnQueue::new(self.config.thread_count());
            let run_lane = |start: &DescentStart<'_>, sender: mpsc::Sender<_>| {
                let (turn, last) = (turns.wait_turn(), std::cell::Cell::new(0));
                let spent = |made: u64| {
                    if made >= last.get() + TURN_EVALUATIONS {
                        last.set(made);
                        turn.give_way();
                    }
                    spent(made)
                };
                // The receiver lives as long as the scope, so sending cannot fail.
                descend(start, &spent, &mut |pieces, made| drop(sender.send((pieces.to_vec(), made))))
            };
            let run_lane = &run_lane;
            std::thread::scope(|scope| {
                let (sender, found) = mpsc::channel();
                let start_lane = |start| {
                    let sender = sender.clone();
                    scope.spawn(move || run_lane(start, sender))
                };
                let handles: Vec<_> = starts.iter().map(start_lane).collect();
                drop(sender);
                found.into_iter().for_each(|(pieces, made)| tell(self, pieces, made));
                handles.into_iter().map(|lane| lane.join().expect("a lane does not panic")).collect()
            })
        };
        // The lanes are heard in any order. What others have made after the first one that could end is left to chance.
        let lowest = ends.iter().zip(starts).filter(|(end, start)| start.is_lowest(&end.items)).map(|(end, _)| end);
        if let Some(first) = lowest.min_by_key(|end| end.made) {
            self.evaluations = before + first.made * lanes;
            self.best_items.clone_from(&first.items);
            return ends;
        }
        self.evaluations = before + ends.iter().map(|end| end.made).sum::<u64>();
        // Of equally low layouts that of the lowest lane counts.
        let best = ends.iter().min_by(|one, other| height_mm(&one.items).total_cmp(&height_mm(&other.items)));
        if let Some(best) = best.filter(|best| height_mm(&best.items) <= height_mm(&self.best_items)) {
            self.best_items.clone_from(&best.items);
        }
        ends
    }

    /// Returns the starting layouts of the search: the best layout, and other layouts with the same number of copies
    /// that are not much higher.
    fn starting_layouts(&self) -> Vec<Vec<PlacedItem>> {
        let height = height_mm(&self.best_items);
        let is_other = |other: &&Vec<PlacedItem>| {
            let there = height_mm(other);
            other.len() == self.best_items.len() && there != height && there <= MAX_HEIGHT_RATIO * height
        };
        let around = self
            .around_dominating
            .iter()
            .filter(|around| around.len() == self.best_items.len() && height_mm(around) != height);
        let first = std::iter::once(&self.best_items).chain(around);
        first.chain(self.first_layouts.iter().filter(is_other)).cloned().collect()
    }
}

/// The layouts in their order, from the one on that a lane prefers.
fn rotated(layouts: &[Vec<PlacedItem>], lane: u32) -> Vec<Vec<PlacedItem>> {
    let mut layouts = layouts.to_vec();
    let from = lane as usize % layouts.len();
    layouts.rotate_left(from);
    layouts
}

/// Lets a number of lanes run at a time, in the order in which they asked.
struct TurnQueue {
    state: Mutex<QueueState>,
    moved: Condvar,
}

/// The state of a queue: a lane may run while its number is less than `called`.
struct QueueState {
    next: u64,
    called: u64,
}

/// The right of a lane to run, until it is dropped.
struct LaneTurn<'a>(&'a TurnQueue);

impl TurnQueue {
    /// A queue for this number of lanes at a time.
    fn new(at_once: usize) -> Self {
        Self { state: Mutex::new(QueueState { next: 0, called: at_once as u64 }), moved: Condvar::new() }
    }

    fn locked(&self) -> MutexGuard<'_, QueueState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until the calling lane may run.
    fn wait_turn(&self) -> LaneTurn<'_> {
        self.enter(self.locked());
        LaneTurn(self)
    }

    fn enter(&self, mut state: MutexGuard<'_, QueueState>) {
        let number = state.next;
        state.next += 1;
        let still = |state: &mut QueueState| number >= state.called;
        drop(self.moved.wait_while(state, still).unwrap_or_else(PoisonError::into_inner));
    }

    fn leave(&self) -> MutexGuard<'_, QueueState> {
        let mut state = self.locked();
        state.called += 1;
        self.moved.notify_all();
        state
    }
}

impl LaneTurn<'_> {
    /// Lets the lanes that wait go first.
    fn give_way(&self) {
        let state = self.0.leave();
        self.0.enter(state);
    }
}

impl Drop for LaneTurn<'_> {
    fn drop(&mut self) {
        drop(self.0.leave());
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::*;

    #[test]
    fn the_better_half_of_the_lanes_goes_on_twice() {
        let from = |lanes: u32| (0..lanes).map(|lane| continued_rank(lane, lanes)).collect::<Vec<_>>();
        assert_eq!((from(1), from(4), from(5)), (vec![0], vec![0, 1, 0, 1], vec![0, 1, 2, 0, 1]));
    }

    #[test]
    fn no_more_lanes_run_at_once_than_may() {
        for at_once in [1, 2] {
            let (queue, running) = (TurnQueue::new(at_once), AtomicUsize::new(0));
            let run_lane = || {
                let turn = queue.wait_turn();
                for _ in 0..200 {
                    assert!(running.fetch_add(1, Ordering::SeqCst) < at_once);
                    std::thread::yield_now();
                    running.fetch_sub(1, Ordering::SeqCst);
                    turn.give_way();
                }
            };
            std::thread::scope(|scope| (0..5).for_each(|_| drop(scope.spawn(run_lane))));
        }
    }

    #[test]
    fn lanes_that_wait_go_first() {
        let (queue, order) = (TurnQueue::new(1), Mutex::new(Vec::new()));
        let run_lane = |lane: usize| {
            let turn = queue.wait_turn();
            for _ in 0..20 {
                order.lock().expect("is sound").push(lane);
                turn.give_way();
            }
        };
        let run_lane = &run_lane;
        std::thread::scope(|scope| {
            let turn = queue.wait_turn();
            (0..4).for_each(|lane| drop(scope.spawn(move || run_lane(lane))));
            while queue.locked().next < 5 {
                std::thread::yield_now();
            }
            drop(turn);
        });
        for turns in order.into_inner().expect("is sound").chunks(4) {
            let mut lanes = turns.to_vec();
            lanes.sort_unstable();
            assert_eq!(lanes, [0, 1, 2, 3]);
        }
    }
}
