//! The budget of a search and what is said while it runs.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    thread::JoinHandle,
    time::{Duration, Instant},
};

use crate::nest::{Course, Listener, Solution, Stop};

/// Wall seconds, or evaluations when they are counted.
#[derive(Debug, Clone)]
pub struct Budget {
    began: Instant,
    limit_secs: f64,
    evaluations: Option<u64>,
}

impl Budget {
    /// Starts now.
    pub fn starting_now(limit_secs: f64, evaluations: Option<u64>) -> Self {
        Self { began: Instant::now(), limit_secs, evaluations }
    }

    fn left(&self) -> String {
        match self.evaluations {
            Some(_) => String::new(),
            None => format!(", {:.0} s left", (self.limit_secs - self.began.elapsed().as_secs_f64()).max(0.0)),
        }
    }
}

impl Stop for Budget {
    fn spent(&self, evaluations: u64) -> f64 {
        match self.evaluations {
            Some(limit) => evaluations as f64 / limit as f64,
            None => self.began.elapsed().as_secs_f64() / self.limit_secs,
        }
    }
}

/// Collects the curve; on a terminal tells the best height and the time left twice a second.
#[derive(Debug)]
pub struct Progress {
    budget: Budget,
    cpu_before_secs: f64,
    /// Added to heights: they are told in the machine's frame.
    floor_mm: f64,
    curve: Vec<(f64, f64)>,
    /// Bits of the best height, 0 before there is one; `u64::MAX` = stop telling.
    shown: Arc<AtomicU64>,
    teller: Option<JoinHandle<()>>,
}

const NOTHING: u64 = 0;
const ENOUGH: u64 = u64::MAX;

impl Progress {
    /// Begins to tell, if `on_terminal`.
    pub fn new(on_terminal: bool, budget: Budget, floor_mm: f64) -> Self {
        let shown = Arc::new(AtomicU64::new(NOTHING));
        let (seen, clock) = (shown.clone(), budget.clone());
        let teller = on_terminal.then(|| {
            std::thread::spawn(move || {
                loop {
                    match seen.load(Ordering::Relaxed) {
                        ENOUGH => break,
                        NOTHING => eprint!("\rpreparing{}   ", clock.left()),
                        bits => eprint!("\rbest height {:.2} mm{}   ", f64::from_bits(bits), clock.left()),
                    }
                    std::thread::park_timeout(Duration::from_millis(500));
                }
                eprint!("\r{:60}\r", "");
            })
        });
        Self { budget, cpu_before_secs: cpu_secs(), floor_mm, curve: Vec::new(), shown, teller }
    }

    /// Stops telling; how the search went.
    pub fn finish(mut self, seed: u64) -> Course {
        self.shown.store(ENOUGH, Ordering::Relaxed);
        if let Some(teller) = self.teller.take() {
            teller.thread().unpark();
            // A teller that panicked has nothing more to say; the search is done all the same.
            let _ = teller.join();
        }
        Course {
            clearance_proved_mm: None,
            separable: None,
            seed,
            cpu_secs: cpu_secs() - self.cpu_before_secs,
            wall_secs: self.budget.began.elapsed().as_secs_f64(),
            curve: self.curve,
        }
    }
}

impl Listener for Progress {
    fn improved(&mut self, solution: &Solution, _evaluations: u64) {
        let height_mm = solution.height_mm + self.floor_mm;
        self.shown.store(height_mm.to_bits(), Ordering::Relaxed);
        self.curve.push((self.budget.began.elapsed().as_secs_f64(), height_mm));
    }
}

/// CPU seconds of this process so far.
fn cpu_secs() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
