//! Damaged files through every reader, in this process: no reader may panic, hang, or accept what it must not accept.
//! The inputs are random changes of the corpus of the fuzz targets.

use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    time::Instant,
};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    harness::{SectionBudget, SectionResult},
    support::{entries, samples},
};

/// A reader that takes longer than this hangs, seconds.
const MAX_SECS: f64 = 10.0;
/// Memory limit of this process while all readers run, MiB.
const MAX_MEMORY_MIB: u64 = 1500;

pub fn run(budget: &SectionBudget) -> SectionResult {
    let mut rng = ChaCha8Rng::seed_from_u64(if budget.is_long { rand::random() } else { 42 });
    let mut row = SectionResult::default();
    let corpora: Vec<Vec<Vec<u8>>> = entries::TARGETS.iter().map(|(target, _)| corpus(target)).collect();
    let mut slowest: (f64, &str) = (0.0, "");
    while !budget.is_spent() && row.broken.len() < 20 {
        for ((target, entry), files) in entries::TARGETS.iter().zip(&corpora) {
            for _ in 0..50 {
                let bytes = samples::mutated(&files[rng.random_range(0..files.len())], &mut rng);
                let began = Instant::now();
                let ended = catch_unwind(AssertUnwindSafe(|| entry(&bytes)));
                let secs = began.elapsed().as_secs_f64();
                row.points += 1;
                if ended.is_err() || secs > MAX_SECS {
                    row.broken.push(format!("{target} after {secs:.1} s on {}", bytes.escape_ascii()));
                }
                slowest = if secs > slowest.0 { (secs, target) } else { slowest };
            }
        }
    }
    let peak_mib = peak_memory_mib();
    if peak_mib > MAX_MEMORY_MIB {
        row.broken.push(format!("the readers took {peak_mib} MiB"));
    }
    row.note = format!(
        "{} readers; the slowest input took {:.0} ms ({}), {peak_mib} MiB at most",
        entries::TARGETS.len(),
        1000.0 * slowest.0,
        slowest.1
    );
    row
}

fn corpus(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz_corpus").join(target);
    fs::read_dir(folder).unwrap().map(|entry| fs::read(entry.unwrap().path()).unwrap()).collect()
}

fn peak_memory_mib() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() / 1024
}
