//! Runs many farms at once, because a daemon in its reference life-cycle mostly waits.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
};

use super::{budget::SectionBudget, section_result::SectionResult};

/// The number of farms at once.
fn workers(budget: &SectionBudget) -> usize {
    let cores = std::thread::available_parallelism().map_or(2, usize::from);
    budget.pick(2 * cores, 4 * cores)
}

/// Works on as many points as the budget allows, in the given order.
pub fn in_parallel<P: Send, R: Send>(points: Vec<P>, budget: &SectionBudget, work: impl Fn(P) -> R + Sync) -> Vec<R> {
    let points: Vec<Mutex<Option<P>>> = points.into_iter().map(|point| Mutex::new(Some(point))).collect();
    let (next, results) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..workers(budget) {
            scope.spawn(|| {
                while !budget.is_spent() {
                    let Some(point) = points.get(next.fetch_add(1, Ordering::Relaxed)) else { return };
                    let Some(point) = point.lock().unwrap().take() else { return };
                    let result = work(point);
                    results.lock().unwrap().push(result);
                }
            });
        }
    });
    results.into_inner().unwrap()
}

/// Works on one point; a panic counts as a violation and does not stop the others.
pub fn catch_panic(what: &str, work: impl FnOnce() -> SectionResult) -> SectionResult {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let message = panic.downcast_ref::<String>().cloned();
        let message = message.or_else(|| panic.downcast_ref::<&str>().map(|m| (*m).to_owned())).unwrap_or_default();
        SectionResult { broken: vec![format!("{what}: {message}")], ..SectionResult::default() }
    })
}

/// The seed of a run: `NESTD_SEED` repeats an earlier run.
pub fn seed() -> u64 {
    match std::env::var("NESTD_SEED") {
        Ok(seed) => seed.parse().expect("NESTD_SEED is a number"),
        Err(_) => rand::random::<u32>().into(),
    }
}

/// The numbers 1 to `last`, ordered so that every prefix is spread over the whole range: a run that is cut short has
/// tried all regions.
pub fn spread_order(last: u64) -> Vec<u64> {
    let bits = 64 - last.leading_zeros();
    let reversed = |n: u64| n.reverse_bits() >> (64 - bits.max(1));
    (0..1u64 << bits).map(reversed).filter(|&n| n >= 1 && n <= last).collect()
}
