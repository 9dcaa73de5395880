//! What is told of a week, as a table of Markdown.

use std::fmt;

use super::printers::PrintedBuild;

/// The builds of a machine.
#[derive(Debug, Default)]
struct MachineFigures {
    name: &'static str,
    builds: u32,
    failed: u32,
    copies: usize,
    height_mm: f64,
    density: f64,
}

/// The figures of a week.
#[derive(Debug, Default)]
pub struct WeekReport {
    seed: u64,
    orders: usize,
    lines: usize,
    late_words: usize,
    machines: Vec<MachineFigures>,
    bad_copies: u32,
    /// Late words that came too late, and were refused with a reason.
    pub late_words_refused: u32,
    /// Orders that got all that was asked.
    pub orders_complete: u32,
    /// Orders that got it by their due date.
    pub dates_kept: u32,
    /// Good copies.
    pub copies_delivered: u32,
    /// Days until the last order was complete.
    pub days: f64,
    /// Processor time, seconds.
    pub cpu_secs: f64,
    /// Elapsed time, seconds.
    pub wall_secs: f64,
}

impl WeekReport {
    /// A report of nothing yet.
    pub fn new(seed: u64, orders: usize, lines: usize, late_words: usize, machines: &[(&'static str, String)]) -> Self {
        let machines = machines.iter().map(|(name, _)| MachineFigures { name, ..MachineFigures::default() });
        Self { seed, orders, lines, late_words, machines: machines.collect(), ..Self::default() }
    }

    /// Adds a build that failed.
    pub fn add_failed(&mut self, build: &PrintedBuild) {
        self.machines[build.machine].failed += 1;
        self.add_build(build);
    }

    /// Adds a build that is complete but for bad copies.
    pub fn add_complete(&mut self, build: &PrintedBuild, bad: u32) {
        self.bad_copies += bad;
        self.add_build(build);
    }

    fn add_build(&mut self, build: &PrintedBuild) {
        let machine = &mut self.machines[build.machine];
        machine.builds += 1;
        machine.copies += build.copies.len();
        machine.height_mm += build.height_mm;
        machine.density += build.density;
    }
}

impl fmt::Display for WeekReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "| | |\n|---|---:|\n| seed | {} |", self.seed)?;
        writeln!(f, "| orders, complete | {}, {} |", self.orders, self.orders_complete)?;
        writeln!(f, "| due dates kept | {} |", self.dates_kept)?;
        writeln!(f, "| lines, good copies | {}, {} |", self.lines, self.copies_delivered)?;
        writeln!(f, "| late words, of them refused as too late | {}, {} |", self.late_words, self.late_words_refused)?;
        writeln!(f, "| bad copies, printed again | {} |", self.bad_copies)?;
        writeln!(f, "| days until the last copy | {:.1} |", self.days)?;
        writeln!(f, "| CPU s, elapsed s | {:.0}, {:.0} |", self.cpu_secs, self.wall_secs)?;
        writeln!(f, "\n| machine | builds | failed, printed again | copies | mean height, mm | mean density |")?;
        writeln!(f, "|---|---:|---:|---:|---:|---:|")?;
        for MachineFigures { name, builds, failed, copies, height_mm, density } in &self.machines {
            let mean = |sum: f64| sum / f64::from(*builds).max(1.0);
            let (height_mm, percent) = (mean(*height_mm), 100.0 * mean(*density));
            writeln!(f, "| {name} | {builds} | {failed} | {copies} | {height_mm:.1} | {percent:.1} % |")?;
        }
        Ok(())
    }
}
