//! The cost of taking files: very many small files dropped at once, and the CPU time for files of a known size.

use std::{
    fs,
    time::{Duration, Instant},
};

use ledger::PartState;

use crate::{
    harness::{SectionBudget, SectionResult},
    support::{TestFarm, cpu_secs, grid::gridded_box, wait_until_or},
};

/// As in `flood`: parts so large that few fill the volume.
const PROFILE: &str = "volume_mm = [200, 200, 200]\nsettle_secs = 0.3\nfinal_secs = 0.5\narrival_secs = 0.5\n";
/// Time limit of `nestd status`, ms (release build).
const STATUS_MS: f64 = 100.0;
/// Squares along an edge of a small part: 2 to 50 kB.
const SMALL: [usize; 5] = [2, 3, 5, 7, 9];
/// Squares along an edge of a part of 47 kB.
const EVEN: usize = 9;

pub fn run(budget: &SectionBudget) -> SectionResult {
    let (many, even) = budget.pick((150, 60), (10_000, 3_000));
    let mut row = SectionResult::default();
    let small = taken(&mut row, many, |n| SMALL[n % SMALL.len()]);
    let same = taken(&mut row, even, |_| EVEN);
    row.points = 2;
    row.note = format!("2 to 50 kB: {small}; 48 kB: {same}");
    row
}

/// Measures a new farm with `count` files in its hot folder; returns the figures as text.
fn taken(row: &mut SectionResult, count: usize, squares: impl Fn(usize) -> usize) -> String {
    let mut farm = TestFarm::running(PROFILE);
    farm.nestd(&["pause", "test"]); // the answer may come later
    let outside = farm.root().join("sending");
    fs::create_dir_all(&outside).unwrap();
    for n in 0..count {
        let size = [60.0, 60.0 + (n % 1000) as f64 * 0.01, 60.0 + (n / 1000) as f64 * 0.01];
        fs::write(outside.join(format!("part-{n}.stl")), gridded_box(size, squares(n))).unwrap();
    }
    let (began, cpu) = (Instant::now(), cpu_secs(farm.pid()));
    for n in 0..count {
        let name = format!("part-{n}.stl");
        fs::rename(outside.join(&name), farm.folder("inbox").join(name)).unwrap();
    }
    let mut status = Vec::new();
    let mut asked = Instant::now();
    wait_until_or(
        &format!("{count} files are taken"),
        60.0 + count as f64 * 0.5,
        || farm.log().lines().rev().take(20).collect::<Vec<_>>().join("\n"),
        || {
            if asked.elapsed() > Duration::from_millis(500) || status.is_empty() {
                asked = Instant::now();
                farm.nestd_ok(&["status"]);
                status.push(1000.0 * asked.elapsed().as_secs_f64());
            }
            waiting(&farm) == count as u64
        },
    );
    let (secs, cpu) = (began.elapsed().as_secs_f64(), cpu_secs(farm.pid()) - cpu);
    status.sort_by(f64::total_cmp);
    let (median, worst) = (status[status.len() / 2], status[status.len() - 1]);
    if !cfg!(debug_assertions) && median > STATUS_MS {
        row.broken.push(format!("status took {median:.0} ms while files were taken"));
    }
    if !farm.parts(PartState::Refused).is_empty() {
        row.broken.push("files were refused".to_owned());
    }
    row.broken.extend(farm.query_ledger(async |ledger| ledger.find_inconsistencies().await.unwrap()));
    row.files += count as u64;
    farm.stop();
    format!(
        "{count} files in {secs:.1} s ({:.0} files/s), {cpu:.1} CPU s, status {median:.0} ms in the median, {worst:.0} ms at worst",
        count as f64 / secs
    )
}

fn waiting(farm: &TestFarm) -> u64 {
    u64::from(farm.query_ledger(async |ledger| {
        ledger.machine_statuses().await.unwrap_or_default().iter().map(|row| row.waiting_parts).sum::<u32>()
    }))
}
