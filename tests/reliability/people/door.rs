//! Orders of a program over HTTP, with kills: the daemon is killed after its n-th system call that changes a file while an order comes, and
//! at random moments while many come. The program sends each request again, under its key, until it is answered. At the end each key is
//! one order, with exactly the copies that were asked.

use std::{
    fs,
    path::PathBuf,
    time::{Duration, Instant},
};

use farm::InvariantExpectations;
use ledger::{PartRow, PartState};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    failures::crash::KillAfterChanges,
    harness::{
        ActionCounts, DOUBLED, LOST, SectionBudget, SectionResult, catch_panic, in_parallel,
        life_cycle::{BUSY_MACHINE, FARM},
        spread_order,
    },
    support::{
        MACHINE, TestFarm, block,
        http::send_request,
        stl,
        trace::{TracedDaemon, is_allowed},
    },
};

/// Most kills at random moments of a short and of a long run.
const KILLS: (u64, u64) = (25, 20_000);
/// Kills of one farm.
const KILLS_PER_FARM: u64 = 25;
/// Time budget of a short run, seconds.
const SHORT_SECS: f64 = 18.0;
/// Lines of an order.
const LINES: u32 = 2;

pub fn run(budget: &SectionBudget) -> SectionResult {
    let budget = &budget.at_least(SHORT_SECS);
    let mut rows = Vec::new();
    if is_allowed() {
        let half = SectionBudget::short(budget.secs / 3.0);
        let (all, whole) = ordered_under_trace(u64::MAX);
        rows.push(whole);
        let one = |point| catch_panic(&format!("killed after change {point}"), || ordered_under_trace(point).1);
        rows.extend(in_parallel(spread_order(all), &half, one));
    }
    let points = rows.len();
    let kills = budget.pick(KILLS.0, KILLS.1);
    let farms: Vec<u64> = (0..kills.div_ceil(KILLS_PER_FARM)).collect();
    rows.extend(in_parallel(farms, budget, |seed| catch_panic(&format!("farm {seed}"), || kill_often(seed, budget))));
    let sum = SectionResult::sum(&rows);
    SectionResult {
        counts: ActionCounts { kills: sum.faults, ..sum.counts },
        note: format!(
            "orders over HTTP: killed after the n-th changing call at {points} points, and at random moments"
        ),
        ..sum
    }
}

/// A farm with a door, and the program that orders there.
struct OrderingProgram {
    farm: TestFarm,
    /// The orders so far: key, and the copies of each line.
    orders: Vec<(String, [u32; LINES as usize])>,
    parts: [Vec<u8>; LINES as usize],
    expectations: InvariantExpectations,
}

impl OrderingProgram {
    fn new() -> Self {
        let farm = TestFarm::new(BUSY_MACHINE);
        let socket = farm.root().join("web.sock");
        fs::write(farm.config(), format!("{FARM}[web]\nlisten = \"unix:{}\"\n", socket.display())).unwrap();
        let parts = [stl(&block(12.0, 9.0, 7.0)), stl(&block(11.0, 10.0, 5.0))];
        Self { farm, orders: Vec::new(), parts, expectations: InvariantExpectations::default() }
    }

    fn socket(&self) -> PathBuf {
        self.farm.root().join("web.sock")
    }

    /// Thinks of another order.
    fn add_order(&mut self, copies: [u32; LINES as usize]) -> usize {
        self.orders.push((format!("K-{}", self.orders.len()), copies));
        for part in &self.parts {
            *self.expectations.dropped.entry(blake3::hash(part).to_hex().to_string()).or_default() += 1;
        }
        self.orders.len() - 1
    }

    /// Sends an order with all that it needs. Returns whether it was taken.
    fn send_order(&self, number: usize) -> bool {
        let (key, copies) = &self.orders[number];
        let mut lines = Vec::new();
        for (at, part) in self.parts.iter().enumerate() {
            let hash = blake3::hash(part).to_hex();
            let put = send_request(&self.socket(), &format!("PUT /api/v1/content/{hash}"), part);
            if !put.is_some_and(|answer| matches!(answer.status, 200 | 201)) {
                return false;
            }
            lines.push(
                serde_json::json!({ "name": format!("part{at}.stl"), "content": hash.as_str(), "copies": copies[at] }),
            );
        }
        let order = serde_json::json!({ "machine": MACHINE, "order": key, "lines": lines }).to_string();
        let words = format!("POST /api/v1/orders\ncontent-type: application/json\nidempotency-key: {key}");
        let Some(answer) = send_request(&self.socket(), &words, order.as_bytes()) else { return false };
        assert!(matches!(answer.status, 202 | 409 | 503), "{answer:?}");
        answer.status == 202
    }

    /// Without further kills: sends every order until it is taken, and waits until all its parts are read or in builds.
    fn finish(mut self) -> SectionResult {
        let mut broken = Vec::new();
        if self.farm.has_ended() {
            self.farm.start();
        }
        for number in 0..self.orders.len() {
            let began = Instant::now();
            while !self.send_order(number) {
                assert!(began.elapsed().as_secs() < 30, "an order is not taken\n{}", self.farm.log());
                std::thread::sleep(Duration::from_millis(20));
            }
        }
        let began = Instant::now();
        let wanted = self.orders.len() * LINES as usize;
        while self.settled_parts().len() < wanted && began.elapsed().as_secs() < 60 {
            std::thread::sleep(Duration::from_millis(50));
        }
        // Whatever comes twice has time to come.
        std::thread::sleep(Duration::from_millis(600));
        let parts = self.settled_parts();
        for (key, copies) in &self.orders {
            let mut found: Vec<(String, u32)> = (parts.iter())
                .filter(|part| part.terms.order_name == *key)
                .map(|part| (part.name.clone(), part.wanted_copies()))
                .collect();
            found.sort();
            let asked: Vec<(String, u32)> =
                copies.iter().enumerate().map(|(at, copies)| (format!("part{at}.stl"), *copies)).collect();
            if found != asked {
                let sum = |lines: &[(String, u32)]| lines.iter().map(|(_, copies)| copies).sum::<u32>();
                let kind = if sum(&found) < sum(&asked) { LOST } else { DOUBLED };
                broken.push(format!("{kind}: order {key}: asked for {asked:?}, made {found:?}\n{}", self.farm.log()));
            }
        }
        // It may be nesting, which does not matter here.
        self.farm.kill();
        broken.extend(self.farm.broken_invariants(&self.expectations));
        let files = self.orders.len() as u64 * u64::from(LINES);
        let builds = self.farm.queued().len() as u64;
        let counts = ActionCounts { door_orders: self.orders.len() as u64, ..ActionCounts::default() };
        SectionResult { files, builds, counts, broken, ..SectionResult::default() }
    }

    /// The parts that are past their claim, while no claim stands any more.
    fn settled_parts(&self) -> Vec<PartRow> {
        let claims = intake::list_claims(&self.farm.folder("inbox")).unwrap_or_default();
        if !claims.claims.is_empty() || !claims.unfinished.is_empty() {
            return Vec::new();
        }
        self.farm.query_ledger(async |ledger| {
            let mut parts = Vec::new();
            for (order, _) in &self.orders {
                // All states in one query: a part that moves on meanwhile is not found twice.
                parts.extend(ledger.parts_of_order(order).await.unwrap());
            }
            parts.retain(|part| part.state != PartState::Claimed);
            parts
        })
    }
}

/// An order while the daemon is killed after its n-th change. Returns the number of changes before, and the results.
fn ordered_under_trace(point: u64) -> (u64, SectionResult) {
    let mut program = OrderingProgram::new();
    let watch = KillAfterChanges::new(program.farm.root(), point);
    let mut traced = TracedDaemon::start(program.farm.command(&["run"]), program.farm.root(), watch).unwrap();
    let number = program.add_order([2, 1]);
    let began = Instant::now();
    let mut is_taken = false;
    while !traced.has_ended() && began.elapsed().as_secs() < 40 {
        is_taken = is_taken || program.send_order(number);
        if is_taken && program.settled_parts().len() == LINES as usize {
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let was_killed = traced.has_ended();
    let watch = traced.kill();
    let changes = watch.changes();
    let foreign = watch.foreign_deletions();
    let mut row = program.finish();
    row.broken.extend(foreign);
    row.broken.iter_mut().for_each(|text| *text = format!("killed after change {changes}: {text}"));
    (changes, SectionResult { points: 1, faults: u64::from(was_killed), ..row })
}

/// Many orders while the daemon is killed at random moments.
fn kill_often(seed: u64, budget: &SectionBudget) -> SectionResult {
    let (mut program, mut rng) = (OrderingProgram::new(), ChaCha8Rng::seed_from_u64(seed));
    let mut kills = 0;
    while kills < KILLS_PER_FARM && budget.left_secs() > 0.3 * budget.secs.min(20.0) {
        program.farm.start();
        let number = program.add_order([rng.random_range(1..3), rng.random_range(1..3)]);
        let until = Instant::now() + Duration::from_millis(rng.random_range(5..900));
        std::thread::scope(|scope| {
            let program = &program;
            let sending = scope.spawn(move || {
                while Instant::now() < until && !program.send_order(number) {
                    std::thread::sleep(Duration::from_millis(3));
                }
            });
            std::thread::sleep(until.saturating_duration_since(Instant::now()));
            crate::support::signal(program.farm.pid(), rustix::process::Signal::KILL);
            sending.join().unwrap();
        });
        program.farm.kill();
        kills += 1;
    }
    program.farm.start();
    SectionResult { points: kills, faults: kills, ..program.finish() }
}
