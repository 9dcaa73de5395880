//! Very many files: dropped all at once, then in waves while there is time. Intake must keep up, `nestd status` must
//! answer, and nothing may be lost.

use std::{
    fs,
    path::PathBuf,
    time::{Duration, Instant},
};

use glam::DVec3;
use ledger::{Ledger, PartState};

use super::heavy::peak_mib;
use crate::{
    harness::{SectionBudget, SectionResult},
    support::{TestFarm, stl, wait_until_or},
};

/// The parts are so large that few fill the volume: the queue is long, but each search is short.
const PROFILE: &str = "volume_mm = [200, 200, 200]\nsettle_secs = 0.3\nfinal_secs = 0.5\narrival_secs = 0.5\n";
/// Time limit of `nestd status`, ms (release build).
const STATUS_MS: f64 = 100.0;
/// Memory limit of the daemon with all these parts waiting, MiB.
const MAX_MEMORY_MIB: u64 = 2048;
/// Number of files of a long run, when there is time.
const SOAK_FILES: u64 = 100_000;

pub fn run(budget: &SectionBudget) -> SectionResult {
    let mut farm = TestFarm::running(PROFILE);
    farm.nestd_ok(&["pause", "test"]);
    let at_once: u64 = budget.pick(150, 10_000);
    let mut row = SectionResult::default();
    let mut status = Vec::new();
    let first = wave(&farm, &mut row, at_once, &mut status);
    let mut waves = 1;
    let began = (Instant::now(), row.files);
    while budget.is_long && row.files < SOAK_FILES && budget.left_secs() > 0.1 * budget.secs {
        let count = 500.min(SOAK_FILES - row.files);
        wave(&farm, &mut row, count, &mut status);
        waves += 1;
    }
    let soaked = (row.files - began.1) as f64 / began.0.elapsed().as_secs_f64().max(1e-9);
    status.sort_by(f64::total_cmp);
    let (median, worst) = (status[status.len() / 2], status[status.len() - 1]);
    let peak = peak_mib(farm.pid());
    if !cfg!(debug_assertions) && median > STATUS_MS {
        row.broken.push(format!("status took {median:.0} ms"));
    }
    if peak > MAX_MEMORY_MIB {
        row.broken.push(format!("the daemon took {peak} MiB"));
    }
    row.broken.extend(farm.query_ledger(async |ledger| ledger.find_inconsistencies().await.unwrap()));
    farm.stop();
    row.points = waves;
    row.note = format!(
        "{at_once} at once: {first:.0} files/s; then in waves of 500: {soaked:.0} files/s; status {median:.0} ms in the median, \
         {worst:.0} ms at worst; peak {peak} MiB"
    );
    row
}

/// Drops `count` different files at once and waits until each is a waiting part. Returns files per second.
fn wave(farm: &TestFarm, row: &mut SectionResult, count: u64, status: &mut Vec<f64>) -> f64 {
    let outside = farm.root().join("sending").join(row.files.to_string());
    fs::create_dir_all(&outside).unwrap();
    let names: Vec<PathBuf> = (0..count).map(|n| format!("part-{}.stl", row.files + n).into()).collect();
    for (n, name) in (row.files..).zip(&names) {
        let size = DVec3::new(60.0, 60.0 + (n % 1000) as f64 * 0.01, 60.0 + (n / 1000) as f64 * 0.01);
        fs::write(outside.join(name), stl(&sample_parts::cuboid(size))).unwrap();
    }
    let began = Instant::now();
    for name in &names {
        fs::rename(outside.join(name), farm.folder("inbox").join(name)).unwrap();
    }
    row.files += count;
    let wanted = row.files;
    let mut asked = Instant::now();
    wait_until_or(
        &format!("{wanted} parts wait"),
        60.0 + count as f64 * 0.5,
        || farm.log().lines().rev().take(20).collect::<Vec<_>>().join("\n"),
        || {
            if asked.elapsed() > Duration::from_millis(500) {
                asked = Instant::now();
                farm.nestd_ok(&["status"]);
                status.push(1000.0 * asked.elapsed().as_secs_f64());
            }
            waiting(farm) == wanted
        },
    );
    if status.is_empty() {
        let asked = Instant::now();
        farm.nestd_ok(&["status"]);
        status.push(1000.0 * asked.elapsed().as_secs_f64());
    }
    let secs = began.elapsed().as_secs_f64();
    let left = fs::read_dir(farm.folder("inbox"))
        .unwrap()
        .filter(|e| e.as_ref().unwrap().path().extension() == Some("stl".as_ref()));
    if farm.parts(PartState::Refused).len() + left.count() > 0 {
        row.broken.push("files were refused or left".to_owned());
    }
    count as f64 / secs
}

fn waiting(farm: &TestFarm) -> u64 {
    let of_machine = async |ledger: &Ledger| {
        ledger.machine_statuses().await.unwrap().iter().map(|row| row.waiting_parts).sum::<u32>()
    };
    u64::from(farm.query_ledger(of_machine))
}
