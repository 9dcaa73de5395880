//! The search for an open build runs at low priority, since nothing waits for it.

use rustix::{
    process::{Pid, setpriority_process},
    thread::gettid,
};
use tracing::debug;

/// Niceness of work that is not urgent.
const LOW_PRIORITY_NICENESS: i32 = 15;

/// Lowers the priority of this thread and of the threads that it will start. On Linux, each thread has its own
/// niceness.
pub fn lower_thread_priority() {
    let this: Pid = gettid();
    if let Err(error) = setpriority_process(Some(this), LOW_PRIORITY_NICENESS) {
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
            lower_thread_priority();
            (nice(), std::thread::spawn(nice).join().expect("ends"))
        })
        .join()
        .expect("ends");
        assert_eq!((own, child), (LOW_PRIORITY_NICENESS, LOW_PRIORITY_NICENESS));
        assert_eq!(nice(), before);
    }
}
