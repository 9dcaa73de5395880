//! Every crash: the daemon is killed after its n-th call that changes a file, for every n of the reference life-cycle; it is
//! started again, the life-cycle goes on to its end, and the invariants are looked at both times.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
};

use super::{
    budget::Budget,
    life::{End, Life},
    pool::{caught, in_parallel, spread},
    row::Row,
    trace::{Call, Kind, Traced, Verdict, Watch, is_allowed},
};

pub fn run(budget: &Budget) -> Row {
    if !is_allowed() {
        return Row { note: "SKIPPED: processes may not be traced here".to_owned(), ..Row::default() };
    }
    let (whole, mut row) = one_life(u64::MAX);
    row.broken.iter_mut().for_each(|text| *text = format!("without any crash: {text}"));
    let points = spread(whole);
    let all = points.len();
    let mut rows =
        in_parallel(points, budget, |point| caught(&format!("killed after change {point}"), || one_life(point).1));
    let note = format!("killed after the n-th changing call; {} of {all} points of the life-cycle", rows.len());
    rows.insert(0, row);
    let sum = Row::sum(&rows);
    Row { faults: sum.points, note, ..sum }
}

/// A whole life with a kill after the n-th change; how many changes there were before, and what came out.
fn one_life(point: u64) -> (u64, Row) {
    let mut life = Life::new();
    let root = life.farm.root().to_owned();
    let watch = KillAfter::new(&root, point);
    let (count, foreign) = (watch.count.clone(), watch.foreign.clone());
    let mut traced = Traced::start(life.farm.command(&["run"]), life.farm.root(), watch).unwrap();
    let end = life.play(traced.pid(), &mut || traced.has_ended());
    let mut row = Row { files: 5, ..Row::default() };
    match end {
        End::DaemonEnded => {
            drop(traced.kill());
            row.points = 1;
            life.look_after_a_crash();
            life.take_as_a_printer_does();
            life.run_to_the_end();
        }
        End::Done => {
            let (_, in_time) = traced.stop();
            if !in_time {
                life.broken.push("the daemon did not stop in time".to_owned());
            }
            // The point may be in the orderly stop.
            row.points = u64::from(count.lock().unwrap().0 >= point);
            life.look_at_rest();
        }
        End::Stuck => {
            drop(traced.kill());
            life.broken.push(format!("the script is stuck under the tracer\n{}", life.farm.log()));
        }
    }
    life.broken.append(&mut foreign.lock().unwrap());
    let (changes, last) = count.lock().unwrap().clone();
    row.builds = life.taken.len() as u64;
    row.broken = life.broken.iter().map(|text| format!("killed after change {changes} ({last}): {text}")).collect();
    (changes, row)
}

/// Temporary files and folders that commands make.
const MADE_BY_COMMANDS: [&[u8]; 3] = [b".nestd-backup-", b".nestd-check-", b".nestd-folders-"];

/// The daemon's own temporary files, and what its part's state says is elsewhere now.
fn may_be_deleted(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let is_hidden = |prefix: &str, suffix: &str| name.starts_with(prefix) && name.ends_with(suffix);
    let is_below = |folder: &str| path.starts_with(folder);
    is_below("inbox/test/.claimed")
        || path == Path::new("inbox/test/kit")
        || is_below("state/store")
        || is_below("state/cache")
        || name.starts_with("nestd.db-")
        || name == "nestd.db.b3"
        || name.starts_with("nestd.db.restoring")
        || name.starts_with("nestd.db.aside-")
        || path.components().any(|part| MADE_BY_COMMANDS.iter().any(|with| part.as_os_str().as_encoded_bytes().starts_with(with)))
        || is_hidden(".nestd-", ".tmp")
        || (is_below("queue/test") && (is_hidden(".", ".part") || is_hidden(".", ".half")))
        // Of the part that was cancelled and taken back.
        || is_below("error/test/part-2")
        || is_below("error/test/part-1")
        || is_below("error/test/part-3")
        || is_below("error/test/part-4")
}

/// Changes so far, and the last one in words.
type Count = Arc<Mutex<(u64, String)>>;

/// Kills the process after its n-th change.
pub struct KillAfter {
    root: PathBuf,
    point: u64,
    count: Count,
    /// Deletions of what is not the daemon's own.
    foreign: Arc<Mutex<Vec<String>>>,
}

impl KillAfter {
    /// Kills after so many changes below `root`.
    pub fn new(root: &Path, point: u64) -> Self {
        Self { root: root.to_owned(), point, count: Arc::default(), foreign: Arc::default() }
    }

    /// Changes so far.
    pub fn changes(&self) -> u64 {
        self.count.lock().unwrap().0
    }

    /// Deletions of what is not the daemon's own, as sentences.
    pub fn foreign(&self) -> Vec<String> {
        self.foreign.lock().unwrap().clone()
    }
}

impl Watch for KillAfter {
    fn before(&mut self, call: &Call) -> Verdict {
        if matches!(call.name, "unlink" | "rmdir") && !may_be_deleted(call.path.strip_prefix(&self.root).unwrap()) {
            self.foreign.lock().unwrap().push(format!("I4: the daemon deleted {}", call.path.display()));
        }
        Verdict::Let
    }

    fn after(&mut self, call: &Call, _: i64) -> bool {
        let mut count = self.count.lock().unwrap();
        if call.kind == Kind::Look || count.0 >= self.point {
            return true;
        }
        count.0 += 1;
        if count.0 == self.point || self.point == u64::MAX {
            count.1 = format!("{} {}", call.name, call.path.display());
        }
        count.0 < self.point
    }
}
