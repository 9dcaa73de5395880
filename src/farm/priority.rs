//! Improving an open build while parts are waited for gives way to everything else on the machine.

use rustix::{
    process::{Pid, setpriority_process},
    thread::gettid,
};
use tracing::debug;

/// The niceness of what is not urgent.
const GIVES_WAY: i32 = 15;

/// Lowers the priority of this thread and of the threads that it will start. On Linux, a niceness is a thread's own.
pub fn give_way() {
    let this: Pid = gettid();
    if let Err(error) = setpriority_process(Some(this), GIVES_WAY) {
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
            give_way();
            (nice(), std::thread::spawn(nice).join().expect("ends"))
        })
        .join()
        .expect("ends");
        assert_eq!((own, child), (GIVES_WAY, GIVES_WAY));
        assert_eq!(nice(), before);
    }
}
