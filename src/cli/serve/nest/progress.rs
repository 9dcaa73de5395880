//! What is said while a search runs.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    thread::JoinHandle,
    time::Duration,
};

use nester::{NestingSolution, ProgressListener, SearchBudget, SearchSummary};

/// Longest bar, columns.
const MAX_BAR_COLUMNS: usize = 30;
/// Columns of a terminal whose size is unknown.
const DEFAULT_COLUMNS: usize = 80;

/// The first and the best height of a search, as the bits of an `f64`; 0 = none yet.
#[derive(Debug, Default)]
struct HeightProgress {
    first: AtomicU64,
    best: AtomicU64,
    is_over: AtomicBool,
}

impl HeightProgress {
    fn record_height(&self, height_mm: f64) {
        let bits = height_mm.to_bits();
        // Sets `first` only once.
        let _ = self.first.compare_exchange(0, bits, Ordering::Relaxed, Ordering::Relaxed);
        self.best.store(bits, Ordering::Relaxed);
    }

    /// The first and the best so far, mm.
    fn first_and_best(&self) -> Option<(f64, f64)> {
        let [first, best] = [&self.first, &self.best].map(|bits| f64::from_bits(bits.load(Ordering::Relaxed)));
        (first > 0.0 && best > 0.0).then_some((first, best))
    }
}

/// Collects the curve of heights. On a terminal, shows a bar with the best height and the remaining budget twice a
/// second.
#[derive(Debug)]
pub struct SearchProgress {
    budget: SearchBudget,
    cpu_before_secs: f64,
    /// Free space below the layout: shown heights are measured from the floor of the machine.
    floor_mm: f64,
    curve: Vec<(f64, f64)>,
    heights: Arc<HeightProgress>,
    printer_thread: Option<JoinHandle<()>>,
}

impl SearchProgress {
    /// Starts to show progress if `on_terminal`.
    pub fn new(on_terminal: bool, budget: SearchBudget, floor_mm: f64) -> Self {
        let heights = Arc::new(HeightProgress::default());
        let (seen, clock) = (heights.clone(), budget.clone());
        let printer = on_terminal.then(|| {
            std::thread::spawn(move || {
                while !seen.is_over.load(Ordering::Relaxed) {
                    eprint!(
                        "\r{}\x1b[K",
                        progress_line(clock.spent_share(), seen.first_and_best(), &left(&clock), terminal_columns())
                    );
                    std::thread::park_timeout(Duration::from_millis(500));
                }
                eprint!("\r\x1b[K");
            })
        });
        Self {
            budget,
            cpu_before_secs: process_cpu_secs(),
            floor_mm,
            curve: Vec::new(),
            heights,
            printer_thread: printer,
        }
    }

    /// Stops the progress bar; returns the course of the search.
    pub fn finish(mut self, seed: u64) -> SearchSummary {
        self.heights.is_over.store(true, Ordering::Relaxed);
        if let Some(printer) = self.printer_thread.take() {
            printer.thread().unpark();
            // A panic of the printer thread is ignored: the search itself is complete.
            let _ = printer.join();
        }
        SearchSummary {
            seed,
            cpu_secs: process_cpu_secs() - self.cpu_before_secs,
            wall_secs: self.budget.elapsed_secs(),
            curve: self.curve,
            ..SearchSummary::default()
        }
    }
}

impl ProgressListener for SearchProgress {
    fn on_improved(&mut self, solution: &NestingSolution, _evaluations: u64) {
        let height_mm = solution.height_mm + self.floor_mm;
        self.heights.record_height(height_mm);
        self.curve.push((self.budget.elapsed_secs(), height_mm));
    }
}

/// What is left of a budget: seconds, or how much of it is done where evaluations are counted.
fn left(budget: &SearchBudget) -> String {
    match budget.secs_left() {
        Some(secs) => format!(", {secs:.0} s left"),
        None => format!(", {:.0} % done", 100.0 * budget.spent_share()),
    }
}

/// `[#########.....] 84.20 mm high, from 96.31, 12 s left`, no longer than the terminal is wide.
fn progress_line(share: f64, heights: Option<(f64, f64)>, left: &str, columns: usize) -> String {
    let heights_text = match heights {
        None => format!("preparing{left}"),
        Some((first, best)) if first > best + 0.005 => format!("{best:.2} mm high, from {first:.2}{left}"),
        Some((_, best)) => format!("{best:.2} mm high{left}"),
    };
    // The last column stays free, so that no terminal wraps the line.
    let bar = columns.saturating_sub(heights_text.len() + 4).min(MAX_BAR_COLUMNS);
    let full = (share * bar as f64).round() as usize;
    let text =
        if bar < 5 { heights_text } else { format!("[{}{}] {heights_text}", "#".repeat(full), ".".repeat(bar - full)) };
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
    use nester::StopCondition;

    use super::*;

    #[test]
    fn the_bar_grows_the_height_falls_and_the_line_fits_the_terminal() {
        assert_eq!(progress_line(0.0, None, ", 30 s left", 40), "[................] preparing, 30 s left");
        let late = progress_line(0.5, Some((120.0, 84.2)), ", 15 s left", 80);
        assert_eq!(late, "[###############...............] 84.20 mm high, from 120.00, 15 s left");
        assert_eq!(progress_line(1.0, Some((84.2, 84.2)), ", 0 s left", 30), "84.20 mm high, 0 s left");
        for columns in 0..100 {
            assert!(
                progress_line(0.3, Some((1000.0, 900.0)), ", 3 s left", columns).len() <= columns.saturating_sub(1)
            );
        }
    }

    #[test]
    fn counted_evaluations_are_a_share_of_the_bar() {
        let budget = SearchBudget::of_evaluations(200);
        assert_eq!(left(&budget), ", 0 % done");
        budget.spent_share_at(50);
        assert_eq!((budget.spent_share(), left(&budget)), (0.25, ", 25 % done".to_owned()));
        assert_eq!(left(&SearchBudget::of_secs(0.0)), ", 0 s left");
    }

    #[test]
    fn the_first_height_stays_and_the_best_follows() {
        let heights = HeightProgress::default();
        assert_eq!(heights.first_and_best(), None);
        [120.0, 96.0, 84.0].into_iter().for_each(|height_mm| heights.record_height(height_mm));
        assert_eq!(heights.first_and_best(), Some((120.0, 84.0)));
    }
}
