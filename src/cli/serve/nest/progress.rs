//! What is said while a search runs.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering},
    },
    thread::JoinHandle,
    time::Duration,
};

use nester::{HeightCurve, NestingSolution, ProgressListener, SearchBudget, SearchSummary};

/// Longest bar, columns.
const MAX_BAR_COLUMNS: usize = 30;
/// Columns of a terminal whose size is unknown.
const DEFAULT_COLUMNS: usize = 80;

/// Seconds without a gain that are shown.
const SHOWN_IDLE_SECS: f64 = 10.0;

/// What a search is measured by.
#[derive(Debug, Clone, Copy)]
pub struct SearchTarget {
    /// Free space below the layout, mm: shown heights are measured from the floor of the machine.
    pub floor_mm: f64,
    /// The lower bound of the layout's height, mm.
    pub bound_mm: f64,
    /// Copies to place.
    pub copies: usize,
}

impl SearchTarget {
    /// The lower bound of the height above the floor of the machine, mm.
    pub fn machine_bound_mm(&self) -> f64 {
        self.floor_mm + self.bound_mm
    }
}

/// The best layout of a running search.
#[derive(Debug, Default)]
struct BestSoFar {
    /// Its height, mm, as the bits of an `f64`; 0 = none yet.
    height: AtomicU64,
    copies: AtomicUsize,
    is_over: AtomicBool,
}

impl BestSoFar {
    /// `84.20 mm high, bound 47.50, gap 43.6 %`, with the copies where some have no place yet.
    fn in_words(&self, target: &SearchTarget) -> String {
        let height_mm = f64::from_bits(self.height.load(Ordering::Relaxed));
        if height_mm == 0.0 {
            return "preparing".to_owned();
        }
        let copies = match self.copies.load(Ordering::Relaxed) {
            copies if copies < target.copies => format!(", {copies} of {} copies", target.copies),
            _ => String::new(),
        };
        format!("{height_mm:.2} mm high, {}{copies}", bound_and_gap(height_mm, target.machine_bound_mm()))
    }
}

/// `bound 47.50, gap 43.6 %`: the lower bound, and the share of the height that is above it.
pub fn bound_and_gap(height_mm: f64, bound_mm: f64) -> String {
    format!("bound {bound_mm:.2}, gap {:.1} %", 100.0 * (1.0 - bound_mm / height_mm).max(0.0))
}

/// Collects the curve of heights. On a terminal, shows a bar with the best height, the lower bound and the remaining
/// budget twice a second.
#[derive(Debug)]
pub struct SearchProgress {
    budget: SearchBudget,
    cpu_before_secs: f64,
    target: SearchTarget,
    curve: HeightCurve,
    best: Arc<BestSoFar>,
    printer_thread: Option<JoinHandle<()>>,
}

impl SearchProgress {
    /// Starts to show progress if `on_terminal`.
    pub fn new(on_terminal: bool, budget: SearchBudget, target: SearchTarget) -> Self {
        let best = Arc::new(BestSoFar::default());
        let (seen, clock) = (best.clone(), budget.clone());
        let printer = on_terminal.then(|| {
            std::thread::spawn(move || {
                while !seen.is_over.load(Ordering::Relaxed) {
                    let text = seen.in_words(&target) + &idle(clock.idle_secs()) + &left(&clock);
                    eprint!("\r{}\x1b[K", progress_line(clock.spent_share(), &text, terminal_columns()));
                    std::thread::park_timeout(Duration::from_millis(500));
                }
                eprint!("\r\x1b[K");
            })
        });
        Self {
            budget,
            cpu_before_secs: process_cpu_secs(),
            target,
            curve: HeightCurve::default(),
            best,
            printer_thread: printer,
        }
    }

    /// Stops the progress bar; returns the course of the search that has found `solution`.
    pub fn finish(mut self, seed: u64, solution: &NestingSolution) -> SearchSummary {
        let end = self.budget.why_ended(solution.is_lowest(self.target.bound_mm));
        self.best.is_over.store(true, Ordering::Relaxed);
        if let Some(printer) = self.printer_thread.take() {
            printer.thread().unpark();
            // A panic of the printer thread is ignored: the search itself is complete.
            let _ = printer.join();
        }
        SearchSummary {
            seed,
            cpu_secs: process_cpu_secs() - self.cpu_before_secs,
            wall_secs: self.budget.elapsed_secs(),
            curve: self
                .curve
                .points
                .iter()
                .map(|(secs, height_mm)| (*secs, height_mm + self.target.floor_mm))
                .collect(),
            ended: end.in_words(),
            ..SearchSummary::default()
        }
    }
}

impl ProgressListener for SearchProgress {
    fn on_improved(&mut self, solution: &NestingSolution, _evaluations: u64) {
        if self.curve.add(solution, self.budget.elapsed_secs()) {
            self.budget.record_gain();
        }
        self.best.copies.store(solution.placements.len(), Ordering::Relaxed);
        self.best.height.store((solution.height_mm + self.target.floor_mm).to_bits(), Ordering::Relaxed);
    }
}

/// Words on a long time without a gain.
fn idle(secs: f64) -> String {
    if secs < SHOWN_IDLE_SECS { String::new() } else { format!(", nothing gained for {secs:.0} s") }
}

/// What is left of a budget: seconds, or how much of it is done where evaluations are counted; nothing without a limit.
fn left(budget: &SearchBudget) -> String {
    match budget.secs_left() {
        Some(secs) => format!(", {secs:.0} s left"),
        None if budget.spent_share() > 0.0 => format!(", {:.0} % done", 100.0 * budget.spent_share()),
        None => String::new(),
    }
}

/// `[#########.....] 84.20 mm high, bound 47.50, gap 43.6 %, 12 s left`, no longer than the terminal is wide. No bar
/// before anything is spent, or where it has no room.
fn progress_line(share: f64, text: &str, columns: usize) -> String {
    // The last column stays free, so that no terminal wraps the line.
    let bar = columns.saturating_sub(text.len() + 4).min(MAX_BAR_COLUMNS);
    let full = (share * bar as f64).round() as usize;
    let bar = match bar {
        5.. if share > 0.0 => format!("[{}{}] ", "#".repeat(full), ".".repeat(bar - full)),
        _ => String::new(),
    };
    let text = bar + text;
    text.chars().take(columns.saturating_sub(1)).collect()
}

/// Columns of the terminal that shows the progress.
fn terminal_columns() -> usize {
    match rustix::termios::tcgetwinsize(std::io::stderr()) {
        Ok(size) if size.ws_col > 0 => size.ws_col.into(),
        _ => DEFAULT_COLUMNS,
    }
}

/// CPU seconds of this process so far.
fn process_cpu_secs() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use nester::{ItemPlacement, StopCondition};
    use solids::Pose;

    use super::*;

    #[test]
    fn the_bar_grows_the_height_falls_and_the_line_fits_the_terminal() {
        assert_eq!(progress_line(0.01, "preparing, 30 s left", 40), "[................] preparing, 30 s left");
        let late = progress_line(0.5, "84.20 mm high, 15 s left", 80);
        assert_eq!(late, "[###############...............] 84.20 mm high, 15 s left");
        assert_eq!(progress_line(1.0, "84.20 mm high, 0 s left", 30), "84.20 mm high, 0 s left");
        assert_eq!(progress_line(0.0, "84.20 mm high", 80), "84.20 mm high", "a search without a limit");
        for columns in 0..100 {
            assert!(progress_line(0.3, "900.00 mm high, 3 s left", columns).len() <= columns.saturating_sub(1));
        }
    }

    #[test]
    fn counted_evaluations_are_a_share_of_the_bar() {
        let budget = SearchBudget::of_evaluations(200);
        assert_eq!(left(&budget), "");
        budget.spent_share_at(50);
        assert_eq!((budget.spent_share(), left(&budget)), (0.25, ", 25 % done".to_owned()));
        assert_eq!(left(&SearchBudget::of_secs(0.0)), ", 0 s left");
    }

    #[test]
    fn height_bound_and_gap_are_told_above_the_floor_and_copies_that_lack_too() {
        let target = SearchTarget { floor_mm: 5.0, bound_mm: 45.0, copies: 2 };
        let mut progress = SearchProgress::new(false, SearchBudget::of_secs(9.0), target);
        assert_eq!(progress.best.in_words(&target), "preparing");
        let placement = |copy| ItemPlacement { item: 0, copy, pose: Pose::IDENTITY };
        let mut found =
            NestingSolution { placements: vec![placement(0)], unplaced: vec![(0, 1)], height_mm: 95.0, evaluations: 1 };
        progress.on_improved(&found, 1);
        assert_eq!(progress.best.in_words(&target), "100.00 mm high, bound 50.00, gap 50.0 %, 1 of 2 copies");
        found = NestingSolution { placements: vec![placement(0), placement(1)], unplaced: Vec::new(), ..found };
        progress.on_improved(&found, 2);
        assert_eq!(progress.best.in_words(&target), "100.00 mm high, bound 50.00, gap 50.0 %");
        let course = progress.finish(1, &found);
        assert_eq!((course.curve.len(), course.curve[0].1, &*course.ended), (1, 100.0, "nothing more to try"));
        assert_eq!((idle(9.0), idle(40.2)), (String::new(), ", nothing gained for 40 s".to_owned()));
    }
}
