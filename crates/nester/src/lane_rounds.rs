//! The lanes of one search on the threads of this process. With fewer threads than lanes, the lanes take turns, so the
//! result depends on the number of lanes and not on the number of threads.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, mpsc};

use super::{
    LanePlan,
    lanes::{continued_rank, lane_seed},
    lower_bound_mm,
    nesting_run::{MAX_HEIGHT_RATIO, NestingRun},
    prepared_instance::{PlacedItem, PreparedInstance, height_mm},
    tournament::{TournamentStart, run_tournament},
};

/// Evaluations after which a lane gives way to the next one where there are fewer threads than lanes.
const TURN_EVALUATIONS: u64 = 200;

/// How one round of one lane ended: its lowest layout and the evaluations that it made.
type RoundEnd = (Vec<PlacedItem>, u64);

impl NestingRun<'_> {
    /// Lowers the height limit of the best layouts until the share `until` of the budget is used up.
    pub(super) fn compress_layouts(&mut self, task: &PreparedInstance, until: f64) {
        let begun = self.stop.spent_share_at(self.evaluations);
        if self.best_items.is_empty() || !self.config.components.separation || begun >= until {
            return;
        }
        let promised_mm = self.best_items.iter().filter(|p| task.is_fixed((p.item, p.copy))).map(|p| p.bounds.max.z);
        let floor_mm = promised_mm.fold(lower_bound_mm(self.instance), f64::max).min(height_mm(&self.best_items));
        let lanes = u32::try_from(self.config.lane_count()).unwrap_or(u32::MAX);
        let starts = self.starting_layouts();
        let rounds = if lanes == 1 { 1 } else { LanePlan::USUAL_ROUNDS };
        // The first layouts are shared out: each lane prefers another one.
        let mut layouts_of: Vec<Vec<Vec<PlacedItem>>> =
            (0..lanes as usize).map(|lane| rotated(&starts, lane)).collect();
        for round in 0..rounds {
            let until = until - (until - begun) * f64::from(rounds - 1 - round) / f64::from(rounds);
            let lane_starts = layouts_of.iter().zip(0..).map(|(layouts, lane)| TournamentStart {
                prepared: task,
                layouts,
                floor_mm,
                seed: lane_seed(self.config.seed, round, lane),
            });
            let mut ends = self.run_round(&lane_starts.collect::<Vec<_>>(), until);
            // The sort is stable: of equally high layouts that of the lowest lane comes first.
            ends.sort_by(|(one, _), (other, _)| height_mm(one).total_cmp(&height_mm(other)));
            if height_mm(&ends[0].0) <= height_mm(&self.best_items) {
                self.best_items.clone_from(&ends[0].0);
            }
            layouts_of = (0..lanes).map(|lane| vec![ends[continued_rank(lane, lanes)].0.clone()]).collect();
        }
    }

    /// Runs one round of all lanes until the share `until` of the budget is used up. Returns the ends in the order of the
    /// lanes.
    fn run_round(&mut self, starts: &[TournamentStart<'_>], until: f64) -> Vec<RoundEnd> {
        let (stop, before, lanes) = (self.stop, self.evaluations, starts.len() as u64);
        // As all lanes make the same number of evaluations, each of them knows how many all have made.
        let spent = |made: u64| stop.spent_share_at(before + made * lanes) / until;
        let tell = |run: &mut Self, pieces: Vec<PlacedItem>, made: u64| {
            run.evaluations = before + made * lanes;
            run.offer_layout(pieces);
        };
        let ends: Vec<RoundEnd> = if let [start] = starts {
            vec![run_tournament(start, &spent, &mut |pieces, made| tell(self, pieces.to_vec(), made))]
        } else {
            let turns = TurnQueue::new(self.config.thread_count());
            let run_lane = |start: &TournamentStart<'_>, sender: mpsc::Sender<_>| {
                let turn = turns.wait_turn();
                let last = std::cell::Cell::new(0);
                let spent = |made: u64| {
                    if made >= last.get() + TURN_EVALUATIONS {
                        last.set(made);
                        turn.give_way();
                    }
                    spent(made)
                };
                // The receiver lives as long as the scope, so sending cannot fail.
                run_tournament(start, &spent, &mut |pieces, made| drop(sender.send((pieces.to_vec(), made))))
            };
            let run_lane = &run_lane;
            std::thread::scope(|scope| {
                let (sender, found) = mpsc::channel();
                let start_lane = |start| {
                    scope.spawn({
                        let sender = sender.clone();
                        move || run_lane(start, sender)
                    })
                };
                let handles: Vec<_> = starts.iter().map(start_lane).collect();
                drop(sender);
                found.into_iter().for_each(|(pieces, made)| tell(self, pieces, made));
                handles.into_iter().map(|lane| lane.join().expect("a lane does not panic")).collect()
            })
        };
        self.evaluations = before + ends.iter().map(|(_, made)| made).sum::<u64>();
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
        std::iter::once(&self.best_items).chain(self.first_layouts.iter().filter(is_other)).cloned().collect()
    }
}

/// The layouts in their order, from another one on.
fn rotated(layouts: &[Vec<PlacedItem>], from: usize) -> Vec<Vec<PlacedItem>> {
    let mut layouts = layouts.to_vec();
    let from = from % layouts.len();
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
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

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
