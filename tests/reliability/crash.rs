//! Every crash: the daemon is killed after its n-th call that changes a file, for every n of the reference life-cycle; it is
//! started again, the life-cycle goes on to its end, and the invariants are looked at both times.

use std::sync::{Arc, Mutex};

use super::{
    budget::Budget,
    life::{End, Life},
    pool::{in_parallel, spread},
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
    let rows = in_parallel(points, budget, |point| one_life(point).1);
    row.points = rows.iter().map(|r| r.points).sum();
    row.faults = row.points;
    row.files += rows.iter().map(|r| r.files).sum::<u64>();
    row.builds += rows.iter().map(|r| r.builds).sum::<u64>();
    let tried = rows.len();
    row.broken.extend(rows.into_iter().flat_map(|r| r.broken));
    row.note = format!("killed after the n-th changing call; {tried} of {all} points of the life-cycle");
    row
}

/// A whole life with a kill after the n-th change; how many changes there were before, and what came out.
fn one_life(point: u64) -> (u64, Row) {
    let mut life = Life::new();
    let watch = KillAfter { point, count: Arc::default() };
    let count = watch.count.clone();
    let mut traced = Traced::start(life.farm.command(&["run"]), life.farm.root(), watch).unwrap();
    let end = life.play(&mut || traced.has_ended());
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
    let (changes, last) = count.lock().unwrap().clone();
    row.builds = life.taken.len() as u64;
    row.broken = life.broken.iter().map(|text| format!("killed after change {changes} ({last}): {text}")).collect();
    (changes, row)
}

/// Changes so far, and the last one in words.
type Count = Arc<Mutex<(u64, String)>>;

struct KillAfter {
    point: u64,
    count: Count,
}

impl Watch for KillAfter {
    fn before(&mut self, _: &Call) -> Verdict {
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
