//! Power loss: the file operations of a life-cycle from claim to publishing are recorded with their fsyncs. For every moment,
//! each operation that no fsync had made durable may be missing after the power is back: every single one and every two of
//! them are left out, the resulting folders are rebuilt on disk, and the daemon is started on them.
//!
//! A name is durable once its folder was fsynced, contents once their file was; nothing is taken for durable because a
//! journal usually orders it so. SQLite's own files are taken as SQLite promises them with `synchronous = FULL`: a commit
//! that returned is there; what its log had not fsynced may be missing as a whole.

mod record;
mod tree;

use std::collections::HashSet;

use rand::{SeedableRng, seq::SliceRandom};

use super::{
    budget::Budget,
    life::Life,
    pool::{caught, in_parallel},
    row::Row,
    trace::is_allowed,
};
use record::Recording;
use tree::{Op, Tree};

/// A state after power loss: how many operations were begun, and which of them are missing.
#[derive(Debug, Clone)]
struct Loss {
    begun: usize,
    missing: Vec<usize>,
}

pub fn run(budget: &Budget) -> Row {
    if !is_allowed() {
        return Row { note: "SKIPPED: processes may not be traced here".to_owned(), ..Row::default() };
    }
    let recording = record::record();
    let mut losses = losses(&recording.ops);
    losses.shuffle(&mut rand_chacha::ChaCha8Rng::seed_from_u64(3));
    let all = losses.len();
    let rows = in_parallel(losses, budget, |loss| {
        let what = loss.in_words(&recording.ops);
        let mut row = caught(&what, || one_start(&recording, &loss));
        row.broken.iter_mut().for_each(|text| *text = format!("{what}: {text}"));
        row
    });
    Row {
        points: rows.len() as u64,
        note: format!(
            "{} of {all} states after power loss; {} file operations recorded",
            rows.len(),
            recording.ops.iter().filter(|op| !op.is_sync()).count()
        ),
        ..Row::sum(&rows)
    }
}

impl Loss {
    fn in_words(&self, ops: &[Op]) -> String {
        let missing: Vec<String> = self.missing.iter().map(|&at| ops[at].in_words()).collect();
        let last = self.begun.checked_sub(1).map_or("nothing".to_owned(), |at| ops[at].in_words());
        format!("power lost after operation {} ({last}), missing: [{}]", self.begun, missing.join("; "))
    }
}

/// All different states: every moment with nothing, one or two of the operations missing that were not durable then.
fn losses(ops: &[Op]) -> Vec<Loss> {
    let mut seen = HashSet::new();
    let mut losses = Vec::new();
    // Inside a commit of the ledger nothing is different from before it.
    let is_moment = |begun: &usize| *begun == 0 || !ops[begun - 1].is_of_ledger || ops[begun - 1].is_sync();
    for begun in (0..=ops.len()).filter(is_moment) {
        let loose = loose(&ops[..begun]);
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
                losses.push(Loss { begun, missing });
            }
        }
    }
    losses
}

/// The operations that are not durable yet. Those on the ledger's files are one unit, and so are the writes that fill a
/// file.
fn loose(ops: &[Op]) -> Vec<Vec<usize>> {
    let (mut units, mut ledger) = (Vec::<Vec<usize>>::new(), Vec::new());
    for (at, op) in ops.iter().enumerate().filter(|(_, op)| !op.is_sync()) {
        let is_durable = ops[at + 1..].iter().any(|later| op.is_durable_after(later));
        match (is_durable, op.is_of_ledger) {
            (true, _) => {}
            (false, true) => ledger.push(at),
            (false, false) => match units.last_mut() {
                Some(unit) if unit.last().is_some_and(|&before| op.fills_on(&ops[before])) => unit.push(at),
                _ => units.push(vec![at]),
            },
        }
    }
    if !ledger.is_empty() {
        units.push(ledger);
    }
    units
}

/// Rebuilds the folders, and lets the daemon go on to the end.
fn one_start(recording: &Recording, loss: &Loss) -> Row {
    let mut tree: Tree = recording.base.clone();
    for (at, op) in recording.ops[..loss.begun].iter().enumerate() {
        tree.allocate(op);
        if loss.missing.binary_search(&at).is_err() {
            tree.apply(op);
        }
    }
    let mut life = Life::after_dropping(record::TRIGGER, recording.witness.clone());
    tree.write(life.farm.root());
    keep_marks(&life);
    life.run_to_the_end();
    Row {
        faults: loss.missing.len() as u64,
        files: 5,
        builds: life.taken.len() as u64,
        broken: life.broken,
        ..Row::default()
    }
}

/// The marks of an order list know it by inode and time, which power loss does not change and rebuilding does.
fn keep_marks(life: &Life) {
    use std::os::unix::fs::MetadataExt;
    let inbox = life.farm.folder("inbox");
    let Ok(list) = std::fs::metadata(inbox.join("order.csv")) else { return };
    let ctime_ns = i128::from(list.ctime()) * 1_000_000_000 + i128::from(list.ctime_nsec());
    let marks = inbox.join(".claimed/.lists");
    for entry in std::fs::read_dir(&marks).into_iter().flatten() {
        std::fs::rename(entry.unwrap().path(), marks.join(format!("{}-{ctime_ns}", list.ino()))).unwrap();
    }
}
