//! The copies of orders (invariant I5) from outside: random operations of people on a farm of two machines, while the
//! daemon and commands are killed at random moments. The test writes down what it asks, and keeps every build file that
//! the printer takes. At the end, the copies in those files must be exactly those that were asked for.

mod asked;
mod operations;
mod outcomes;
mod replay;

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    process::Child,
    sync::atomic::{AtomicU64, Ordering},
    time::{Duration, Instant},
};

use asked::{Asked, CopiesByFile, DroppedLine, TakenBuild};
use farm::{AskedCopies, InvariantExpectations};
use ledger::{CommandId, OrderQuery, PartRow, PartState};
use outcomes::ToldBad;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use replay::{LedgerRecord, OperationReplay};

use crate::{
    harness::{ActionCounts, LOST, SectionBudget, SectionResult, WRONG_IN_SIZE, catch_panic, in_parallel, seed},
    support::{MACHINE, TestFarm, farm_files::list_build_files},
};

/// The second machine.
const OTHER: &str = "other";
const FARM: &str = "scan_secs = 0.2\ncache_bytes = 0\nthreads = 1\norphan_ticket_secs = 4\n[log]\nfilter = \"info\"\n";
const PROFILE: &str = "volume_mm = [60, 60, 60]\nclearance_mm = 1.0\nsettle_secs = 0.05\nunfinished_secs = 0.5\n\
    final_secs = 0.05\narrival_secs = 0.05\nduplicates = \"accept\"\nmax_attempts = 100\n[trigger]\ncopies = 12\n";
/// Operations and kills of a farm.
const OPERATIONS_PER_FARM: u64 = 120;
const OPERATIONS_PER_KILL: u64 = 12;
/// Most operations of a long run; a short run ends when its time is over.
const OPERATIONS: u64 = 120_000;
/// Time budget of a short run, seconds.
const SHORT_SECS: f64 = 12.0;
/// Time for a farm to come to rest after the last operation, seconds.
const REST_SECS: u64 = 120;

/// What many farms did.
#[derive(Default)]
struct RunTotals {
    operations: AtomicU64,
    kills: AtomicU64,
    edits: AtomicU64,
}

pub fn run(budget: &SectionBudget) -> SectionResult {
    let first = seed();
    let (totals, budget) = (RunTotals::default(), &budget.at_least(SHORT_SECS));
    let farms: Vec<u64> = (first..first + budget.pick(4, OPERATIONS / OPERATIONS_PER_FARM)).collect();
    let rows = in_parallel(farms, budget, |seed| {
        catch_panic(&format!("orders of seed {seed}"), || {
            let mut farm = OrdersFarm::new(seed);
            farm.run_operations(budget);
            farm.finish_and_compare(&totals)
        })
    });
    let (operations, faults) = (totals.operations.into_inner(), totals.kills.into_inner());
    SectionResult {
        points: operations,
        faults,
        counts: ActionCounts { kills: faults, edits: totals.edits.into_inner(), ..ActionCounts::default() },
        note: format!("{operations} operations and {faults} kills on {} farms; NESTD_SEED={first}", rows.len()),
        ..SectionResult::sum(&rows)
    }
}

/// A farm and what the test knows of it.
struct OrdersFarm {
    farm: TestFarm,
    rng: ChaCha8Rng,
    seed: u64,
    /// By BLAKE3.
    lines: BTreeMap<String, DroppedLine>,
    operations: Vec<Asked>,
    /// Commands that were not waited for.
    running: Vec<Child>,
    /// By number of the build.
    taken: BTreeMap<i64, TakenBuild>,
    told_bad: ToldBad,
    kills: u64,
    has_emptied_archive: bool,
    /// Parts whose originals were dropped again.
    dropped_again: BTreeSet<i64>,
    is_resting: bool,
    rest_rounds: u64,
    /// What keeps it from rest.
    unrest: String,
    story: Vec<String>,
    broken: Vec<String>,
}

impl OrdersFarm {
    fn new(seed: u64) -> Self {
        let farm = TestFarm::new(PROFILE);
        fs::write(farm.config(), FARM).unwrap();
        farm.write_profile(OTHER, PROFILE);
        Self {
            farm,
            rng: ChaCha8Rng::seed_from_u64(seed),
            seed,
            lines: BTreeMap::new(),
            operations: Vec::new(),
            running: Vec::new(),
            taken: BTreeMap::new(),
            told_bad: ToldBad::new(),
            kills: 0,
            has_emptied_archive: false,
            dropped_again: BTreeSet::new(),
            is_resting: false,
            rest_rounds: 0,
            unrest: String::new(),
            story: Vec::new(),
            broken: Vec::new(),
        }
    }

    fn run_operations(&mut self, budget: &SectionBudget) {
        while (self.operations.len() as u64) < OPERATIONS_PER_FARM && self.broken.is_empty() {
            if budget.left_secs() < 0.5 * budget.secs.min(20.0) {
                return;
            }
            self.farm.start();
            for _ in 0..self.rng.random_range(1..2 * OPERATIONS_PER_KILL) {
                self.run_random_operation();
                let longest_ms = if self.rng.random_bool(0.7) { 40 } else { 400 };
                std::thread::sleep(Duration::from_millis(self.rng.random_range(1..longest_ms)));
            }
            if self.rng.random_bool(0.5) {
                std::thread::sleep(Duration::from_millis(self.rng.random_range(1..1200)));
            }
            self.kill_daemon();
            if self.rng.random_bool(0.3) {
                self.kill_command();
            }
            self.await_commands(0);
            if self.rng.random_bool(0.3) {
                self.compare(false);
            }
        }
    }

    fn kill_daemon(&mut self) {
        self.farm.kill();
        self.kills += 1;
        self.story.push("kill".to_owned());
    }

    fn kill_command(&mut self) {
        if let Some(mut child) = self.running.pop() {
            let _ = child.kill();
            child.wait().unwrap();
            self.kills += 1;
        }
    }

    fn parts(&self) -> Vec<PartRow> {
        self.farm.query_ledger(async |ledger| {
            let mut parts = Vec::new();
            for state in PartState::ALL {
                parts.extend(ledger.parts_in_state(state).await.unwrap_or_default());
            }
            parts.sort_by_key(|part| part.id);
            parts
        })
    }

    fn hash_of(&self, part: i64) -> String {
        let parts = self.parts();
        parts.into_iter().find(|row| row.id.0 == part).map(|row| row.file.content_hash).unwrap_or_default()
    }

    fn order_of(&self, part: i64) -> String {
        self.parts().into_iter().find(|row| row.id.0 == part).map(|row| row.terms.order_name).unwrap_or_default()
    }

    /// The printers take every build file in their queues, and keep it.
    fn take_builds(&mut self) {
        for machine in [MACHINE, OTHER] {
            for file in list_build_files(&self.farm.root().join("queue").join(machine)) {
                let name = file.file_name().unwrap().to_string_lossy().into_owned();
                let kept = self.farm.root().join("taken").join(&name);
                fs::create_dir_all(kept.parent().unwrap()).unwrap();
                if kept.exists() {
                    self.broken.push(format!("I3: {name} appeared in the queue again after the printer had taken it"));
                }
                fs::rename(&file, &kept).unwrap();
                let copies = self.read_copies(&kept);
                let stem = name.trim_end_matches(".build.3mf");
                let number = stem.rsplit('_').next().and_then(|number| number.parse().ok()).unwrap();
                self.taken.insert(number, TakenBuild { file: kept, machine: machine.to_owned(), copies });
            }
        }
    }

    /// The copies in a build file, by dropped file; their size is one that was asked for.
    fn read_copies(&mut self, file: &std::path::Path) -> CopiesByFile {
        let placed = build_file::read_build(file, &Default::default()).unwrap_or_else(|error| {
            self.broken.push(format!("I3: {} cannot be read: {error}", file.display()));
            Vec::new()
        });
        let mut copies = CopiesByFile::new();
        for copy in placed {
            let hash = copy.source_hash.unwrap_or_default();
            if let Some(line) = self.lines.get(&hash) {
                let ratio = copy.mesh.bounds().size().max_element() / line.size_mm;
                // A newer revision takes over the unit of the earlier one.
                let in_cm =
                    |asked: &Asked| matches!(asked, Asked::Edit { in_cm: Some(name), .. } if *name == line.name);
                let is_asked =
                    (ratio - 1.0).abs() < 1e-3 || (ratio - 10.0).abs() < 1e-2 && self.operations.iter().any(in_cm);
                if !is_asked {
                    self.broken.push(format!("{WRONG_IN_SIZE}: {} was printed {ratio:.3} times as large", line.name));
                }
            }
            *copies.entry(hash).or_default() += 1;
        }
        copies
    }

    /// Without further kills: everything is carried out, confirmed, built, printed and told complete.
    fn finish_and_compare(mut self, totals: &RunTotals) -> SectionResult {
        self.farm.start();
        self.is_resting = true;
        let (began, mut rounds_at_rest) = (Instant::now(), 0);
        while rounds_at_rest < 3 {
            self.rest_rounds += 1;
            rounds_at_rest = if self.is_at_rest() { rounds_at_rest + 1 } else { 0 };
            if began.elapsed() > Duration::from_secs(REST_SECS) {
                let (log, state) = (self.farm.log(), self.farm.nestd(&["status", "--parts"]));
                let lines: Vec<&str> = log.lines().collect();
                let tail = lines[lines.len().saturating_sub(12)..].join("\n");
                let state = String::from_utf8_lossy(&state.stdout).into_owned();
                self.broken.push(format!("the farm does not come to rest: {}\n{state}\n{tail}", self.unrest));
                break;
            }
            std::thread::sleep(Duration::from_millis(150));
        }
        self.await_commands(0);
        self.farm.kill();
        self.take_builds();
        if rounds_at_rest > 0 {
            self.compare(true);
        }
        totals.operations.fetch_add(self.operations.len() as u64, Ordering::Relaxed);
        totals.kills.fetch_add(self.kills, Ordering::Relaxed);
        let edits = self.operations.iter().filter(|asked| matches!(asked, Asked::Edit { .. })).count();
        totals.edits.fetch_add(edits as u64, Ordering::Relaxed);
        let (seed, story) = (self.seed, self.story.join("\n  "));
        if !self.broken.is_empty() {
            let parts = self.told_of_broken_parts();
            self.broken.push(format!("the story was\n  {story}\n{parts}"));
        }
        SectionResult {
            files: self.lines.len() as u64,
            builds: self.taken.len() as u64,
            broken: self.broken.iter().map(|text| format!("NESTD_SEED={seed}: {text}")).collect(),
            ..SectionResult::default()
        }
    }

    /// What nestd shows and has logged of the parts that the sentences name.
    fn told_of_broken_parts(&self) -> String {
        let named = |part: &&PartRow| {
            let words = [format!("part {} ", part.id), format!("part {}:", part.id)];
            self.broken.iter().any(|text| words.iter().any(|word| text.contains(word)))
        };
        let log = self.farm.log();
        let told = |part: &PartRow| {
            let shown = self.farm.nestd(&["show", &format!("p{}", part.id)]).stdout;
            let lines = log.lines().filter(|line| line.contains(&part.name) || line.contains("Recovered"));
            format!("{}{}\n", String::from_utf8_lossy(&shown), lines.collect::<Vec<_>>().join("\n"))
        };
        self.parts().iter().filter(named).map(told).collect()
    }

    /// Asks for what is missing until nothing waits, is read, nested or unanswered, and all files are taken.
    fn is_at_rest(&mut self) -> bool {
        self.running.retain_mut(|child| child.try_wait().unwrap().is_none());
        self.take_builds();
        self.tell_rest_complete();
        let parts = self.parts();
        let in_state = |state: PartState| parts.iter().any(|part| part.state == state);
        let pending = self.farm.query_ledger(async |ledger| ledger.pending_commands().await.unwrap());
        let files: Vec<_> = [MACHINE, OTHER]
            .iter()
            .flat_map(|machine| intake::files_below(&self.farm.root().join("inbox").join(machine)).unwrap_or_default())
            .filter(|file| file.extension().is_some_and(|end| end == "stl" || end == "toml" || end == "csv"))
            .collect();
        if files.is_empty() && pending.is_empty() {
            self.drop_missing_originals();
        }
        for part in parts.iter().filter(|part| !part.owed.question.is_empty() && part.state == PartState::Waiting) {
            self.submit(Asked::Confirm { part: part.id.0 }, &["confirm", &part.id.to_string()]);
        }
        if in_state(PartState::Waiting) && self.rest_rounds % 3 == 1 {
            for machine in [MACHINE, OTHER] {
                self.submit(Asked::Other, &["resume", machine]);
                self.submit(Asked::Other, &["flush", machine]);
            }
        }
        let moving =
            [PartState::Claimed, PartState::Waiting, PartState::Batched].into_iter().filter(|s| in_state(*s)).count();
        let open: Vec<_> =
            pending.iter().map(|open| format!("{} {}{:?}", open.kind, open.machine, open.part_id)).collect();
        self.unrest = format!("{files:?} lie, commands {open:?} are open, parts are in {moving} states");
        files.is_empty() && pending.is_empty() && moving == 0 && self.running.is_empty()
    }

    /// Holds the ledger and the build files against what was asked.
    fn compare(&mut self, at_rest: bool) {
        self.take_builds();
        let record = self.read_ledger();
        let mut replay = OperationReplay::new(&self.lines, &self.operations, &self.taken);
        replay.run(&record);
        let mut told_bad = CopiesByFile::new();
        for ((_, hash), copies) in &self.told_bad {
            *told_bad.entry(hash.clone()).or_default() += copies;
        }
        replay.compare_parts(&record, &told_bad);
        let bad_of = |hash: &String| told_bad.get(hash).copied().unwrap_or_default();
        let asked: BTreeMap<String, AskedCopies> = (replay.wanted(&record).into_iter())
            .map(|(hash, wanted)| (hash.clone(), AskedCopies { wanted, bad: bad_of(&hash) }))
            .collect();
        let dropped = self.lines.keys().filter(|hash| !asked.contains_key(*hash));
        let mut broken = replay.broken.clone();
        if at_rest {
            broken.extend(dropped.map(|hash| format!("{LOST}: {} is not in the ledger", self.lines[hash].name)));
        }
        let expectations = InvariantExpectations {
            at_rest,
            asked: Some(asked),
            taken: self.taken.values().map(|build| build.file.clone()).collect(),
            ..InvariantExpectations::default()
        };
        let violations = self.farm.broken_invariants(&expectations);
        // Originals that people removed from the archive are asked for, and cannot be given back.
        let gone =
            ["its original is not in", "its file is not whole in the store", "is refused and its file is not in"];
        let is_own = |text: &String| self.has_emptied_archive && gone.iter().any(|words| text.contains(words));
        broken.extend(violations.into_iter().filter(|text| !is_own(text)));
        self.broken.extend(broken);
    }

    fn read_ledger(&self) -> LedgerRecord {
        let parts = self.parts();
        self.farm.query_ledger(async |ledger| {
            let mut record = LedgerRecord::default();
            for part in parts {
                let mut events = ledger.events_of_part(part.id).await.unwrap();
                events.sort_by_key(|event| event.id);
                record.parts.push((part, events));
            }
            for number in 1.. {
                match ledger.find_command(CommandId(number)).await.unwrap() {
                    Some(command) => record.commands.push(command),
                    None => break,
                }
            }
            let query = OrderQuery { limit: 10_000, ..OrderQuery::default() };
            record.orders = ledger.order_summaries(&query).await.unwrap();
            record
        })
    }
}
