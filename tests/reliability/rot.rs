//! Bytes that rot: each file that nestd owns is altered with its length kept, cut, removed or replaced, in each state of its
//! part or build; then the farm goes on. Nothing wrong is printed, nothing is printed twice, and nothing is lost in silence:
//! what is not printed is asked for, told, or named by `check --deep`.

use std::{
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use nestd::{
    farm::Witness,
    ledger::{BuildState, PartState},
};

use super::{
    budget::Budget,
    pool::{caught, in_parallel},
    row::Row,
    support::{PROFILE, QUICK, TestFarm, block, stl, wait_until_or},
};

/// A short run takes so long at most.
const SHORT_SECS: f64 = 20.0;
/// Volumes of what is dropped, mm3, each twice.
const DROPPED: [u64; 4] = [2400, 2400, 3000, 3000];
/// A case that takes longer is stuck.
const CASE: Duration = Duration::from_secs(40);

/// When it happens.
#[derive(Debug, Clone, Copy, PartialEq)]
enum When {
    Waiting,
    Staged,
    Published,
}

/// What is done to a file.
#[derive(Debug, Clone, Copy)]
enum How {
    Altered,
    Cut,
    Removed,
    Replaced,
}

/// The files that nestd owns, by when they are there; the first that matches is spoilt.
const OWNED: [(When, &str); 14] = [
    (When::Waiting, "state/store/"),
    (When::Waiting, "state/nestd.db.b3"),
    (When::Waiting, "state/attention.json"),
    (When::Waiting, "state/cache/"),
    (When::Waiting, "inbox/test/STATUS.txt"),
    (When::Waiting, "inbox/test/.nestd-owner"),
    (When::Waiting, "queue/test/.nestd-queue"),
    (When::Staged, ".build.3mf.part"),
    (When::Staged, ".parts.csv.part"),
    (When::Staged, ".report.json.part"),
    (When::Staged, "state/store/"),
    (When::Published, ".build.3mf"),
    (When::Published, ".stl"),
    (When::Published, ".nestd-build.json"),
];

pub fn run(budget: &Budget) -> Row {
    let budget = &budget.at_least(SHORT_SECS);
    let hows = [How::Altered, How::Cut, How::Removed, How::Replaced];
    let cases: Vec<(When, &str, How)> =
        hows.iter().flat_map(|&how| OWNED.iter().map(move |&(when, what)| (when, what, how))).collect();
    let rows = in_parallel(cases, budget, |(when, what, how)| {
        caught(&format!("{what} {how:?} when {when:?}"), || Rot { when, what, how }.play())
    });
    let sum = Row::sum(&rows);
    Row {
        faults: sum.points,
        files: 2 * sum.points,
        note: "owned files altered, cut, removed, replaced".to_owned(),
        ..sum
    }
}

/// One case.
struct Rot {
    when: When,
    what: &'static str,
    how: How,
}

impl Rot {
    fn play(&self) -> Row {
        let mut farm = TestFarm::running(&QUICK.replace("final_secs = 0.5", "final_secs = 1"));
        farm.drop_part("ring_x2.stl", &block(20.0, 15.0, 10.0));
        farm.drop_part("plate_x2.stl", &block(30.0, 20.0, 4.0));
        farm.wait_for_parts(PartState::Waiting, 2);
        let blocked = (self.when != When::Waiting).then(|| self.bring_on(&farm)).flatten();
        farm.stop();
        let Some(file) = self.find(&farm) else { return Row::default() };
        self.spoil(&file);
        blocked.iter().for_each(|folder| fs::remove_dir(folder).unwrap());
        farm.start();
        let told = go_on(&mut farm);
        if farm.has_ended() {
            // A ledger or its seal that is not as it was left: nothing is done with it, and the remedy is told.
            let said = farm.log();
            let is_refused = self.what.starts_with("state/nestd.db") && said.contains("nestd restore FILE");
            let broken = (!is_refused).then(|| format!("{} {:?}: the daemon ended: {said}", self.what, self.how));
            return Row { points: 1, broken: broken.into_iter().collect(), ..Row::default() };
        }
        farm.stop();
        let broken =
            self.judge(&farm, told).map(|text| format!("{} {:?} when {:?}: {text}", self.what, self.how, self.when));
        Row { points: 1, builds: farm.queued().len() as u64, broken: broken.into_iter().collect(), ..Row::default() }
    }

    /// Publishes, or has a build proved whose publishing is held up: a folder stands in the place of its record.
    fn bring_on(&self, farm: &TestFarm) -> Option<PathBuf> {
        farm.flush();
        if self.when == When::Published {
            farm.wait_for_queued(1);
            farm.wait_for_parts(PartState::Built, 2);
            return None;
        }
        let in_state = |state| farm.ask(async |ledger| ledger.builds_in_state(state).await.unwrap()).pop();
        wait_until_or("a build is nested", 30.0, || farm.log(), || in_state(BuildState::Nesting).is_some());
        let build = in_state(BuildState::Nesting)?;
        let name = build_file::build_file_name(build.times.nesting_at?.0, PROFILE, build.id.0.unsigned_abs());
        let record = farm.folder("archive").join(name.strip_suffix(".build.3mf")?).join(".nestd-build.json");
        fs::create_dir_all(&record).unwrap();
        wait_until_or("it is proved", 30.0, || farm.log(), || in_state(BuildState::Verified).is_some());
        Some(record)
    }

    fn find(&self, farm: &TestFarm) -> Option<PathBuf> {
        let below: &[&str] = match self.when {
            When::Waiting => &["state", "inbox", "queue"],
            When::Staged => &["state", "queue"],
            When::Published => &["archive", "queue"],
        };
        let files = below.iter().flat_map(|folder| nestd::intake::files_below(&farm.root().join(folder)).unwrap());
        let matches = |file: &PathBuf| {
            let path = file.strip_prefix(farm.root()).unwrap().to_string_lossy().into_owned();
            path.starts_with(self.what) || path.ends_with(self.what)
        };
        files.into_iter().find(matches)
    }

    fn spoil(&self, file: &Path) {
        let mut bytes = fs::read(file).unwrap();
        let half = bytes.len() / 2;
        match self.how {
            How::Altered => {
                if let Some(byte) = bytes.get_mut(half) {
                    *byte ^= 1;
                }
                fs::write(file, bytes).unwrap();
            }
            How::Cut => fs::write(file, &bytes[..half]).unwrap(),
            How::Removed => fs::remove_file(file).unwrap(),
            How::Replaced => fs::write(file, stl(&block(20.0, 15.0, 12.0))).unwrap(),
        }
    }

    /// What is wrong in the end.
    fn judge(&self, farm: &TestFarm, told: bool) -> Option<String> {
        let named = farm.broken(&Witness::default());
        let mut printed = Vec::new();
        for file in farm.queued() {
            match build_file::read_build(&file, &Default::default()) {
                Ok(placed) => printed.extend(placed.iter().map(|item| item.mesh.volume_mm3().round() as u64)),
                // The printer's own copy was spoilt after it was published.
                Err(_) if self.when == When::Published && !named.is_empty() => return None,
                Err(error) => return Some(format!("{} is visible and cannot be read: {error}", file.display())),
            }
        }
        printed.sort_unstable();
        if printed.iter().any(|volume| !DROPPED.contains(volume)) {
            return Some(format!("something else is printed: {printed:?}"));
        }
        if printed.len() > DROPPED.len() {
            return Some(format!("something is printed twice: {printed:?}"));
        }
        if printed != DROPPED && !told && named.is_empty() {
            return Some(format!("only {printed:?} is printed, and nobody is told\n{}", farm.log()));
        }
        // What heals leaves nothing behind; what people must see to is named.
        let is_printers = self.when == When::Published;
        (!named.is_empty() && !told && !is_printers).then(|| format!("it was not healed: {named:?}"))
    }
}

/// Goes on as people would: what is asked for is dropped again, what waits is published. Returns whether a person was told
/// of something that stands to the end.
fn go_on(farm: &mut TestFarm) -> bool {
    let began = Instant::now();
    let mut again = vec![("ring", block(20.0, 15.0, 10.0)), ("plate", block(30.0, 20.0, 4.0))];
    let notices = farm.root().join("state/attention.json");
    let told = || fs::read_to_string(&notices).unwrap_or_default();
    std::thread::sleep(Duration::from_secs(2));
    while began.elapsed() < CASE && !farm.has_ended() {
        let now = told();
        again.retain(|(name, mesh)| {
            let is_asked = now.contains("file-damaged") && now.contains(&format!("{name}_x2.stl"));
            if is_asked {
                farm.drop_part(&format!("{name} again.stl"), mesh);
            }
            !is_asked
        });
        let waits = farm.parts(PartState::Waiting).iter().any(|part| part.times.damaged_at.is_none());
        if waits {
            let _ = farm.nestd(&["flush", PROFILE]);
        }
        if farm.parts(PartState::Built).len() >= 2 && !waits {
            break;
        }
        std::thread::sleep(Duration::from_millis(300));
    }
    told().contains("\"kind\"")
}
