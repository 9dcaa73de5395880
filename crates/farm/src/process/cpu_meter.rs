//! The CPU time of one search, in whatever threads it runs. Other searches of the same process do not count.

use std::{
    cell::Cell,
    sync::atomic::{AtomicU64, Ordering},
};

use nester::{SearchBudget, StopCondition};
use rustix::time::{ClockId, clock_gettime};

/// The number of the next meter.
static NEXT_NUMBER: AtomicU64 = AtomicU64::new(1);

thread_local! {
    /// The meter that was last asked in this thread, and the CPU time of the thread then, ns.
    static LAST_ASKED: Cell<(u64, u64)> = const { Cell::new((0, 0)) };
}

/// A search's own budget, which also counts and may limit its CPU time: that of the thread that makes the meter, and of each
/// thread that asks whether to stop, from its first question to its last.
pub(crate) struct CpuMeter<'a> {
    number: u64,
    budget: &'a SearchBudget,
    limit_secs: f64,
    spent_ns: AtomicU64,
}

impl<'a> CpuMeter<'a> {
    /// Counts from now on; the search ends with its `budget`, or after `limit_secs` CPU seconds.
    pub(crate) fn begin(budget: &'a SearchBudget, limit_secs: f64) -> Self {
        let number = NEXT_NUMBER.fetch_add(1, Ordering::Relaxed);
        LAST_ASKED.set((number, thread_cpu_ns()));
        Self { number, budget, limit_secs, spent_ns: AtomicU64::new(0) }
    }

    /// CPU seconds of all its threads up to the last question of each.
    pub(crate) fn spent_secs(&self) -> f64 {
        let now = thread_cpu_ns();
        let (number, before) = LAST_ASKED.replace((self.number, now));
        let since = if number == self.number { now.saturating_sub(before) } else { 0 };
        (self.spent_ns.fetch_add(since, Ordering::Relaxed) + since) as f64 * 1e-9
    }
}

impl StopCondition for CpuMeter<'_> {
    fn spent_share_at(&self, evaluations: u64) -> f64 {
        self.budget.spent_share_at(evaluations).max(self.spent_secs() / self.limit_secs)
    }
}

/// CPU time of this thread so far, ns.
fn thread_cpu_ns() -> u64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    /// Uses this thread's CPU for so long, and asks the meter meanwhile.
    fn work(secs: f64, meter: Option<&CpuMeter<'_>>) {
        let until = thread_cpu_ns() + (secs * 1e9) as u64;
        while thread_cpu_ns() < until {
            let _ = meter.map(|meter| meter.spent_share_at(0));
        }
    }

    #[test]
    fn all_threads_of_a_search_count_and_those_of_others_do_not() {
        let budget = SearchBudget::until_cancelled();
        let meter = CpuMeter::begin(&budget, 10.0);
        thread::scope(|scope| {
            scope.spawn(|| work(0.3, None));
            for _ in 0..2 {
                scope.spawn(|| work(0.1, Some(&meter)));
            }
            work(0.1, None);
        });
        let spent_secs = meter.spent_secs();
        assert!((0.29..0.45).contains(&spent_secs), "{spent_secs}");
        assert!((0.029..0.045).contains(&meter.spent_share_at(0)));
        budget.cancel();
        assert_eq!(meter.spent_share_at(0), f64::INFINITY);
    }
}
