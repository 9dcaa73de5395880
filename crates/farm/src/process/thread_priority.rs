//! Searches for an open build run at low priority, since nothing waits for them.

use rustix::{
    process::{Pid, setpriority_process},
    thread::gettid,
};
use tracing::debug;

/// Niceness of the search for an arrival.
pub const ARRIVAL_NICENESS: i32 = 15;
/// Niceness of what only uses time that nobody needs: the lowest priority.
pub const NIGHT_NICENESS: i32 = 19;

/// Lowers the priority of this thread and of the threads that it will start. On Linux, each thread has its own
/// niceness.
pub fn lower_thread_priority(niceness: i32) {
    let this: Pid = gettid();
    if let Err(error) = setpriority_process(Some(this), niceness) {
        debug!("The search for an open build runs at full priority: {error}.");
    }
}

#[cfg(test)]
mod tests {
    use rustix::process::getpriority_process;

    use super::*;

    #[test]
    fn only_the_thread_that_gives_way_and_its_own_threads_do() {
        let before = getpriority_process(Some(gettid())).expect("is known");
        let nice = || getpriority_process(Some(gettid())).expect("is known");
        let (own, child) = std::thread::spawn(move || {
            lower_thread_priority(ARRIVAL_NICENESS);
            (nice(), std::thread::spawn(nice).join().expect("ends"))
        })
        .join()
        .expect("ends");
        assert_eq!((own, child), (ARRIVAL_NICENESS, ARRIVAL_NICENESS));
        assert_eq!(nice(), before);
    }
}
