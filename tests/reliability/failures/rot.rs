//! Damaged files: each file that nestd owns is changed without a change of length, cut, removed or replaced, in each
//! state of its part or build; then the farm continues. Nothing damaged is printed, nothing is printed twice, and
//! nothing is lost silently: a part that is not printed is requested again, reported, or named by `check --deep`.

use std::{
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use farm::InvariantExpectations;
use ledger::{BuildState, PartState};

use crate::{
    harness::{SectionBudget, SectionResult, catch_panic, in_parallel},
    support::{MACHINE, QUICK, TestFarm, block, stl, wait_until_or},
};

/// Time budget of a short run, seconds.
const SHORT_SECS: f64 = 20.0;
/// Volumes of the dropped parts, mm3, each twice.
const DROPPED: [u64; 4] = [2400, 2400, 3000, 3000];
/// A case that takes longer than this is stuck.
const CASE: Duration = Duration::from_secs(40);

/// The moment of the damage.
#[derive(Debug, Clone, Copy, PartialEq)]
enum DamageMoment {
    Waiting,
    Staged,
    Published,
}

/// The kind of damage.
#[derive(Debug, Clone, Copy)]
enum DamageKind {
    Altered,
    Cut,
    Removed,
    Replaced,
}

/// The files that nestd owns, by the moment at which they exist; the first match is damaged.
const OWNED: [(DamageMoment, &str); 14] = [
    (DamageMoment::Waiting, "state/store/"),
    (DamageMoment::Waiting, "state/nestd.db.b3"),
    (DamageMoment::Waiting, "state/attention.json"),
    (DamageMoment::Waiting, "state/cache/"),
    (DamageMoment::Waiting, "inbox/test/STATUS.txt"),
    (DamageMoment::Waiting, "inbox/test/.nestd-owner"),
    (DamageMoment::Waiting, "queue/test/.nestd-queue"),
    (DamageMoment::Staged, ".build.3mf.part"),
    (DamageMoment::Staged, ".parts.csv.part"),
    (DamageMoment::Staged, ".report.json.part"),
    (DamageMoment::Staged, "state/store/"),
    (DamageMoment::Published, ".build.3mf"),
    (DamageMoment::Published, ".stl"),
    (DamageMoment::Published, ".nestd-build.json"),
];

pub fn run(budget: &SectionBudget) -> SectionResult {
    let budget = &budget.at_least(SHORT_SECS);
    let hows = [DamageKind::Altered, DamageKind::Cut, DamageKind::Removed, DamageKind::Replaced];
    let cases: Vec<(DamageMoment, &str, DamageKind)> =
        hows.iter().flat_map(|&how| OWNED.iter().map(move |&(when, what)| (when, what, how))).collect();
    let rows = in_parallel(cases, budget, |(when, what, how)| {
        catch_panic(&format!("{what} {how:?} when {when:?}"), || DamageCase { when, what, how }.play())
    });
    let sum = SectionResult::sum(&rows);
    SectionResult {
        faults: sum.points,
        files: 2 * sum.points,
        note: "owned files altered, cut, removed, replaced".to_owned(),
        ..sum
    }
}

/// One case.
struct DamageCase {
    when: DamageMoment,
    what: &'static str,
    how: DamageKind,
}

impl DamageCase {
    fn play(&self) -> SectionResult {
        let mut farm = TestFarm::running(&QUICK.replace("final_secs = 0.5", "final_secs = 1"));
        farm.drop_part("ring_x2.stl", &block(20.0, 15.0, 10.0));
        farm.drop_part("plate_x2.stl", &block(30.0, 20.0, 4.0));
        farm.wait_for_parts(PartState::Waiting, 2);
        let blocked = (self.when != DamageMoment::Waiting).then(|| self.reach_moment(&farm)).flatten();
        farm.stop();
        let Some(file) = self.find(&farm) else { return SectionResult::default() };
        self.damage_file(&file);
        blocked.iter().for_each(|folder| fs::remove_dir(folder).unwrap());
        farm.start();
        let is_reported = continue_as_people_do(&mut farm);
        if farm.has_ended() {
            // The ledger or its checksum was changed: nestd does not use it, and names the remedy.
            let log = farm.log();
            let is_refused = self.what.starts_with("state/nestd.db") && log.contains("nestd restore FILE");
            let broken = (!is_refused).then(|| format!("{} {:?}: the daemon ended: {log}", self.what, self.how));
            return SectionResult { points: 1, broken: broken.into_iter().collect(), ..SectionResult::default() };
        }
        farm.stop();
        let broken = self
            .find_faults(&farm, is_reported)
            .map(|text| format!("{} {:?} when {:?}: {text}", self.what, self.how, self.when));
        SectionResult {
            points: 1,
            builds: farm.queued().len() as u64,
            broken: broken.into_iter().collect(),
            ..SectionResult::default()
        }
    }

    /// Publishes a build, or leaves a proved build whose publishing is blocked by a folder in the place of its record.
    fn reach_moment(&self, farm: &TestFarm) -> Option<PathBuf> {
        farm.flush();
        if self.when == DamageMoment::Published {
            farm.wait_for_queued(1);
            farm.wait_for_parts(PartState::Built, 2);
            return None;
        }
        let in_state = |state| farm.query_ledger(async |ledger| ledger.builds_in_state(state).await.unwrap()).pop();
        wait_until_or("a build is nested", 30.0, || farm.log(), || in_state(BuildState::Nesting).is_some());
        let build = in_state(BuildState::Nesting)?;
        let name = build_file::build_file_name(
            build.times.nesting_at?.0,
            MACHINE,
            build.id.0.unsigned_abs(),
            Default::default(),
        );
        let record = farm.folder("archive").join(name.strip_suffix(".build.3mf")?).join(".nestd-build.json");
        fs::create_dir_all(&record).unwrap();
        wait_until_or("it is proved", 30.0, || farm.log(), || in_state(BuildState::Verified).is_some());
        Some(record)
    }

    fn find(&self, farm: &TestFarm) -> Option<PathBuf> {
        let below: &[&str] = match self.when {
            DamageMoment::Waiting => &["state", "inbox", "queue"],
            DamageMoment::Staged => &["state", "queue"],
            DamageMoment::Published => &["archive", "queue"],
        };
        let files = below.iter().flat_map(|folder| intake::files_below(&farm.root().join(folder)).unwrap());
        let matches = |file: &PathBuf| {
            let path = file.strip_prefix(farm.root()).unwrap().to_string_lossy().into_owned();
            path.starts_with(self.what) || path.ends_with(self.what)
        };
        files.into_iter().find(matches)
    }

    fn damage_file(&self, file: &Path) {
        let mut bytes = fs::read(file).unwrap();
        let half = bytes.len() / 2;
        match self.how {
            DamageKind::Altered => {
                if let Some(byte) = bytes.get_mut(half) {
                    *byte ^= 1;
                }
                fs::write(file, bytes).unwrap();
            }
            DamageKind::Cut => fs::write(file, &bytes[..half]).unwrap(),
            DamageKind::Removed => fs::remove_file(file).unwrap(),
            DamageKind::Replaced => fs::write(file, stl(&block(20.0, 15.0, 12.0))).unwrap(),
        }
    }

    /// Whether the case looks as if the printer had taken the published file, which is its business.
    fn is_taken_by_the_printer(&self) -> bool {
        matches!((self.when, self.how), (DamageMoment::Published, DamageKind::Removed)) && self.what == ".build.3mf"
    }

    /// The fault at the end, if there is one.
    fn find_faults(&self, farm: &TestFarm, is_reported: bool) -> Option<String> {
        let named = farm.broken_invariants(&InvariantExpectations::default());
        let mut printed = Vec::new();
        for file in farm.queued() {
            match build_file::read_build(&file, &Default::default()) {
                Ok(placed) => printed.extend(placed.iter().map(|item| item.mesh.volume_mm3().round() as u64)),
                // The printer's own file was damaged after it was published.
                Err(_) if self.when == DamageMoment::Published && !named.is_empty() => return None,
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
        if self.is_taken_by_the_printer() {
            return (!printed.is_empty()).then(|| format!("the printer took it, and it is printed again: {printed:?}"));
        }
        if printed != DROPPED && !is_reported && named.is_empty() {
            return Some(format!("only {printed:?} is printed, and nobody is told\n{}", farm.log()));
        }
        // A repaired file leaves nothing behind; a problem for people is named.
        let is_printers = self.when == DamageMoment::Published;
        (!named.is_empty() && !is_reported && !is_printers).then(|| format!("it was not healed: {named:?}"))
    }
}

/// Continues as people would: drops requested files again and publishes waiting parts. Returns whether a problem for a
/// person was reported until the end.
fn continue_as_people_do(farm: &mut TestFarm) -> bool {
    let began = Instant::now();
    let mut again = vec![("ring", block(20.0, 15.0, 10.0)), ("plate", block(30.0, 20.0, 4.0))];
    let notices = farm.root().join("state/attention.json");
    let is_reported = || fs::read_to_string(&notices).unwrap_or_default();
    std::thread::sleep(Duration::from_secs(2));
    while began.elapsed() < CASE && !farm.has_ended() {
        let now = is_reported();
        again.retain(|(name, mesh)| {
            let is_asked = now.contains("file-damaged") && now.contains(&format!("{name}_x2.stl"));
            if is_asked {
                farm.drop_part(&format!("{name} again.stl"), mesh);
            }
            !is_asked
        });
        let waits = farm.parts(PartState::Waiting).iter().any(|part| part.times.damaged_at.is_none());
        if waits {
            let _ = farm.nestd(&["flush", MACHINE]);
        }
        if farm.parts(PartState::Built).len() >= 2 && !waits {
            break;
        }
        std::thread::sleep(Duration::from_millis(300));
    }
    is_reported().contains("\"kind\"")
}
