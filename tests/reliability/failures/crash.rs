//! Every crash: the daemon is killed after its n-th system call that changes a file, for every n of the reference
//! life-cycle. Then it is started again and finishes the life-cycle. The invariants are checked after the kill and at
//! the end.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
};

use crate::{
    harness::{
        SectionBudget, SectionResult, catch_panic, in_parallel,
        life_cycle::{LifeCycle, ScriptEnd},
        spread_order,
    },
    support::trace::{CallEffect, CallVerdict, CallWatcher, SystemCall, TracedDaemon, is_allowed},
};

pub fn run(budget: &SectionBudget) -> SectionResult {
    if !is_allowed() {
        return SectionResult {
            note: "SKIPPED: processes may not be traced here".to_owned(),
            ..SectionResult::default()
        };
    }
    let (whole, mut row) = one_life(u64::MAX);
    row.broken.iter_mut().for_each(|text| *text = format!("without any crash: {text}"));
    let points = spread_order(whole);
    let all = points.len();
    let mut rows =
        in_parallel(points, budget, |point| catch_panic(&format!("killed after change {point}"), || one_life(point).1));
    let note = format!("killed after the n-th changing call; {} of {all} points of the life-cycle", rows.len());
    rows.insert(0, row);
    let sum = SectionResult::sum(&rows);
    SectionResult { faults: sum.points, note, ..sum }
}

/// A whole life-cycle with a kill after the n-th change. Returns the number of changes before, and the results.
fn one_life(point: u64) -> (u64, SectionResult) {
    let mut life = LifeCycle::new();
    let root = life.farm.root().to_owned();
    let watch = KillAfterChanges::new(&root, point);
    let (count, foreign) = (watch.count.clone(), watch.foreign.clone());
    let mut traced = TracedDaemon::start(life.farm.command(&["run"]), life.farm.root(), watch).unwrap();
    let end = life.play(traced.pid(), &mut || traced.has_ended());
    let mut row = SectionResult { files: 5, ..SectionResult::default() };
    match end {
        ScriptEnd::DaemonEnded => {
            drop(traced.kill());
            row.points = 1;
            life.check_after_crash();
            life.take_as_a_printer_does();
            life.run_to_the_end();
        }
        ScriptEnd::Done => {
            let (_, in_time) = traced.stop();
            if !in_time {
                life.broken.push("the daemon did not stop in time".to_owned());
            }
            // The kill may also come during the orderly stop.
            row.points = u64::from(count.lock().unwrap().0 >= point);
            life.check_at_rest();
        }
        ScriptEnd::Stuck => {
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

/// Whether a path may be deleted: the daemon's own temporary files, and files that were moved because of their part's
/// state.
fn may_be_deleted(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let is_hidden = |prefix: &str, suffix: &str| name.starts_with(prefix) && name.ends_with(suffix);
    let is_below = |folder: &str| path.starts_with(folder);
    is_below("inbox/test/.claimed")
        || path == Path::new("inbox/test/kit")
        || is_below("state/store")
        || is_below("state/put")
        || is_below("state/cache")
        || name.starts_with("nestd.db-")
        || name == "nestd.db.b3"
        || name.starts_with("nestd.db.restoring")
        || name.starts_with("nestd.db.aside-")
        || path.components().any(|part| MADE_BY_COMMANDS.iter().any(|with| part.as_os_str().as_encoded_bytes().starts_with(with)))
        || is_hidden(".nestd-", ".tmp")
        || (is_below("queue/test") && (is_hidden(".", ".part") || is_hidden(".", ".half")))
        // Files of the part that was cancelled and taken back.
        || is_below("error/test/part-2")
        || is_below("error/test/part-1")
        || is_below("error/test/part-3")
        || is_below("error/test/part-4")
}

/// The number of changes so far, and a description of the last one.
type ChangeCounter = Arc<Mutex<(u64, String)>>;

/// Kills the process after its n-th change.
pub struct KillAfterChanges {
    root: PathBuf,
    point: u64,
    count: ChangeCounter,
    /// Deletions of files that are not the daemon's own.
    foreign: Arc<Mutex<Vec<String>>>,
}

impl KillAfterChanges {
    /// Kills after `point` changes below `root`.
    pub fn new(root: &Path, point: u64) -> Self {
        Self { root: root.to_owned(), point, count: Arc::default(), foreign: Arc::default() }
    }

    /// Changes so far.
    pub fn changes(&self) -> u64 {
        self.count.lock().unwrap().0
    }

    /// Deletions of files that are not the daemon's own, as sentences.
    pub fn foreign_deletions(&self) -> Vec<String> {
        self.foreign.lock().unwrap().clone()
    }
}

impl CallWatcher for KillAfterChanges {
    fn before(&mut self, call: &SystemCall) -> CallVerdict {
        if matches!(call.name, "unlink" | "rmdir") && !may_be_deleted(call.path.strip_prefix(&self.root).unwrap()) {
            self.foreign.lock().unwrap().push(format!("I4: the daemon deleted {}", call.path.display()));
        }
        CallVerdict::Let
    }

    fn after(&mut self, call: &SystemCall, _: i64) -> bool {
        let mut count = self.count.lock().unwrap();
        if call.kind == CallEffect::Look || count.0 >= self.point {
            return true;
        }
        count.0 += 1;
        if count.0 == self.point || self.point == u64::MAX {
            count.1 = format!("{} {}", call.name, call.path.display());
        }
        count.0 < self.point
    }
}
