//! Everything at once: kill -9 at random moments, mixed at random with all that people do to a farm: drops (the same content
//! again, too), tickets, lists, order folders, cancels, retries, flushes, pauses, outcomes, reloads, backups and restores. What
//! was asked is noted by the script alone, never by the ledger; what was printed is counted in the build files that the printer
//! took, by content. Nothing may be lost in silence, nothing doubled.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::PathBuf,
    sync::atomic::{AtomicU64, Ordering},
    time::{Duration, Instant},
};

use nestd::ledger::{PartRow, PartState};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    budget::Budget,
    life,
    pool::{caught, in_parallel, seed},
    row::Row,
    support::{PROFILE, TestFarm, block, stl},
};

/// Kills of a long run at most; a short one ends with its time.
const KILLS: u64 = 20_000;
const KILLS_PER_FARM: u64 = 25;
/// A short run takes so long for them at least.
const SHORT_SECS: f64 = 10.0;
/// A farm has so long to come to rest after the last kill, seconds.
const REST_SECS: u64 = 120;
const MACHINE: &str = "volume_mm = [120, 120, 120]\nclearance_mm = 2.0\nsettle_secs = 0.05\nunfinished_secs = 0.5\n\
    final_secs = 0.1\narrival_secs = 0.1\nduplicates = \"accept\"\nmax_attempts = 100\n[trigger]\ncopies = 8\n";

pub fn run(budget: &Budget) -> Row {
    let first = seed();
    let (kills, budget) = (AtomicU64::new(0), &budget.at_least(SHORT_SECS));
    let farms: Vec<u64> = (first..first + budget.pick(4, KILLS / KILLS_PER_FARM)).collect();
    let rows = in_parallel(farms, budget, |seed| {
        caught(&format!("storm of seed {seed}"), || {
            let mut storm = Storm::new(seed);
            storm.rages(budget, &kills);
            storm.settles()
        })
    });
    let faults = kills.into_inner();
    Row {
        points: rows.len() as u64,
        faults,
        note: format!("{faults} kills on {} farms, amid everything else; NESTD_SEED={first}", rows.len()),
        ..Row::sum(&rows)
    }
}

/// What the script knows of one content.
#[derive(Debug, Default, Clone)]
struct Asked {
    /// Copies that were asked for.
    copies: u32,
    /// It cannot be read: it must be refused.
    is_bad: bool,
    /// The script has ordered it to be cancelled, at least once: so many copies may be missing.
    cancelled: u32,
    /// Names that it was dropped under, as reasons and reports name it.
    names: BTreeSet<String>,
}

struct Storm {
    farm: TestFarm,
    rng: ChaCha8Rng,
    seed: u64,
    dropped: u64,
    /// By content.
    asked: BTreeMap<String, Asked>,
    /// Contents that were dropped, to be dropped again.
    contents: Vec<Vec<u8>>,
    /// Copies in the build files that the printer took, by content.
    printed: BTreeMap<String, u32>,
    taken: BTreeSet<String>,
    backups: Vec<PathBuf>,
    /// All that `restore` told a person to look at.
    doubts: String,
    history: Vec<String>,
    broken: Vec<String>,
}

impl Storm {
    fn new(seed: u64) -> Self {
        let farm = TestFarm::new(MACHINE);
        fs::write(farm.config(), life::FARM).unwrap();
        Self {
            farm,
            rng: ChaCha8Rng::seed_from_u64(seed),
            seed,
            dropped: 0,
            asked: BTreeMap::new(),
            contents: Vec::new(),
            printed: BTreeMap::new(),
            taken: BTreeSet::new(),
            backups: Vec::new(),
            doubts: String::new(),
            history: Vec::new(),
            broken: Vec::new(),
        }
    }

    fn rages(&mut self, budget: &Budget, all: &AtomicU64) {
        for _ in 0..KILLS_PER_FARM {
            if budget.left_secs() < 0.3 * budget.secs.min(20.0) {
                return;
            }
            self.farm.start();
            for _ in 0..self.rng.random_range(0..4) {
                self.does_something();
            }
            let most_ms = if self.rng.random_bool(0.5) { 120 } else { 1200 };
            std::thread::sleep(Duration::from_millis(self.rng.random_range(2..most_ms)));
            self.farm.kill();
            all.fetch_add(1, Ordering::Relaxed);
            self.history.push("kill".to_owned());
            if self.rng.random_bool(0.3) {
                self.prints();
            }
            if self.rng.random_bool(0.15) {
                self.restores();
            }
        }
    }

    fn does_something(&mut self) {
        match self.rng.random_range(0..16) {
            0..=5 => self.drops(),
            6 => self.drops_a_list(),
            7 => self.cancels(),
            8 => self.retries(),
            9 => self.tells(&["flush", PROFILE]),
            10 => self.tells(&["pause", PROFILE]),
            11 => self.tells(&["resume", PROFILE]),
            12 => self.tells_an_outcome(),
            13 => {
                let profile = format!("{MACHINE}# {}\n", self.dropped);
                self.farm.write_profile(PROFILE, &profile);
                self.farm.reload();
            }
            14 => self.prints(),
            _ => self.backs_up(),
        }
    }

    /// A command that nobody waits for longer than it takes to note it.
    fn tells(&mut self, args: &[&str]) {
        self.history.push(args.join(" "));
        let _ = self.farm.nestd(args);
    }

    /// A content: new, the same again, or one that cannot be read.
    fn content(&mut self) -> (Vec<u8>, bool) {
        if !self.contents.is_empty() && self.rng.random_bool(0.2) {
            let again = self.rng.random_range(0..self.contents.len());
            return (self.contents[again].clone(), false);
        }
        let is_bad = self.rng.random_bool(0.1);
        let (n, size) = (self.dropped as f64, self.rng.random_range(5..25));
        let bytes = match is_bad {
            true => format!("solid nonsense {n}\nendsolid\n").into_bytes(),
            false => stl(&block(12.0, 9.0 + n * 0.01, f64::from(size))),
        };
        if !is_bad {
            self.contents.push(bytes.clone());
        }
        (bytes, is_bad)
    }

    fn asks(&mut self, bytes: &[u8], name: &str, copies: u32, is_bad: bool) {
        let asked = self.asked.entry(hash(bytes)).or_default();
        asked.copies += copies;
        asked.is_bad = is_bad;
        asked.names.insert(name.to_owned());
        self.dropped += 1;
    }

    /// A part, sometimes in an order folder, sometimes with a ticket.
    fn drops(&mut self) {
        let (bytes, is_bad) = self.content();
        let (n, mut copies) = (self.dropped, self.rng.random_range(1..4));
        let folder = if self.rng.random_bool(0.2) { format!("order-{n}/") } else { String::new() };
        let name = if copies > 1 { format!("part{n}_x{copies}.stl") } else { format!("part{n}.stl") };
        if self.rng.random_bool(0.2) {
            copies = self.rng.random_range(1..4);
            self.farm.drop_bytes(&format!("{folder}{name}.toml"), format!("copies = {copies}\n").as_bytes());
        }
        self.asks(&bytes, &name, copies, is_bad);
        self.farm.drop_bytes(&format!("{folder}{name}"), &bytes);
        self.history.push(format!("drop {folder}{name} ({copies})"));
    }

    /// An order folder with its list, which is there first.
    fn drops_a_list(&mut self) {
        let order = format!("list-{}", self.dropped);
        let (mut list, mut files) = ("file,copies\n".to_owned(), Vec::new());
        for _ in 0..self.rng.random_range(1..4) {
            let (bytes, is_bad) = self.content();
            let (name, copies) = (format!("part{}.stl", self.dropped), self.rng.random_range(1..5));
            list += &format!("{name},{copies}\n");
            self.asks(&bytes, &name, copies, is_bad);
            files.push((name, bytes));
        }
        self.farm.drop_bytes(&format!("{order}/order.csv"), list.as_bytes());
        files.iter().for_each(|(name, bytes)| self.farm.drop_bytes(&format!("{order}/{name}"), bytes));
        self.history.push(format!("drop {order}: {list:?}"));
    }

    /// Parts in a state, to give orders about; what they are is known by content.
    fn parts(&self, state: PartState) -> Vec<PartRow> {
        let began = Instant::now();
        while !self.farm.root().join("state/nestd.db").exists() {
            if began.elapsed().as_secs() > 5 {
                return Vec::new();
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        self.farm.ask(async |ledger| ledger.parts_in_state(state).await.unwrap_or_default())
    }

    fn one_of(&mut self, state: PartState) -> Option<PartRow> {
        let mut parts = self.parts(state);
        (!parts.is_empty()).then(|| parts.swap_remove(self.rng.random_range(0..parts.len())))
    }

    fn cancels(&mut self) {
        let Some(part) = self.one_of(PartState::Waiting) else { return };
        if let Some(asked) = self.asked.get_mut(&part.file.content_hash) {
            asked.cancelled += part.copies;
        }
        self.tells(&["cancel", &part.id.to_string()]);
    }

    fn retries(&mut self) {
        let Some(part) = self.one_of(PartState::Rejected) else { return };
        self.tells(&["retry", &part.id.to_string()]);
    }

    fn tells_an_outcome(&mut self) {
        let outcome = ["complete", "interrupted", "failed"][self.rng.random_range(0..3)];
        let build = self.rng.random_range(1..=self.taken.len().max(1)).to_string();
        self.tells(&["outcome", &build, outcome]);
    }

    fn backs_up(&mut self) {
        let file = self.farm.root().join(format!("backup-{}", self.history.len()));
        if self.farm.nestd(&["backup", file.to_str().unwrap()]).status.success() {
            self.history.push(format!("backup {}", file.display()));
            self.backups.push(file);
        }
    }

    /// Puts back a backup; the daemon does not run. What a person is told to look at is kept, and is a person's from then on.
    fn restores(&mut self) {
        if self.backups.is_empty() {
            return;
        }
        let backup = self.backups[self.rng.random_range(0..self.backups.len())].clone();
        let output = self.farm.nestd(&["restore", backup.to_str().unwrap()]);
        let said = text(&output);
        self.history.push(format!("restore {}: {said}", backup.display()));
        if !output.status.success() {
            self.broken.push(format!("restoring failed: {said}"));
        }
        self.doubts += &said.lines().filter(|line| line.contains("LOOK AT")).collect::<Vec<_>>().join("\n");
        self.doubts += "\n";
    }

    /// Takes files from the queue as a printer does, and counts what is in them.
    fn prints(&mut self) {
        for file in self.farm.queued() {
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            match build_file::read_build(&file, &build_file::Limits::default()) {
                Ok(placed) => placed.into_iter().for_each(|copy| {
                    *self.printed.entry(copy.source_hash.unwrap_or_default()).or_default() += 1;
                }),
                Err(error) => self.broken.push(format!("I3: {name} is visible and cannot be read: {error}")),
            }
            fs::remove_file(&file).unwrap();
            if !self.taken.insert(name.clone()) {
                self.broken.push(format!("I3: {name} appeared again after the printer had taken it"));
            }
            self.history.push(format!("print {name}"));
        }
    }

    /// Nobody kills any more; then what was asked and what was printed are held against each other.
    fn settles(mut self) -> Row {
        self.farm.start();
        self.tells(&["resume", PROFILE]);
        let (began, mut quiet) = (Instant::now(), 0);
        while quiet < 3 {
            std::thread::sleep(Duration::from_millis(400));
            quiet = if self.is_at_rest() { quiet + 1 } else { 0 };
            if began.elapsed() > Duration::from_secs(REST_SECS) {
                let (log, state) = (self.farm.log(), self.farm.nestd(&["status", "--parts"]));
                let lines: Vec<&str> = log.lines().collect();
                let tail = lines[lines.len().saturating_sub(12)..].join("\n");
                self.broken.push(format!("the farm does not come to rest\n{}\n{tail}", text(&state)));
                break;
            }
        }
        self.farm.kill();
        self.prints();
        self.compares();
        let (seed, story) = (self.seed, self.history.join("\n  "));
        if !self.broken.is_empty() {
            self.broken.push(format!("the story was\n  {story}"));
        }
        Row {
            files: self.dropped,
            builds: self.taken.len() as u64,
            broken: self.broken.iter().map(|text| format!("NESTD_SEED={seed}: {text}")).collect(),
            ..Row::default()
        }
    }

    /// Whether all that was dropped is taken, and nothing waits to be read, nested or published.
    fn is_at_rest(&mut self) -> bool {
        self.prints();
        let inbox = self.farm.folder("inbox");
        let is_part = |file: &PathBuf| file.extension().is_some_and(|extension| extension == "stl");
        let is_empty = !nestd::intake::files_below(&inbox).unwrap_or_default().iter().any(is_part);
        let waiting = self.parts(PartState::Waiting).len();
        if waiting > 0 {
            let _ = self.farm.nestd(&["flush", PROFILE]);
        }
        let under_way = self.parts(PartState::Claimed).len() + self.parts(PartState::Batched).len();
        is_empty && waiting + under_way == 0
    }

    fn compares(&mut self) {
        let error = nestd::intake::files_below(&self.farm.folder("error")).unwrap_or_default();
        let refused: BTreeSet<String> =
            error.iter().filter_map(|file| Some(hash(&fs::read(file).ok()?))).collect::<BTreeSet<_>>();
        for (content, asked) in &self.asked {
            let printed = self.printed.remove(content).unwrap_or_default();
            let about = format!("{content} ({:?})", asked.names);
            if printed > asked.copies || (asked.is_bad && printed > 0) {
                self.broken.push(format!("DOUBLED: {about}: {printed} copies printed, {} asked", asked.copies));
            }
            let missing = asked.copies.saturating_sub(printed);
            let is_named = refused.contains(content)
                || self.doubts.contains(content.as_str())
                || asked.names.iter().any(|name| self.doubts.contains(name.as_str()));
            if missing > 0 && !is_named && missing > asked.cancelled {
                self.broken.push(format!(
                    "LOST: {about}: {printed} copies printed, {} asked, {} cancelled, and nobody was told",
                    asked.copies, asked.cancelled
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
