//! Many farms at once: a daemon at its reference life-cycle mostly waits.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
};

use super::{budget::Budget, row::Row};

/// Farms at once.
fn workers(budget: &Budget) -> usize {
    let cores = std::thread::available_parallelism().map_or(2, usize::from);
    budget.pick(2 * cores, 4 * cores)
}

/// Does as much as the budget allows, in the given order.
pub fn in_parallel<P: Send, R: Send>(points: Vec<P>, budget: &Budget, work: impl Fn(P) -> R + Sync) -> Vec<R> {
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

/// One point; a panic in it is something broken, and ends no other.
pub fn caught(what: &str, work: impl FnOnce() -> Row) -> Row {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let message = panic.downcast_ref::<String>().cloned();
        let message = message.or_else(|| panic.downcast_ref::<&str>().map(|m| (*m).to_owned())).unwrap_or_default();
        Row { broken: vec![format!("{what}: {message}")], ..Row::default() }
    })
}

/// The seed of a run: `NESTD_SEED` plays an earlier one again.
pub fn seed() -> u64 {
    match std::env::var("NESTD_SEED") {
        Ok(seed) => seed.parse().expect("NESTD_SEED is a number"),
        Err(_) => rand::random::<u32>().into(),
    }
}

/// 1 to `last` in an order of which every beginning is spread over the whole: a run that is cut short has seen all regions.
pub fn spread(last: u64) -> Vec<u64> {
    let bits = 64 - last.leading_zeros();
    let reversed = |n: u64| n.reverse_bits() >> (64 - bits.max(1));
    (0..1u64 << bits).map(reversed).filter(|&n| n >= 1 && n <= last).collect()
}
