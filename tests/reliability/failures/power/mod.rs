//! Power loss: the file operations of a life-cycle from claim to publishing are recorded with their fsyncs. At every
//! moment, each operation that no fsync had made durable may be lost. Each single one and each pair of them is left
//! out, the resulting folders are rebuilt on disk, and the daemon is started on them.
//!
//! A name is durable once its folder was fsynced; contents are durable once their file was. Nothing counts as durable
//! only because a journal usually orders it so. SQLite's own files follow SQLite's guarantee for `synchronous = FULL`:
//! a returned commit is durable; what its log had not fsynced may be lost as a whole.

mod record;
mod tree;

use std::collections::HashSet;

use rand::{SeedableRng, seq::SliceRandom};
use record::RecordedRun;
use tree::{FileOperation, InodeTree};

use crate::{
    harness::{SectionBudget, SectionResult, catch_panic, in_parallel, life_cycle::LifeCycle},
    support::trace::is_allowed,
};

/// A state after power loss: the number of operations that were begun, and which of them are lost.
#[derive(Debug, Clone)]
struct PowerLoss {
    begun: usize,
    missing: Vec<usize>,
}

pub fn run(budget: &SectionBudget) -> SectionResult {
    if !is_allowed() {
        return SectionResult {
            note: "SKIPPED: processes may not be traced here".to_owned(),
            ..SectionResult::default()
        };
    }
    let recording = record::record_run();
    let mut losses = all_losses(&recording.ops);
    losses.shuffle(&mut rand_chacha::ChaCha8Rng::seed_from_u64(3));
    let all = losses.len();
    let rows = in_parallel(losses, budget, |loss| {
        let what = loss.describe(&recording.ops);
        let mut row = catch_panic(&what, || one_start(&recording, &loss));
        row.broken.iter_mut().for_each(|text| *text = format!("{what}: {text}"));
        row
    });
    SectionResult {
        points: rows.len() as u64,
        note: format!(
            "{} of {all} states after power loss; {} file operations recorded",
            rows.len(),
            recording.ops.iter().filter(|op| !op.is_sync()).count()
        ),
        ..SectionResult::sum(&rows)
    }
}

impl PowerLoss {
    fn describe(&self, ops: &[FileOperation]) -> String {
        let missing: Vec<String> = self.missing.iter().map(|&at| ops[at].in_words()).collect();
        let last = self.begun.checked_sub(1).map_or("nothing".to_owned(), |at| ops[at].in_words());
        format!("power lost after operation {} ({last}), missing: [{}]", self.begun, missing.join("; "))
    }
}

/// All different states: every moment, with none, one or two of the operations lost that were not durable then.
fn all_losses(ops: &[FileOperation]) -> Vec<PowerLoss> {
    let mut seen = HashSet::new();
    let mut losses = Vec::new();
    // States inside a commit of the ledger equal the state before it.
    let is_moment = |begun: &usize| *begun == 0 || !ops[begun - 1].is_of_ledger || ops[begun - 1].is_sync();
    for begun in (0..=ops.len()).filter(is_moment) {
        let loose = undurable_operations(&ops[..begun]);
        let none = std::iter::once(Vec::new());
        let one = loose.iter().cloned();
        let two = (0..loose.len()).flat_map(|a| {
            let loose = &loose;
            (a + 1..loose.len()).map(move |b| [loose[a].clone(), loose[b].clone()].concat())
        });
        for mut missing in none.chain(one).chain(two) {
            missing.sort_unstable();
            let done: Vec<usize> =
                (0..begun).filter(|at| !ops[*at].is_sync() && missing.binary_search(at).is_err()).collect();
            if seen.insert(blake3::hash(format!("{done:?}").as_bytes())) {
                losses.push(PowerLoss { begun, missing });
            }
        }
    }
    losses
}

/// The operations that are not durable yet. Operations on the ledger's files are one unit, and so are consecutive
/// writes to a file.
fn undurable_operations(ops: &[FileOperation]) -> Vec<Vec<usize>> {
    let (mut units, mut ledger) = (Vec::<Vec<usize>>::new(), Vec::new());
    for (at, op) in ops.iter().enumerate().filter(|(_, op)| !op.is_sync()) {
        let is_durable = ops[at + 1..].iter().any(|later| op.is_durable_after(later));
        match (is_durable, op.is_of_ledger) {
            (true, _) => {}
            (false, true) => ledger.push(at),
            (false, false) => match units.last_mut() {
                Some(unit) if unit.last().is_some_and(|&before| op.continues_write(&ops[before])) => unit.push(at),
                _ => units.push(vec![at]),
            },
        }
    }
    if !ledger.is_empty() {
        units.push(ledger);
    }
    units
}

/// Rebuilds the folders, and lets the daemon finish its work.
fn one_start(recording: &RecordedRun, loss: &PowerLoss) -> SectionResult {
    let mut tree: InodeTree = recording.base.clone();
    for (at, op) in recording.ops[..loss.begun].iter().enumerate() {
        tree.allocate(op);
        if loss.missing.binary_search(&at).is_err() {
            tree.apply(op);
        }
    }
    let mut life = LifeCycle::after_dropping(record::TRIGGER, recording.expectations.clone());
    tree.write(life.farm.root());
    keep_marks(&life);
    life.run_to_the_end();
    SectionResult {
        faults: loss.missing.len() as u64,
        files: 5,
        builds: life.taken.len() as u64,
        broken: life.broken,
        ..SectionResult::default()
    }
}

/// Updates the marks of an order list. They identify the list by inode and time, which rebuilding changes but power
/// loss does not.
fn keep_marks(life: &LifeCycle) {
    use std::os::unix::fs::MetadataExt;
    let inbox = life.farm.folder("inbox");
    let Ok(list) = std::fs::metadata(inbox.join("order.csv")) else { return };
    let ctime_ns = i128::from(list.ctime()) * 1_000_000_000 + i128::from(list.ctime_nsec());
    let marks = inbox.join(".claimed/.lists");
    for entry in std::fs::read_dir(&marks).into_iter().flatten() {
        std::fs::rename(entry.unwrap().path(), marks.join(format!("{}-{ctime_ns}", list.ino()))).unwrap();
    }
}
