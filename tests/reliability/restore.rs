//! A ledger put back: `nestd restore` and `check --deep --repair` killed after each call that changes a file, after each
//! action that may have followed the backup, with each folder away in turn. Then the daemon is started at once, or the command
//! is given again to its end; what comes out is counted in the build files by content. Each dropped content is printed as often
//! as it was asked for, or a person is told of it; nothing is doubled; with a folder away the ledger stays as it was.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use nestd::ledger::PartState;
use rand::{SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use solids::Mesh;

use super::{
    budget::Budget,
    crash::KillAfter,
    life,
    pool::{caught, in_parallel, seed, spread},
    row::Row,
    support::{PROFILE, TestFarm, block, stl},
    trace::{Traced, is_allowed},
};

/// A short run takes so long at least: a farm has to live before its ledger can be put back.
const SHORT_SECS: f64 = 12.0;
/// A farm comes to rest within this.
const REST: Duration = Duration::from_secs(120);
const MACHINE: &str = "volume_mm = [120, 120, 120]\nclearance_mm = 2.0\nsettle_secs = 0.05\nunfinished_secs = 0.5\n\
    final_secs = 0.1\narrival_secs = 0.1\nduplicates = \"accept\"\nmax_attempts = 20\n";

/// What happened after the backup was made.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Later {
    Drop,
    SameAgain,
    Cancel,
    Retry,
    Publish,
    Print,
    Outcome,
}

const LATER: [Later; 7] =
    [Later::Drop, Later::SameAgain, Later::Cancel, Later::Retry, Later::Publish, Later::Print, Later::Outcome];

/// How the ledger is put back.
#[derive(Debug, Clone, Copy, PartialEq)]
enum How {
    /// `nestd restore BACKUP`.
    Restore,
    /// The backup is copied over the ledger by hand, then `nestd check --deep --repair`.
    Repair,
}

/// A folder that is away, and whether an empty directory stands in its place.
type Away = Option<(&'static str, bool)>;

pub fn run(budget: &Budget) -> Row {
    if !is_allowed() {
        return Row { note: "SKIPPED: processes may not be traced here".to_owned(), ..Row::default() };
    }
    let seed = seed();
    let budget = &budget.at_least(SHORT_SECS);
    let mut cases: Vec<(Later, How)> = LATER.iter().flat_map(|&l| [(l, How::Restore), (l, How::Repair)]).collect();
    cases.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let all = cases.len();
    let rows = in_parallel(cases, budget, |(later, how)| {
        caught(&format!("{how:?} after {later:?}"), || Farm::prepared(later, how).play(budget, seed))
    });
    Row {
        note: format!(
            "killed while it was put back, with folders away; {} of {all} stories; NESTD_SEED={seed}",
            rows.len()
        ),
        ..Row::sum(&rows)
    }
}

/// A farm that has stopped, after a backup and what came later.
struct Farm {
    farm: TestFarm,
    later: Later,
    how: How,
    backup: PathBuf,
    /// Copies that were asked for, by content.
    asked: BTreeMap<String, u32>,
    /// The names of each content.
    names: BTreeMap<String, Vec<String>>,
    /// Copies that the printer has taken before, by content.
    printed: BTreeMap<String, u32>,
    /// All files as they were when it had stopped.
    files: BTreeMap<PathBuf, Option<(Vec<u8>, fs::Permissions)>>,
}

impl Farm {
    fn prepared(later: Later, how: How) -> Self {
        let farm = TestFarm::new(MACHINE);
        fs::write(farm.config(), life::FARM).unwrap();
        let backup = farm.root().join("ledger.backup");
        let (asked, names, printed, files) = Default::default();
        let mut story = Self { farm, later, how, backup, asked, names, printed, files };
        story.farm.start();
        story.drops("a_x2.stl", 2, &block(20.0, 20.0, 20.0));
        story.farm.wait_for_parts(PartState::Waiting, 1);
        story.drops("refused.stl", 1, &block(15.0, 20.0, 20.0));
        let parts = story.farm.wait_for_parts(PartState::Waiting, 2);
        let id = |name: &str| parts.iter().find(|part| part.name == name).unwrap().id.to_string();
        story.farm.nestd_ok(&["cancel", &id("refused.stl")]);
        story.farm.wait_for_parts(PartState::Rejected, 1);
        story.farm.nestd_ok(&["backup", story.backup.to_str().unwrap()]);
        story.happens(&id("a_x2.stl"), &id("refused.stl"));
        story.farm.stop();
        if how == How::Repair {
            let ledger = story.farm.root().join("state/nestd.db");
            for suffix in ["-wal", "-shm", ".b3"] {
                let _ = fs::remove_file(format!("{}{suffix}", ledger.display()));
            }
            fs::copy(&story.backup, ledger).unwrap();
        }
        story.files = tree(story.farm.root());
        story
    }

    fn drops(&mut self, name: &str, copies: u32, mesh: &Mesh) {
        let content = hash(&stl(mesh));
        self.names.entry(content.clone()).or_default().push(name.to_owned());
        *self.asked.entry(content).or_default() += copies;
        self.farm.drop_part(name, mesh);
    }

    fn happens(&mut self, waiting: &str, refused: &str) {
        match self.later {
            Later::Drop => {
                self.drops("b_x3.stl", 3, &block(21.0, 20.0, 20.0));
                self.farm.wait_for_parts(PartState::Waiting, 2);
            }
            Later::SameAgain => {
                self.drops("again_x3.stl", 3, &block(20.0, 20.0, 20.0));
                self.farm.wait_for_parts(PartState::Waiting, 2);
            }
            Later::Cancel => {
                self.farm.nestd_ok(&["cancel", waiting]);
                self.farm.wait_for_parts(PartState::Rejected, 2);
            }
            Later::Retry => {
                self.farm.nestd_ok(&["retry", refused]);
                self.farm.wait_for_parts(PartState::Waiting, 2);
            }
            Later::Publish | Later::Print | Later::Outcome => {
                self.farm.flush();
                self.farm.wait_for_parts(PartState::Built, 1);
                if self.later == Later::Outcome {
                    self.farm.nestd_ok(&["outcome", "1", "failed"]);
                }
                if self.later != Later::Publish {
                    self.printed = self.in_queue();
                    self.farm.queued().iter().for_each(|file| fs::remove_file(file).unwrap());
                }
            }
        }
    }

    /// Copies in the build files of the queue, by content.
    fn in_queue(&self) -> BTreeMap<String, u32> {
        let mut copies = BTreeMap::new();
        for placed in self.farm.queued().iter().flat_map(|f| build_file::read_build(f, &Default::default()).unwrap()) {
            *copies.entry(placed.source_hash.unwrap_or_default()).or_default() += 1;
        }
        copies
    }

    fn args(&self) -> Vec<&str> {
        match self.how {
            How::Restore => vec!["restore", self.backup.to_str().unwrap()],
            How::Repair => vec!["check", "--deep", "--repair"],
        }
    }

    fn play(mut self, budget: &Budget, seed: u64) -> Row {
        let mut row = Row { files: self.asked.len() as u64, ..Row::default() };
        let mut all: Vec<Away> = ["archive", "error", "queue", "inbox"]
            .into_iter()
            .flat_map(|folder| [Some((folder, false)), Some((folder, true))])
            .collect();
        all.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        for away in all.into_iter().take(budget.pick(2, 8)) {
            row.broken.extend(self.is_refused(away));
            row.points += 1;
        }
        let changes = self.killed_after(u64::MAX, &mut row);
        if budget.is_long {
            self.goes_on(u64::MAX, &mut row);
        }
        let mut points = spread(changes);
        if !budget.is_long {
            points.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        }
        for point in points {
            if budget.is_spent() {
                break;
            }
            self.killed_after(point, &mut row);
            self.goes_on(point, &mut row);
            row.faults += 1;
        }
        row.points += row.faults + 1;
        row
    }

    /// With a folder away the ledger is not put back, and nothing changes.
    fn is_refused(&self, away: Away) -> Option<String> {
        let (folder, is_empty) = away?;
        self.as_it_was();
        let (folder, aside) = (self.farm.folder(folder), self.farm.root().join("aside"));
        fs::rename(&folder, &aside).unwrap();
        if is_empty {
            fs::create_dir(&folder).unwrap();
        }
        let ledger = self.farm.root().join("state/nestd.db");
        let before = fs::read(&ledger).unwrap();
        let output = self.farm.nestd(&self.args());
        let is_same = fs::read(&ledger).unwrap() == before;
        if is_empty {
            fs::remove_dir_all(&folder).unwrap();
        }
        fs::rename(&aside, &folder).unwrap();
        (output.status.success() || !is_same).then(|| {
            format!(
                "{:?} after {:?} with {} away (empty: {is_empty}): exit {}, ledger as before: {is_same}\n{}",
                self.how,
                self.later,
                folder.display(),
                output.status,
                text(&output)
            )
        })
    }

    /// Puts the ledger back and kills that after so many changes; how many there were.
    fn killed_after(&self, point: u64, row: &mut Row) -> u64 {
        self.as_it_was();
        let watch = KillAfter::new(self.farm.root(), point);
        let mut traced = Traced::start(self.farm.command(&self.args()), self.farm.root(), watch).unwrap();
        let began = Instant::now();
        while !traced.has_ended() && began.elapsed() < REST {
            std::thread::sleep(Duration::from_millis(5));
        }
        let watch = traced.kill();
        let about = format!("{:?} after {:?}, killed after change {point}", self.how, self.later);
        row.broken.extend(watch.foreign().into_iter().map(|text| format!("{about}: {text}")));
        watch.changes()
    }

    /// The daemon is started at once or the command is given again; then the farm does its work.
    fn goes_on(&mut self, point: u64, row: &mut Row) {
        let mut said = String::new();
        let mut starts = point.is_multiple_of(2) && self.starts();
        if !starts {
            said = text(&self.farm.nestd(&self.args()));
            starts = self.starts();
        }
        let about = format!("{:?} after {:?}, killed after change {point}", self.how, self.later);
        if !starts {
            row.broken.push(format!("{about}: the daemon does not start\n{said}\n{}", self.farm.log()));
            return;
        }
        if !self.comes_to_rest() {
            row.broken.push(format!("{about}: the farm does not come to rest\n{said}\n{}", self.farm.log()));
        }
        let mut told: String = said.lines().filter(|line| line.contains("LOOK AT")).collect();
        told += &fs::read_to_string(self.farm.root().join("state/attention.json")).unwrap_or_default();
        self.farm.stop();
        row.builds += self.farm.queued().len() as u64;
        row.broken.extend(self.judged(&told).map(|text| format!("{about}: {text}\n{said}\n{}", self.farm.log())));
    }

    /// Whether the daemon serves the farm as it is.
    fn starts(&mut self) -> bool {
        let _ = fs::remove_file(self.farm.root().join("log"));
        self.farm.start();
        let began = Instant::now();
        while began.elapsed() < REST {
            if self.farm.has_ended() {
                self.farm.kill();
                return false;
            }
            if self.farm.log().contains("The farm is open.") {
                return true;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        false
    }

    fn comes_to_rest(&self) -> bool {
        let (began, mut quiet) = (Instant::now(), 0);
        while quiet < 2 && began.elapsed() < REST {
            let parts = |state| self.farm.parts(state);
            let waiting: Vec<_> =
                parts(PartState::Waiting).into_iter().filter(|p| p.times.damaged_at.is_none()).collect();
            if !waiting.is_empty() {
                let _ = self.farm.nestd(&["flush", PROFILE]);
            }
            let under_way = waiting.len() + parts(PartState::Claimed).len() + parts(PartState::Batched).len();
            quiet = if under_way == 0 { quiet + 1 } else { 0 };
            std::thread::sleep(Duration::from_millis(200));
        }
        quiet >= 2
    }

    /// What is wrong in the end.
    fn judged(&self, told: &str) -> Option<String> {
        let in_queue = self.in_queue();
        let below = |folder: &Path| nestd::intake::files_below(folder).unwrap_or_default();
        let mut kept = below(&self.farm.folder("error"));
        kept.extend(below(&self.farm.root().join("state/unknown")));
        let kept: BTreeSet<String> = kept.iter().map(|file| hash(&fs::read(file).unwrap())).collect();
        for (content, &asked) in &self.asked {
            let copies = |of: &BTreeMap<String, u32>| of.get(content).copied().unwrap_or_default();
            let printed = copies(&in_queue) + copies(&self.printed);
            if printed > asked {
                return Some(format!("DOUBLED: {content}: {printed} of {asked} copies are printed"));
            }
            let is_told = told.contains(content.as_str()) || self.names[content].iter().any(|name| told.contains(name));
            if printed < asked && !kept.contains(content) && !is_told {
                return Some(format!("LOST: {content}: {printed} of {asked} copies are printed, and nobody is told"));
            }
        }
        None
    }

    /// Puts all files as they were when the farm had stopped; folders stay the same folders.
    fn as_it_was(&self) {
        let root = self.farm.root();
        for (path, was) in tree(root).into_iter().rev() {
            match self.files.get(&path) {
                Some(same) if *same == was => {}
                Some(None) => {}
                _ if was.is_some() => fs::remove_file(root.join(path)).unwrap(),
                _ => fs::remove_dir(root.join(path)).unwrap(),
            }
        }
        for (path, was) in &self.files {
            let path = root.join(path);
            match was {
                None => fs::create_dir_all(path).unwrap(),
                Some(_) if path.exists() => {}
                Some((bytes, mode)) => {
                    fs::write(&path, bytes).unwrap();
                    fs::set_permissions(&path, mode.clone()).unwrap();
                }
            }
        }
    }
}

/// All files and folders below a folder; `None` = a folder.
fn tree(root: &Path) -> BTreeMap<PathBuf, Option<(Vec<u8>, fs::Permissions)>> {
    let (mut found, mut folders) = (BTreeMap::new(), vec![root.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let meta = fs::symlink_metadata(&path).unwrap();
            let name = path.strip_prefix(root).unwrap().to_owned();
            if meta.is_dir() {
                found.insert(name, None);
                folders.push(path);
            } else if meta.is_file() {
                found.insert(name, Some((fs::read(&path).unwrap(), meta.permissions())));
            }
        }
    }
    found
}

fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

fn text(output: &std::process::Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}
