//! Everything at once: kill -9 at random moments, mixed with random actions of people: drops (also of the same content
//! again), tickets, lists, order folders, cancels, retries, flushes, pauses, outcomes, reloads, backups and restores.
//! The script alone records the expected copies, never the ledger; printed copies are counted by content in the build
//! files that the printer took. Nothing may be lost silently or printed twice.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::PathBuf,
    sync::atomic::{AtomicU64, Ordering},
    time::{Duration, Instant},
};

use ledger::{PartRow, PartState};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    harness::{
        ActionCounts, DOUBLED, LOST, SectionBudget, SectionResult, WRONG_IN_SIZE, catch_panic, in_parallel,
        life_cycle::{self, BUSY_MACHINE},
        printer::ScriptedPrinter,
        seed,
    },
    support::{MACHINE, TestFarm, block, stl},
};

/// Most kills of a long run; a short run ends when its time is over.
const KILLS: u64 = 20_000;
const KILLS_PER_FARM: u64 = 25;
/// Time budget of a short run, seconds.
const SHORT_SECS: f64 = 10.0;
/// Time for a farm to come to rest after the last kill, seconds.
const REST_SECS: u64 = 120;

pub fn run(budget: &SectionBudget) -> SectionResult {
    let first = seed();
    let (kills, budget) = (AtomicU64::new(0), &budget.at_least(SHORT_SECS));
    let farms: Vec<u64> = (first..first + budget.pick(4, KILLS / KILLS_PER_FARM)).collect();
    let rows = in_parallel(farms, budget, |seed| {
        catch_panic(&format!("storm of seed {seed}"), || {
            let mut storm = StormFarm::new(seed);
            storm.run_random_actions(budget, &kills);
            storm.finish_and_compare()
        })
    });
    let faults = kills.into_inner();
    SectionResult {
        points: rows.len() as u64,
        faults,
        note: format!("{faults} kills on {} farms, amid everything else; NESTD_SEED={first}", rows.len()),
        ..SectionResult::sum(&rows)
    }
}

/// What the script knows about one content.
#[derive(Debug, Default, Clone)]
struct ExpectedContent {
    /// Expected copies.
    copies: u32,
    /// The content cannot be read: it must be refused.
    is_bad: bool,
    /// Copies that may be missing, because the script has cancelled the part at least once.
    cancelled: u32,
    /// File names under which it was dropped, as reasons and reports show them.
    names: BTreeSet<String>,
}

struct StormFarm {
    farm: TestFarm,
    rng: ChaCha8Rng,
    seed: u64,
    dropped: u64,
    /// By content.
    expected: BTreeMap<String, ExpectedContent>,
    /// Sizes of the parts, mm, by content.
    sizes: BTreeMap<String, [f64; 3]>,
    /// Dropped contents, to be dropped again.
    contents: Vec<Vec<u8>>,
    /// Copies in the build files that the printer took, by content.
    printed: BTreeMap<String, u32>,
    printer: ScriptedPrinter,
    counts: ActionCounts,
    backups: Vec<PathBuf>,
    /// Everything that `restore` reported for a person to look at.
    doubts: String,
    history: Vec<String>,
    broken: Vec<String>,
}

impl StormFarm {
    fn new(seed: u64) -> Self {
        Self {
            farm: life_cycle::quick_farm(BUSY_MACHINE),
            rng: ChaCha8Rng::seed_from_u64(seed),
            seed,
            dropped: 0,
            expected: BTreeMap::new(),
            sizes: BTreeMap::new(),
            contents: Vec::new(),
            printed: BTreeMap::new(),
            printer: ScriptedPrinter::default(),
            counts: ActionCounts::default(),
            backups: Vec::new(),
            doubts: String::new(),
            history: Vec::new(),
            broken: Vec::new(),
        }
    }

    fn run_random_actions(&mut self, budget: &SectionBudget, all: &AtomicU64) {
        for _ in 0..KILLS_PER_FARM {
            if budget.left_secs() < 0.3 * budget.secs.min(20.0) {
                return;
            }
            self.farm.start();
            for _ in 0..self.rng.random_range(0..4) {
                self.run_random_action();
            }
            let max_ms = if self.rng.random_bool(0.5) { 120 } else { 1200 };
            std::thread::sleep(Duration::from_millis(self.rng.random_range(2..max_ms)));
            self.farm.kill();
            all.fetch_add(1, Ordering::Relaxed);
            self.counts.kills += 1;
            self.history.push("kill".to_owned());
            if self.rng.random_bool(0.3) {
                self.take_printed_files();
            }
            if self.rng.random_bool(0.15) {
                self.restore_backup();
            }
        }
    }

    fn run_random_action(&mut self) {
        match self.rng.random_range(0..17) {
            0..=5 => self.drop_random_part(),
            6 => self.drop_order_list(),
            7 => self.cancel_part(),
            8 => self.retry_part(),
            9 => self.run_command(&["flush", MACHINE]),
            10 => self.run_command(&["pause", MACHINE]),
            11 => self.run_command(&["resume", MACHINE]),
            12 => self.record_outcome(),
            13 => {
                let profile = format!("{BUSY_MACHINE}# {}\n", self.dropped);
                self.farm.write_profile(MACHINE, &profile);
                self.farm.reload();
            }
            14 => self.take_printed_files(),
            15 => self.edit_part(),
            _ => self.make_backup(),
        }
    }

    /// Runs a command without waiting for the daemon's answer.
    fn run_command(&mut self, args: &[&str]) {
        self.history.push(args.join(" "));
        let _ = self.farm.nestd(args);
    }

    /// Picks a content: new, an earlier one, or an unreadable one.
    fn pick_content(&mut self) -> (Vec<u8>, bool) {
        if !self.contents.is_empty() && self.rng.random_bool(0.2) {
            let again = self.rng.random_range(0..self.contents.len());
            return (self.contents[again].clone(), false);
        }
        let is_bad = self.rng.random_bool(0.1);
        let n = self.dropped as f64;
        let size @ [x, y, z] = [12.0, 9.0 + n * 0.01, f64::from(self.rng.random_range(5..25))];
        let bytes = match is_bad {
            true => format!("solid nonsense {n}\nendsolid\n").into_bytes(),
            false => stl(&block(x, y, z)),
        };
        if !is_bad {
            self.sizes.insert(hash(&bytes), size);
            self.contents.push(bytes.clone());
        }
        (bytes, is_bad)
    }

    fn record_expected(&mut self, bytes: &[u8], name: &str, copies: u32, is_bad: bool) {
        let expected = self.expected.entry(hash(bytes)).or_default();
        expected.copies += copies;
        expected.is_bad = is_bad;
        expected.names.insert(name.to_owned());
        self.dropped += 1;
    }

    /// Drops a part, sometimes in an order folder, sometimes with a ticket.
    fn drop_random_part(&mut self) {
        let (bytes, is_bad) = self.pick_content();
        let (n, mut copies) = (self.dropped, self.rng.random_range(1..4));
        let folder = if self.rng.random_bool(0.2) { format!("order-{n}/") } else { String::new() };
        let name = if copies > 1 { format!("part{n}_x{copies}.stl") } else { format!("part{n}.stl") };
        if self.rng.random_bool(0.2) {
            copies = self.rng.random_range(1..4);
            self.farm.drop_bytes(&format!("{folder}{name}.toml"), format!("copies = {copies}\n").as_bytes());
        }
        self.record_expected(&bytes, &name, copies, is_bad);
        self.farm.drop_bytes(&format!("{folder}{name}"), &bytes);
        self.history.push(format!("drop {folder}{name} ({copies})"));
    }

    /// Drops an order folder whose list comes first.
    fn drop_order_list(&mut self) {
        let order = format!("list-{}", self.dropped);
        let (mut list, mut files) = ("file,copies\n".to_owned(), Vec::new());
        for _ in 0..self.rng.random_range(1..4) {
            let (bytes, is_bad) = self.pick_content();
            let (name, copies) = (format!("part{}.stl", self.dropped), self.rng.random_range(1..5));
            list += &format!("{name},{copies}\n");
            self.record_expected(&bytes, &name, copies, is_bad);
            files.push((name, bytes));
        }
        self.farm.drop_bytes(&format!("{order}/order.csv"), list.as_bytes());
        files.iter().for_each(|(name, bytes)| self.farm.drop_bytes(&format!("{order}/{name}"), bytes));
        self.history.push(format!("drop {order}: {list:?}"));
    }

    /// Parts in a state, as targets of commands; the script knows them by content.
    fn parts(&self, state: PartState) -> Vec<PartRow> {
        let began = Instant::now();
        while !self.farm.root().join("state/nestd.db").exists() {
            if began.elapsed().as_secs() > 5 {
                return Vec::new();
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        self.farm.query_ledger(async |ledger| ledger.parts_in_state(state).await.unwrap_or_default())
    }

    fn pick_part(&mut self, state: PartState) -> Option<PartRow> {
        let mut parts = self.parts(state);
        (!parts.is_empty()).then(|| parts.swap_remove(self.rng.random_range(0..parts.len())))
    }

    fn cancel_part(&mut self) {
        let Some(part) = self.pick_part(PartState::Waiting) else { return };
        if let Some(expected) = self.expected.get_mut(&part.file.content_hash) {
            expected.cancelled += part.owed.copies;
        }
        self.run_command(&["cancel", &part.id.to_string()]);
    }

    /// Wants another number of copies of a part that waits. A kill may come before or after, so either number may be printed.
    fn edit_part(&mut self) {
        let Some(part) = self.pick_part(PartState::Waiting) else { return };
        let (before, after): (u32, u32) = (part.wanted_copies(), self.rng.random_range(1..5));
        if let Some(expected) = self.expected.get_mut(&part.file.content_hash) {
            expected.copies += after.saturating_sub(before);
            expected.cancelled += after.abs_diff(before);
        }
        self.counts.edits += 1;
        self.run_command(&["edit", &part.id.to_string(), "--copies", &after.to_string()]);
    }

    fn retry_part(&mut self) {
        let Some(part) = self.pick_part(PartState::Refused) else { return };
        self.run_command(&["retry", &part.id.to_string()]);
    }

    fn record_outcome(&mut self) {
        // The copies of a failed print are printed again unless it is told otherwise; this section counts each once.
        let outcomes: [&[&str]; 3] = [&["complete"], &["interrupted"], &["failed", "--keep"]];
        let outcome = outcomes[self.rng.random_range(0..3)];
        // Of one that the printer took: who insists on one that lies in the queue has it taken out of the queue.
        let taken: Vec<&String> = self.printer.taken.iter().collect();
        let Some(name) = taken.get(self.rng.random_range(0..taken.len().max(1))) else { return };
        let number = name.trim_end_matches(".build.3mf").rsplit_once('_').map_or("1", |(_, number)| number);
        let build = number.trim_start_matches('0').to_owned();
        self.run_command(&[&["outcome", build.as_str()], outcome].concat());
    }

    fn make_backup(&mut self) {
        let file = self.farm.root().join(format!("backup-{}", self.history.len()));
        if self.farm.nestd(&["backup", file.to_str().unwrap()]).status.success() {
            self.history.push(format!("backup {}", file.display()));
            self.backups.push(file);
        }
    }

    /// Restores a backup while the daemon does not run. The reports for a person are kept, and those parts count as
    /// handled.
    fn restore_backup(&mut self) {
        if self.backups.is_empty() {
            return;
        }
        let backup = self.backups[self.rng.random_range(0..self.backups.len())].clone();
        let output = self.farm.nestd(&["restore", backup.to_str().unwrap()]);
        let output_text = text(&output);
        self.history.push(format!("restore {}: {output_text}", backup.display()));
        if !output.status.success() {
            self.broken.push(format!("restoring failed: {output_text}"));
        }
        self.counts.restores += 1;
        let checked = self.farm.nestd(&["check", "--deep"]);
        let checked_text = text(&checked);
        if !checked_text.contains("I1 to I5 hold") {
            self.broken.push(format!("the deep check after a restore finds something: {checked_text}"));
        }
        self.doubts += &output_text.lines().filter(|line| line.contains("LOOK AT")).collect::<Vec<_>>().join("\n");
        self.doubts += "\n";
    }

    /// Takes build files from the queue as a printer does, and counts their copies.
    fn take_printed_files(&mut self) {
        for (name, placed) in self.printer.take_builds(&self.farm, &mut self.broken) {
            for copy in placed {
                let size = copy.mesh.bounds().size().to_array();
                let dropped = copy.source_hash.as_ref().and_then(|hash| self.sizes.get(hash));
                if dropped.is_some_and(|dropped| dropped.iter().zip(size).any(|(a, b)| (a - b).abs() > 0.01)) {
                    self.broken.push(format!("{WRONG_IN_SIZE}: {size:?} mm in {name}, dropped as {dropped:?}"));
                }
                *self.printed.entry(copy.source_hash.unwrap_or_default()).or_default() += 1;
            }
            self.history.push(format!("print {name}"));
        }
    }

    /// Finishes without further kills, then compares expected and printed copies.
    fn finish_and_compare(mut self) -> SectionResult {
        self.farm.start();
        self.run_command(&["resume", MACHINE]);
        let (began, mut rounds_at_rest) = (Instant::now(), 0);
        while rounds_at_rest < 3 {
            std::thread::sleep(Duration::from_millis(400));
            rounds_at_rest = if self.is_at_rest() { rounds_at_rest + 1 } else { 0 };
            if began.elapsed() > Duration::from_secs(REST_SECS) {
                let (log, state) = (self.farm.log(), self.farm.nestd(&["status", "--parts"]));
                let lines: Vec<&str> = log.lines().collect();
                let tail = lines[lines.len().saturating_sub(12)..].join("\n");
                self.broken.push(format!("the farm does not come to rest\n{}\n{tail}", text(&state)));
                break;
            }
        }
        self.farm.kill();
        self.take_printed_files();
        self.compare_copies();
        let (seed, story) = (self.seed, self.history.join("\n  "));
        if !self.broken.is_empty() {
            self.broken.push(format!("the story was\n  {story}"));
        }
        SectionResult {
            files: self.dropped,
            builds: self.printer.taken.len() as u64,
            counts: self.counts,
            broken: self.broken.iter().map(|text| format!("NESTD_SEED={seed}: {text}")).collect(),
            ..SectionResult::default()
        }
    }

    /// Whether all dropped files are taken, and none waits to be read, nested or published.
    fn is_at_rest(&mut self) -> bool {
        self.take_printed_files();
        let inbox = self.farm.folder("inbox");
        let is_part = |file: &PathBuf| file.extension().is_some_and(|extension| extension == "stl");
        let is_empty = !intake::files_below(&inbox).unwrap_or_default().iter().any(is_part);
        let waiting = self.parts(PartState::Waiting).len();
        if waiting > 0 {
            let _ = self.farm.nestd(&["flush", MACHINE]);
        }
        let in_work = self.parts(PartState::Claimed).len() + self.parts(PartState::Batched).len();
        is_empty && waiting + in_work == 0
    }

    fn compare_copies(&mut self) {
        let error = intake::files_below(&self.farm.folder("error")).unwrap_or_default();
        let refused: BTreeSet<String> =
            error.iter().filter_map(|file| Some(hash(&fs::read(file).ok()?))).collect::<BTreeSet<_>>();
        for (content, expected) in &self.expected {
            let printed = self.printed.remove(content).unwrap_or_default();
            let about = format!("{content} ({:?})", expected.names);
            if printed > expected.copies || (expected.is_bad && printed > 0) {
                self.broken.push(format!("{DOUBLED}: {about}: {printed} copies printed, {} asked", expected.copies));
            }
            let missing = expected.copies.saturating_sub(printed);
            let is_named = refused.contains(content)
                || self.doubts.contains(content.as_str())
                || expected.names.iter().any(|name| self.doubts.contains(name.as_str()));
            if missing > 0 && !is_named && missing > expected.cancelled {
                self.broken.push(format!(
                    "{LOST}: {about}: {printed} copies printed, {} asked, {} cancelled, and nobody was told",
                    expected.copies, expected.cancelled
                ));
            }
        }
        for (content, copies) in &self.printed {
            self.broken.push(format!("{copies} copies of {content} were printed, and nobody asked"));
        }
    }
}

fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

fn text(output: &std::process::Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}
