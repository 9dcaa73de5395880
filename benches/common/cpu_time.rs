//! CPU time, which other work on the machine changes little.

use rustix::time::{ClockId, clock_gettime};

/// CPU seconds of this process so far, all threads together.
pub fn cpu_secs() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
