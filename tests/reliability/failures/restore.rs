//! Restoring a ledger: `nestd restore` and `check --deep --repair` are killed after each system call that changes a
//! file, for each action that may have followed the backup, and are run with each folder missing in turn. Then the
//! daemon is started at once, or the command is run again to its end. The printed copies are counted by content in the
//! build files: each dropped content is printed with its copies, or reported to a person; nothing is printed twice;
//! with a missing folder the ledger does not change.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use ledger::PartState;
use rand::{SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use solids::Mesh;

use super::crash::KillAfterChanges;
use crate::{
    harness::{SectionBudget, SectionResult, catch_panic, in_parallel, life_cycle, seed, spread_order},
    support::{
        MACHINE, TestFarm, block, stl,
        trace::{TracedDaemon, is_allowed},
    },
};

/// Time budget of a short run, seconds: a farm must work before its ledger can be restored.
const SHORT_SECS: f64 = 12.0;
/// Time limit for a farm to come to rest.
const REST: Duration = Duration::from_secs(120);
const PROFILE: &str = "volume_mm = [120, 120, 120]\nclearance_mm = 2.0\nsettle_secs = 0.05\nunfinished_secs = 0.5\n\
    final_secs = 0.1\narrival_secs = 0.1\nduplicates = \"accept\"\nmax_attempts = 20\n";

/// What happened after the backup was made.
#[derive(Debug, Clone, Copy, PartialEq)]
enum LaterAction {
    Drop,
    SameAgain,
    Cancel,
    Retry,
    Publish,
    Print,
    Outcome,
}

const LATER: [LaterAction; 7] = [
    LaterAction::Drop,
    LaterAction::SameAgain,
    LaterAction::Cancel,
    LaterAction::Retry,
    LaterAction::Publish,
    LaterAction::Print,
    LaterAction::Outcome,
];

/// The method of restoring the ledger.
#[derive(Debug, Clone, Copy, PartialEq)]
enum RestoreMethod {
    /// `nestd restore BACKUP`.
    Restore,
    /// The backup is copied over the ledger by hand, then `nestd check --deep --repair`.
    Repair,
}

/// A missing folder, and whether an empty directory is in its place.
type MissingFolder = Option<(&'static str, bool)>;

pub fn run(budget: &SectionBudget) -> SectionResult {
    if !is_allowed() {
        return SectionResult {
            note: "SKIPPED: processes may not be traced here".to_owned(),
            ..SectionResult::default()
        };
    }
    let seed = seed();
    let budget = &budget.at_least(SHORT_SECS);
    let mut cases: Vec<(LaterAction, RestoreMethod)> =
        LATER.iter().flat_map(|&l| [(l, RestoreMethod::Restore), (l, RestoreMethod::Repair)]).collect();
    cases.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let all = cases.len();
    let rows = in_parallel(cases, budget, |(later, how)| {
        catch_panic(&format!("{how:?} after {later:?}"), || RestoredFarm::prepared(later, how).play(budget, seed))
    });
    SectionResult {
        note: format!(
            "killed while it was put back, with folders away; {} of {all} stories; NESTD_SEED={seed}",
            rows.len()
        ),
        ..SectionResult::sum(&rows)
    }
}

/// A stopped farm, after a backup and a later action.
struct RestoredFarm {
    farm: TestFarm,
    later: LaterAction,
    how: RestoreMethod,
    backup: PathBuf,
    /// Expected copies, by content.
    asked: BTreeMap<String, u32>,
    /// The names of each content.
    names: BTreeMap<String, Vec<String>>,
    /// Copies that the printer took earlier, by content.
    printed: BTreeMap<String, u32>,
    /// All files at the time of the stop.
    files: BTreeMap<PathBuf, Option<(Vec<u8>, fs::Permissions)>>,
}

impl RestoredFarm {
    fn prepared(later: LaterAction, how: RestoreMethod) -> Self {
        let farm = life_cycle::quick_farm(PROFILE);
        let backup = farm.root().join("ledger.backup");
        let (asked, names, printed, files) = Default::default();
        let mut story = Self { farm, later, how, backup, asked, names, printed, files };
        story.farm.start();
        story.drop_part("a_x2.stl", 2, &block(20.0, 20.0, 20.0));
        story.farm.wait_for_parts(PartState::Waiting, 1);
        story.drop_part("refused.stl", 1, &block(15.0, 20.0, 20.0));
        let parts = story.farm.wait_for_parts(PartState::Waiting, 2);
        let id = |name: &str| parts.iter().find(|part| part.name == name).unwrap().id.to_string();
        story.farm.nestd_ok(&["cancel", &id("refused.stl")]);
        story.farm.wait_for_parts(PartState::Refused, 1);
        story.farm.nestd_ok(&["backup", story.backup.to_str().unwrap()]);
        story.apply_later_action(&id("a_x2.stl"), &id("refused.stl"));
        story.farm.stop();
        if how == RestoreMethod::Repair {
            let ledger = story.farm.root().join("state/nestd.db");
            for suffix in ["-wal", "-shm", ".b3"] {
                let _ = fs::remove_file(format!("{}{suffix}", ledger.display()));
            }
            fs::copy(&story.backup, ledger).unwrap();
        }
        story.files = tree(story.farm.root());
        story
    }

    fn drop_part(&mut self, name: &str, copies: u32, mesh: &Mesh) {
        let content = hash(&stl(mesh));
        self.names.entry(content.clone()).or_default().push(name.to_owned());
        *self.asked.entry(content).or_default() += copies;
        self.farm.drop_part(name, mesh);
    }

    fn apply_later_action(&mut self, waiting: &str, refused: &str) {
        match self.later {
            LaterAction::Drop => {
                self.drop_part("b_x3.stl", 3, &block(21.0, 20.0, 20.0));
                self.farm.wait_for_parts(PartState::Waiting, 2);
            }
            LaterAction::SameAgain => {
                self.drop_part("again_x3.stl", 3, &block(20.0, 20.0, 20.0));
                self.farm.wait_for_parts(PartState::Waiting, 2);
            }
            LaterAction::Cancel => {
                self.farm.nestd_ok(&["cancel", waiting]);
                self.farm.wait_for_parts(PartState::Refused, 2);
            }
            LaterAction::Retry => {
                self.farm.nestd_ok(&["retry", refused]);
                self.farm.wait_for_parts(PartState::Waiting, 2);
            }
            LaterAction::Publish | LaterAction::Print | LaterAction::Outcome => {
                self.farm.flush();
                self.farm.wait_for_parts(PartState::Built, 1);
                if self.later == LaterAction::Outcome {
                    self.farm.nestd_ok(&["outcome", "1", "complete"]);
                }
                if self.later != LaterAction::Publish {
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
            RestoreMethod::Restore => vec!["restore", self.backup.to_str().unwrap()],
            RestoreMethod::Repair => vec!["check", "--deep", "--repair"],
        }
    }

    fn play(mut self, budget: &SectionBudget, seed: u64) -> SectionResult {
        let mut row = SectionResult { files: self.asked.len() as u64, ..SectionResult::default() };
        let mut all: Vec<MissingFolder> = ["archive", "error", "queue", "inbox"]
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
            self.continue_work(u64::MAX, &mut row);
        }
        let mut points = spread_order(changes);
        if !budget.is_long {
            points.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        }
        for point in points {
            if budget.is_spent() {
                break;
            }
            self.killed_after(point, &mut row);
            self.continue_work(point, &mut row);
            row.faults += 1;
        }
        row.points += row.faults + 1;
        row
    }

    /// Checks that with a missing folder the ledger is not restored and nothing changes.
    fn is_refused(&self, away: MissingFolder) -> Option<String> {
        let (folder, is_empty) = away?;
        self.reset_files();
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

    /// Restores the ledger and kills that command after `point` changes; returns the number of changes.
    fn killed_after(&self, point: u64, row: &mut SectionResult) -> u64 {
        self.reset_files();
        let watch = KillAfterChanges::new(self.farm.root(), point);
        let mut traced = TracedDaemon::start(self.farm.command(&self.args()), self.farm.root(), watch).unwrap();
        let began = Instant::now();
        while !traced.has_ended() && began.elapsed() < REST {
            std::thread::sleep(Duration::from_millis(5));
        }
        let watch = traced.kill();
        let about = format!("{:?} after {:?}, killed after change {point}", self.how, self.later);
        row.broken.extend(watch.foreign_deletions().into_iter().map(|text| format!("{about}: {text}")));
        watch.changes()
    }

    /// Starts the daemon at once, or runs the command again first; then the farm finishes its work.
    fn continue_work(&mut self, point: u64, row: &mut SectionResult) {
        let mut output_text = String::new();
        let mut starts = point.is_multiple_of(2) && self.starts();
        if !starts {
            output_text = text(&self.farm.nestd(&self.args()));
            starts = self.starts();
        }
        let about = format!("{:?} after {:?}, killed after change {point}", self.how, self.later);
        if !starts {
            row.broken.push(format!("{about}: the daemon does not start\n{output_text}\n{}", self.farm.log()));
            return;
        }
        if !self.comes_to_rest() {
            row.broken.push(format!("{about}: the farm does not come to rest\n{output_text}\n{}", self.farm.log()));
        }
        let mut reported: String = output_text.lines().filter(|line| line.contains("LOOK AT")).collect();
        reported += &fs::read_to_string(self.farm.root().join("state/attention.json")).unwrap_or_default();
        self.farm.stop();
        row.builds += self.farm.queued().len() as u64;
        row.broken.extend(
            self.find_faults(&reported).map(|text| format!("{about}: {text}\n{output_text}\n{}", self.farm.log())),
        );
    }

    /// Whether the daemon starts on the farm in its current state.
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
        let (began, mut rounds_at_rest) = (Instant::now(), 0);
        while rounds_at_rest < 2 && began.elapsed() < REST {
            let parts = |state| self.farm.parts(state);
            let waiting: Vec<_> =
                parts(PartState::Waiting).into_iter().filter(|p| p.times.damaged_at.is_none()).collect();
            if !waiting.is_empty() {
                let _ = self.farm.nestd(&["flush", MACHINE]);
            }
            let in_work = waiting.len() + parts(PartState::Claimed).len() + parts(PartState::Batched).len();
            rounds_at_rest = if in_work == 0 { rounds_at_rest + 1 } else { 0 };
            std::thread::sleep(Duration::from_millis(200));
        }
        rounds_at_rest >= 2
    }

    /// The fault at the end, if there is one.
    fn find_faults(&self, reported: &str) -> Option<String> {
        let in_queue = self.in_queue();
        let below = |folder: &Path| intake::files_below(folder).unwrap_or_default();
        let mut kept = below(&self.farm.folder("error"));
        kept.extend(below(&self.farm.root().join("state/unknown")));
        let kept: BTreeSet<String> = kept.iter().map(|file| hash(&fs::read(file).unwrap())).collect();
        for (content, &asked) in &self.asked {
            let copies = |of: &BTreeMap<String, u32>| of.get(content).copied().unwrap_or_default();
            let printed = copies(&in_queue) + copies(&self.printed);
            if printed > asked {
                return Some(format!("DOUBLED: {content}: {printed} of {asked} copies are printed"));
            }
            let is_reported =
                reported.contains(content.as_str()) || self.names[content].iter().any(|name| reported.contains(name));
            if printed < asked && !kept.contains(content) && !is_reported {
                return Some(format!("LOST: {content}: {printed} of {asked} copies are printed, and nobody is told"));
            }
        }
        None
    }

    /// Resets all files to their state at the stop; the folders themselves stay the same inodes.
    fn reset_files(&self) {
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
