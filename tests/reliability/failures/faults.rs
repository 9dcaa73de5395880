//! Every fault: each system call of the reference life-cycle on the farm's files is made to fail with each of its
//! possible errors, once and for a while; writes are cut short. The daemon must go on, must not refuse a part because
//! of the fault, and must be consistent when the fault is gone.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use nix::libc::{EACCES, EDQUOT, EINTR, EIO, ENOSPC, EROFS, ESTALE, EXDEV};
use rand::{SeedableRng, seq::SliceRandom};

use crate::{
    harness::{
        SectionBudget, SectionResult, catch_panic, in_parallel,
        life_cycle::{LifeCycle, ScriptEnd},
    },
    support::trace::{CallEffect, CallVerdict, CallWatcher, SystemCall, TracedDaemon, is_allowed},
};

/// How long a lasting fault lasts.
const LASTS: Duration = Duration::from_millis(1500);

/// A place in the life-cycle: a system call on a kind of file.
type CallSite = (&'static str, String);

/// The fault that is injected at a site.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum InjectedFault {
    Error(i32),
    Short,
}

#[derive(Debug, Clone)]
struct FaultPoint {
    site: CallSite,
    fault: InjectedFault,
    lasts: bool,
}

pub fn run(budget: &SectionBudget) -> SectionResult {
    if !is_allowed() {
        return SectionResult {
            note: "SKIPPED: processes may not be traced here".to_owned(),
            ..SectionResult::default()
        };
    }
    let sites = sites();
    let mut points = known_faults();
    points.extend(interleave(sites.iter().map(possible_faults).collect()));
    let all = points.len();
    let rows = in_parallel(points, budget, |point| catch_panic(&format!("{point:?}"), || one_life(&point)));
    SectionResult {
        points: rows.iter().filter(|row| row.faults > 0).count() as u64,
        note: format!(
            "{} of {all} faults at {} call sites; {} ended the start, as they may",
            rows.len(),
            sites.len(),
            rows.iter().filter(|row| row.note == ENDED).count()
        ),
        ..SectionResult::sum(&rows)
    }
}

/// Faults that once broke something; they are tried first, also in a short run.
fn known_faults() -> Vec<FaultPoint> {
    #[rustfmt::skip]
    let found = [
        // Parts were printed with a guessed number of copies while their ticket or list could not be read.
        ("stat", "inbox/test/ring.stl.toml", EACCES, true),
        ("stat", "inbox/test/order.csv", EACCES, true),
        // Claims stayed in the hot folder until the next start.
        ("getdents", "inbox/test/.claimed/#T#Z-#-#@#", EIO, false),
        ("open", "inbox/test/.claimed/#T#Z-#-#@#", ESTALE, true),
        ("stat", "inbox/test/.claimed/#T#Z-#-#@#/bad.stl", ESTALE, true),
        ("stat", "inbox/test/.claimed/#T#Z-#-#@#", EACCES, false),
        ("stat", "inbox/test/.claimed/#T#Z-#-#@#/plate.stl", EIO, false),
        ("stat", "inbox/test/.claimed/.new-#T#Z-#-#@#/plate.stl", ESTALE, true),
        ("stat", "inbox/test/.claimed/.new-#T#Z-#-#@#", EACCES, true),
        // Files that could not be read for a while were taken for damaged.
        ("read", "state/store/#/#", EIO, true),
        ("stat", "state", EACCES, true),
        ("open", "queue/test/.#T#Z_test_#.parts.csv.half", ESTALE, true),
    ];
    let point = |(call, place, error, lasts): (&'static str, &str, i32, bool)| FaultPoint {
        site: (call, place.to_owned()),
        fault: InjectedFault::Error(error),
        lasts,
    };
    found.map(point).into()
}

/// Orders the faults: first one at each site, then another one at each, and so on. A run that is cut short has then
/// tried every site.
fn interleave(mut sites: Vec<Vec<FaultPoint>>) -> Vec<FaultPoint> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    sites.iter_mut().for_each(|points| points.shuffle(&mut rng));
    let rounds = sites.iter().map(Vec::len).max().unwrap_or_default();
    let mut all = Vec::new();
    for round in 0..rounds {
        let mut points: Vec<FaultPoint> = sites.iter().filter_map(|points| points.get(round)).cloned().collect();
        points.shuffle(&mut rng);
        all.extend(points);
    }
    all
}

const ENDED: &str = "ended at its start";

/// All call sites of a life-cycle without faults.
fn sites() -> BTreeSet<(CallSite, bool)> {
    let mut life = LifeCycle::new();
    let seen = Arc::new(Mutex::new(BTreeSet::new()));
    let watch = CallSiteCollector { root: life.farm.root().to_owned(), seen: seen.clone() };
    let mut traced = TracedDaemon::start(life.farm.command(&["run"]), life.farm.root(), watch).unwrap();
    let end = life.play(traced.pid(), &mut || traced.has_ended());
    traced.stop();
    assert_eq!(end, ScriptEnd::Done, "{}", life.farm.log());
    let seen = seen.lock().unwrap();
    seen.clone()
}

struct CallSiteCollector {
    root: std::path::PathBuf,
    /// With whether the call creates or changes.
    seen: Arc<Mutex<BTreeSet<(CallSite, bool)>>>,
}

impl CallWatcher for CallSiteCollector {
    fn before(&mut self, call: &SystemCall) -> CallVerdict {
        self.seen.lock().unwrap().insert((site(call, &self.root), call.kind == CallEffect::Change));
        CallVerdict::Let
    }

    fn after(&mut self, _: &SystemCall, _: i64) -> bool {
        true
    }
}

/// The site of a call, without the random parts of its path.
fn site(call: &SystemCall, root: &Path) -> CallSite {
    let place = call.path.strip_prefix(root).unwrap_or(&call.path);
    let parts: Vec<String> = place.iter().map(|part| without_random_parts(&part.to_string_lossy())).collect();
    (call.name, parts.join("/"))
}

/// Random names and numbers become `#`.
fn without_random_parts(part: &str) -> String {
    for prefix in ["tmp-", ".nestd-queue-"] {
        if part.starts_with(prefix) {
            return format!("{prefix}#");
        }
    }
    if part.len() == 2 && part.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return "#".to_owned();
    }
    let mut text = String::new();
    let mut run = String::new();
    for c in part.chars().chain(['\0']) {
        if c.is_ascii_hexdigit() {
            run.push(c);
            continue;
        }
        let is_chance = run.len() >= 6 || (!run.is_empty() && run.bytes().all(|byte| byte.is_ascii_digit()));
        text.push_str(if is_chance { "#" } else { &run });
        run.clear();
        text.push(c);
    }
    text.trim_end_matches('\0').to_owned()
}

/// The faults that can happen at a site.
fn possible_faults((site, changes): &(CallSite, bool)) -> Vec<FaultPoint> {
    let errors: &[i32] = match (site.0, changes) {
        ("write" | "pwrite" | "writev" | "pwritev" | "copy_file_range" | "sendfile", _) => {
            &[EIO, ENOSPC, EDQUOT, ESTALE, EINTR]
        }
        ("fsync" | "ftruncate" | "fallocate" | "truncate", _) => &[EIO, ENOSPC, EDQUOT, ESTALE, EINTR],
        ("open", true) => &[EIO, ENOSPC, EDQUOT, EACCES, EROFS, ESTALE, EINTR],
        ("open", false) => &[EIO, EACCES, ESTALE, EINTR],
        ("rename" | "link", _) => &[EIO, ENOSPC, EDQUOT, EACCES, EROFS, ESTALE, EXDEV],
        ("mkdir" | "symlink", _) => &[EIO, ENOSPC, EDQUOT, EACCES, EROFS, ESTALE],
        ("unlink" | "rmdir" | "chmod" | "chown" | "utimens", _) => &[EIO, EACCES, EROFS, ESTALE],
        ("read" | "pread" | "readv", _) => &[EIO, ESTALE, EINTR],
        _ => &[EIO, EACCES, ESTALE],
    };
    let mut faults: Vec<InjectedFault> = errors.iter().map(|&errno| InjectedFault::Error(errno)).collect();
    if matches!(site.0, "write" | "pwrite") {
        faults.push(InjectedFault::Short);
    }
    let point = |fault, lasts| FaultPoint { site: site.clone(), fault, lasts };
    faults.into_iter().flat_map(|fault| [point(fault, false), point(fault, true)]).collect()
}

/// Whether a lasting fault makes no sense: a call that is interrupted again and again is repeated for ever, which the
/// kernel never causes.
fn must_not_last(point: &FaultPoint) -> bool {
    point.fault == InjectedFault::Error(EINTR)
}

fn one_life(point: &FaultPoint) -> SectionResult {
    let mut life = LifeCycle::new();
    let injected: Arc<Mutex<BTreeMap<&'static str, u64>>> = Arc::default();
    let watch = FaultInjector {
        root: life.farm.root().to_owned(),
        point: FaultPoint { lasts: point.lasts && !must_not_last(point), ..point.clone() },
        began: None,
        injected: injected.clone(),
    };
    let mut traced = TracedDaemon::start(life.farm.command(&["run"]), life.farm.root(), watch).unwrap();
    let end = life.play(traced.pid(), &mut || traced.has_ended());
    let mut row = SectionResult { files: 5, ..SectionResult::default() };
    match end {
        ScriptEnd::Done => {
            let (_, in_time) = traced.stop();
            if !in_time {
                life.broken.push("the daemon did not stop in time".to_owned());
            }
            life.check_at_rest();
        }
        ScriptEnd::DaemonEnded => {
            drop(traced.kill());
            if life.farm.log().contains("The farm is open.") {
                life.broken.push(format!("the daemon ended\n{}", tail(&life.farm.log())));
            }
            row.note = ENDED.to_owned();
            life.run_to_the_end();
        }
        ScriptEnd::Stuck => {
            drop(traced.kill());
            let left = intake::files_below(&life.farm.folder("inbox")).unwrap_or_default();
            let (step, log) = (life.step_name(), tail(&life.farm.log()));
            life.broken.push(format!("the script is stuck at {step}; in the hot folder stand {left:?}\n{log}"));
        }
    }
    row.faults = injected.lock().unwrap().values().sum();
    row.builds = life.taken.len() as u64;
    row.broken = life.broken.iter().map(|text| format!("{point:?}: {text}")).collect();
    row
}

fn tail(log: &str) -> String {
    let lines: Vec<&str> = log.lines().collect();
    lines[lines.len().saturating_sub(12)..].join("\n")
}

struct FaultInjector {
    root: std::path::PathBuf,
    point: FaultPoint,
    began: Option<Instant>,
    injected: Arc<Mutex<BTreeMap<&'static str, u64>>>,
}

impl CallWatcher for FaultInjector {
    fn before(&mut self, call: &SystemCall) -> CallVerdict {
        if call.name != self.point.site.0 || site(call, &self.root) != self.point.site {
            return CallVerdict::Let;
        }
        if self.began.is_some_and(|began| !self.point.lasts || began.elapsed() > LASTS) {
            return CallVerdict::Let;
        }
        if self.point.fault == InjectedFault::Short && call.bytes < 2 {
            return CallVerdict::Let;
        }
        self.began.get_or_insert_with(Instant::now);
        *self.injected.lock().unwrap().entry(call.name).or_default() += 1;
        match self.point.fault {
            InjectedFault::Error(errno) => CallVerdict::Fail(errno),
            InjectedFault::Short => CallVerdict::Shorten(call.bytes / 2),
        }
    }

    fn after(&mut self, _: &SystemCall, _: i64) -> bool {
        true
    }
}
