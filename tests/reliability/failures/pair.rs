//! Two servers on one share: the first pauses after its n-th changing call for longer than its lease, the second takes
//! the folders and adopts the claims, then the first resumes. Copies are counted by content in the build files that the
//! printer got: none is printed twice, none is lost.

use std::{
    collections::BTreeMap,
    fs,
    path::PathBuf,
    process::Command,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use crate::{
    harness::{SectionBudget, SectionResult, catch_panic, in_parallel, life_cycle, spread_order},
    support::{
        MACHINE, TestFarm, block, stl,
        trace::{CallEffect, CallVerdict, CallWatcher, SystemCall, TracedDaemon, is_allowed},
    },
};

/// The dropped cubes, by their edge in mm.
const SIZES: [f64; 3] = [9.0, 10.0, 11.0];
const PROFILE: &str = "volume_mm = [60, 60, 60]\nclearance_mm = 2.0\nsettle_secs = 0.05\nunfinished_secs = 0.5\n\
    final_secs = 0.05\narrival_secs = 0.05\nduplicates = \"accept\"\nmax_attempts = 100\n";
const TRIGGER: &str = "[trigger]\ncopies = 1\n";
/// The factor by which a lease is shorter than in production.
const HURRY: &str = "10";

pub fn run(budget: &SectionBudget) -> SectionResult {
    if !is_allowed() {
        return SectionResult {
            note: "SKIPPED: processes may not be traced here".to_owned(),
            ..SectionResult::default()
        };
    }
    // A short run has no time to count them first.
    let (whole, row) = if budget.is_long { one_trial(u64::MAX) } else { (900, SectionResult::default()) };
    let points = spread_order(whole);
    let all = points.len();
    let mut rows = in_parallel(points, budget, |point| {
        catch_panic(&format!("paused after change {point}"), || one_trial(point).1)
    });
    let note = format!("two servers, the first paused after the n-th changing call; {} of {all} points", rows.len());
    rows.insert(0, row);
    let sum = SectionResult::sum(&rows);
    SectionResult { faults: sum.points, note, ..sum }
}

/// Both servers' farms; the folders are those of the first.
struct ServerPair {
    first: TestFarm,
    second: TestFarm,
    printed: BTreeMap<String, u32>,
    builds: u64,
}

fn one_trial(point: u64) -> (u64, SectionResult) {
    let mut pair = ServerPair::new();
    let watch = PauseAfterChanges { point, ..PauseAfterChanges::default() };
    let (count, paused, go_on) = (watch.count.clone(), watch.paused.clone(), watch.go_on.clone());
    let first = as_host(pair.first.command(&["run"]), "first");
    let traced = TracedDaemon::start(first, pair.first.root(), watch).unwrap();
    let wanted = SIZES.len() as u32;
    pair.wait(60.0, |pair| paused.load(Ordering::SeqCst) || pair.total() == wanted);
    let is_paused = paused.load(Ordering::SeqCst);
    let mut broken = Vec::new();
    if is_paused {
        pair.second.start_as(as_host(pair.second.command(&["run"]), "second"));
        pair.adopt(&mut broken);
        pair.wait(1.0, |_| false);
        go_on.store(true, Ordering::SeqCst);
        pair.wait(6.0, |pair| pair.total() >= wanted);
        // The second gives the folders back, and the first continues with its own parts.
        pair.second.stop();
    }
    pair.wait(60.0, |pair| pair.total() >= wanted);
    pair.wait(0.5, |_| false);
    let text = format!("{}\n---- second\n{}", pair.first.log(), pair.second.log());
    go_on.store(true, Ordering::SeqCst);
    drop(traced.kill());
    for size in SIZES {
        let hash = blake3::hash(&stl(&block(size, size, size))).to_hex().to_string();
        let copies = pair.printed.get(&hash).copied().unwrap_or_default();
        if copies != 1 {
            broken.push(format!(
                "paused after change {point}: the block of {size} mm was printed {copies} times\n{text}"
            ));
        }
    }
    let points = u64::from(is_paused);
    (
        count.load(Ordering::SeqCst),
        SectionResult { points, files: u64::from(wanted), builds: pair.builds, broken, ..SectionResult::default() },
    )
}

impl ServerPair {
    fn new() -> Self {
        let first = TestFarm::new(&format!("{PROFILE}{TRIGGER}"));
        let shared = ["inbox", "queue"].map(|kind| format!("{kind} = {:?}\n", first.folder(kind))).concat();
        let second = TestFarm::new(&format!("{PROFILE}[folders]\n{shared}{TRIGGER}"));
        // The harness waits for this folder of a farm.
        fs::create_dir_all(second.folder("inbox")).unwrap();
        for farm in [&first, &second] {
            fs::write(farm.config(), life_cycle::FARM).unwrap();
        }
        for size in SIZES {
            first.drop_part(&format!("block-{size}.stl"), &block(size, size, size));
        }
        Self { first, second, printed: BTreeMap::new(), builds: 0 }
    }

    /// Waits until the condition holds; meanwhile the printer takes the build files that appear.
    fn wait(&mut self, secs: f64, mut holds: impl FnMut(&Self) -> bool) {
        let began = Instant::now();
        while began.elapsed().as_secs_f64() < secs && !holds(self) {
            self.print();
            std::thread::sleep(Duration::from_millis(20));
        }
        self.print();
    }

    fn print(&mut self) {
        for file in self.first.queued() {
            let to: PathBuf = self.first.root().join(format!("printed-{}", self.builds));
            if fs::rename(&file, &to).is_err() {
                continue;
            }
            self.builds += 1;
            for placed in build_file::read_build(&to, &build_file::ReadLimits::default()).unwrap() {
                *self.printed.entry(placed.source_hash.unwrap()).or_default() += 1;
            }
        }
    }

    fn total(&self) -> u32 {
        self.printed.values().sum()
    }

    /// Runs `nestd adopt` as soon as the second serves: it takes over the claims of the first.
    fn adopt(&mut self, broken: &mut Vec<String>) {
        let began = Instant::now();
        let marker = self.first.folder("inbox").join(".nestd-owner");
        let serves = || fs::read_to_string(&marker).is_ok_and(|text| text.contains("\"second\""));
        self.wait(15.0, |_| serves());
        let adopted = as_host(self.second.command(&["adopt", MACHINE]), "second").output().unwrap();
        if !adopted.status.success() {
            let text = String::from_utf8_lossy(&adopted.stderr).into_owned();
            broken.push(format!("adopting was refused after {:?}: {text}\n{}", began.elapsed(), self.second.log()));
        }
        let left = intake::foreign_claims(&self.first.folder("inbox"), "nobody").unwrap_or_default();
        let former: Vec<_> = left.iter().filter(|name| name.starts_with(".new-")).collect();
        if !former.is_empty() && !adopted.status.success() {
            broken.push(format!("half made claims are left: {former:?}"));
        }
    }
}

fn as_host(mut command: Command, name: &str) -> Command {
    command.env("NESTD_TEST_HOST", name).env("NESTD_TEST_HURRY", HURRY);
    command
}

/// Pauses the daemon after its n-th changing call: a traced process stands still while its tracer waits.
#[derive(Default)]
struct PauseAfterChanges {
    point: u64,
    count: Arc<AtomicU64>,
    paused: Arc<AtomicBool>,
    go_on: Arc<AtomicBool>,
}

impl CallWatcher for PauseAfterChanges {
    fn before(&mut self, _: &SystemCall) -> CallVerdict {
        CallVerdict::Let
    }

    fn after(&mut self, call: &SystemCall, result: i64) -> bool {
        if call.kind != CallEffect::Change || result < 0 {
            return true;
        }
        if self.count.fetch_add(1, Ordering::SeqCst) + 1 == self.point {
            self.paused.store(true, Ordering::SeqCst);
            let began = Instant::now();
            while !self.go_on.load(Ordering::SeqCst) && began.elapsed() < Duration::from_secs(60) {
                std::thread::sleep(Duration::from_millis(5));
            }
        }
        true
    }
}
