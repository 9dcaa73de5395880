//! Every fault: each call site of the reference life-cycle that touches the farm's files is made to fail with each error that
//! it can have, once, and for a while; writes are cut short. The daemon must live on, refuse no part for it, and be whole
//! again when the fault is gone.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use nix::libc::{EACCES, EDQUOT, EINTR, EIO, ENOSPC, EROFS, ESTALE, EXDEV};
use rand::{SeedableRng, seq::SliceRandom};

use super::{
    budget::Budget,
    life::{End, Life},
    pool::{caught, in_parallel},
    row::Row,
    trace::{Call, Kind, Traced, Verdict, Watch, is_allowed},
};

/// How long a lasting fault lasts.
const LASTS: Duration = Duration::from_millis(1500);

/// A place in the life-cycle: a system call on a kind of file.
type Site = (&'static str, String);

/// What is done to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fault {
    Error(i32),
    Short,
}

#[derive(Debug, Clone)]
struct Point {
    site: Site,
    fault: Fault,
    lasts: bool,
}

pub fn run(budget: &Budget) -> Row {
    if !is_allowed() {
        return Row { note: "SKIPPED: processes may not be traced here".to_owned(), ..Row::default() };
    }
    let sites = sites();
    let mut points = found_before();
    points.extend(in_turn(sites.iter().map(points_of).collect()));
    let all = points.len();
    let rows = in_parallel(points, budget, |point| caught(&format!("{point:?}"), || one_life(&point)));
    Row {
        points: rows.iter().filter(|row| row.faults > 0).count() as u64,
        note: format!(
            "{} of {all} faults at {} call sites; {} ended the start, as they may",
            rows.len(),
            sites.len(),
            rows.iter().filter(|row| row.note == ENDED).count()
        ),
        ..Row::sum(&rows)
    }
}

/// Faults that broke something once; they come first, also in a short run.
fn found_before() -> Vec<Point> {
    #[rustfmt::skip]
    let found = [
        // Parts were printed in guessed numbers while what says how many could not be looked at.
        ("stat", "inbox/test/ring.stl.toml", EACCES, true),
        ("stat", "inbox/test/order.csv", EACCES, true),
        // Claims stood in the hot folder until the next start.
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
    let point = |(call, place, error, lasts): (&'static str, &str, i32, bool)| Point {
        site: (call, place.to_owned()),
        fault: Fault::Error(error),
        lasts,
    };
    found.map(point).into()
}

/// One fault at each site, then another one at each, ...: a run that is cut short has been everywhere.
fn in_turn(mut sites: Vec<Vec<Point>>) -> Vec<Point> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    sites.iter_mut().for_each(|points| points.shuffle(&mut rng));
    let rounds = sites.iter().map(Vec::len).max().unwrap_or_default();
    let mut all = Vec::new();
    for round in 0..rounds {
        let mut points: Vec<Point> = sites.iter().filter_map(|points| points.get(round)).cloned().collect();
        points.shuffle(&mut rng);
        all.extend(points);
    }
    all
}

const ENDED: &str = "ended at its start";

/// Every call site of a life without faults.
fn sites() -> BTreeSet<(Site, bool)> {
    let mut life = Life::new();
    let seen = Arc::new(Mutex::new(BTreeSet::new()));
    let watch = Sites { root: life.farm.root().to_owned(), seen: seen.clone() };
    let mut traced = Traced::start(life.farm.command(&["run"]), life.farm.root(), watch).unwrap();
    let end = life.play(traced.pid(), &mut || traced.has_ended());
    traced.stop();
    assert_eq!(end, End::Done, "{}", life.farm.log());
    let seen = seen.lock().unwrap();
    seen.clone()
}

struct Sites {
    root: std::path::PathBuf,
    /// With whether the call creates or changes.
    seen: Arc<Mutex<BTreeSet<(Site, bool)>>>,
}

impl Watch for Sites {
    fn before(&mut self, call: &Call) -> Verdict {
        self.seen.lock().unwrap().insert((site(call, &self.root), call.kind == Kind::Change));
        Verdict::Let
    }

    fn after(&mut self, _: &Call, _: i64) -> bool {
        true
    }
}

/// A call with what is chance in its path taken out.
fn site(call: &Call, root: &Path) -> Site {
    let place = call.path.strip_prefix(root).unwrap_or(&call.path);
    let parts: Vec<String> = place.iter().map(|part| plain(&part.to_string_lossy())).collect();
    (call.name, parts.join("/"))
}

/// Random names and numbers become `#`.
fn plain(part: &str) -> String {
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

/// What can happen at a site.
fn points_of((site, changes): &(Site, bool)) -> Vec<Point> {
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
    let mut faults: Vec<Fault> = errors.iter().map(|&errno| Fault::Error(errno)).collect();
    if matches!(site.0, "write" | "pwrite") {
        faults.push(Fault::Short);
    }
    let point = |fault, lasts| Point { site: site.clone(), fault, lasts };
    faults.into_iter().flat_map(|fault| [point(fault, false), point(fault, true)]).collect()
}

/// Whether an interrupted call goes on for ever when it is interrupted for ever: the kernel never does that.
fn must_not_last(point: &Point) -> bool {
    point.fault == Fault::Error(EINTR)
}

fn one_life(point: &Point) -> Row {
    let mut life = Life::new();
    let injected: Arc<Mutex<BTreeMap<&'static str, u64>>> = Arc::default();
    let watch = Inject {
        root: life.farm.root().to_owned(),
        point: Point { lasts: point.lasts && !must_not_last(point), ..point.clone() },
        began: None,
        injected: injected.clone(),
    };
    let mut traced = Traced::start(life.farm.command(&["run"]), life.farm.root(), watch).unwrap();
    let end = life.play(traced.pid(), &mut || traced.has_ended());
    let mut row = Row { files: 5, ..Row::default() };
    match end {
        End::Done => {
            let (_, in_time) = traced.stop();
            if !in_time {
                life.broken.push("the daemon did not stop in time".to_owned());
            }
            life.look_at_rest();
        }
        End::DaemonEnded => {
            drop(traced.kill());
            if life.farm.log().contains("The farm is open.") {
                life.broken.push(format!("the daemon ended\n{}", tail(&life.farm.log())));
            }
            row.note = ENDED.to_owned();
            life.run_to_the_end();
        }
        End::Stuck => {
            drop(traced.kill());
            let left = nestd::intake::files_below(&life.farm.folder("inbox")).unwrap_or_default();
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

struct Inject {
    root: std::path::PathBuf,
    point: Point,
    began: Option<Instant>,
    injected: Arc<Mutex<BTreeMap<&'static str, u64>>>,
}

impl Watch for Inject {
    fn before(&mut self, call: &Call) -> Verdict {
        if call.name != self.point.site.0 || site(call, &self.root) != self.point.site {
            return Verdict::Let;
        }
        if self.began.is_some_and(|began| !self.point.lasts || began.elapsed() > LASTS) {
            return Verdict::Let;
        }
        if self.point.fault == Fault::Short && call.bytes < 2 {
            return Verdict::Let;
        }
        self.began.get_or_insert_with(Instant::now);
        *self.injected.lock().unwrap().entry(call.name).or_default() += 1;
        match self.point.fault {
            Fault::Error(errno) => Verdict::Fail(errno),
            Fault::Short => Verdict::Shorten(call.bytes / 2),
        }
    }

    fn after(&mut self, _: &Call, _: i64) -> bool {
        true
    }
}
