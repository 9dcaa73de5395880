//! kill -9 at random moments under load: parts, orders and tickets arrive all the time, operators send commands, the
//! printer takes builds; many farms at once. At the end everything is built exactly once and the invariants hold.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::atomic::{AtomicU64, Ordering},
    time::{Duration, Instant},
};

use farm::InvariantExpectations;
use ledger::{CommandKind, Ledger, NewCommand, PartRow, PartState};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    harness::{
        ActionCounts, DOUBLED, LOST, SectionBudget, SectionResult, catch_panic, in_parallel,
        life_cycle::{self, BUSY_MACHINE},
        printer::ScriptedPrinter,
    },
    support::{MACHINE, TestFarm, block, stl},
};

/// Most kills of a short and of a long run; each also ends when its time is over.
const KILLS: (u64, u64) = (100, 20_000);
/// Time budget of a short run, seconds.
const SHORT_SECS: f64 = 14.0;
/// Kills of one farm.
const KILLS_PER_FARM: u64 = 25;

pub fn run(budget: &SectionBudget) -> SectionResult {
    let (kills, budget) = (AtomicU64::new(0), &budget.at_least(SHORT_SECS));
    let most = budget.pick(KILLS.0, KILLS.1);
    let farms: Vec<u64> = (0..most.div_ceil(KILLS_PER_FARM)).collect();
    let per_farm = budget.pick(most.div_ceil(4), KILLS_PER_FARM);
    let rows = in_parallel(farms, budget, |seed| {
        if kills.load(Ordering::Relaxed) >= most {
            return SectionResult::default();
        }
        catch_panic(&format!("farm {seed}"), || {
            let mut farm = KilledFarm::new(seed);
            farm.kill_often(per_farm, budget, &kills);
            farm.run_to_the_end()
        })
    });
    let faults = kills.into_inner();
    SectionResult {
        points: faults,
        faults,
        counts: ActionCounts { kills: faults, ..ActionCounts::default() },
        note: format!("kill -9 under load, on {} farms", rows.len()),
        ..SectionResult::sum(&rows)
    }
}

/// A farm that is killed again and again.
struct KilledFarm {
    farm: TestFarm,
    rng: ChaCha8Rng,
    seed: u64,
    dropped: u64,
    expectations: InvariantExpectations,
    /// Copies that must be printed, by name.
    wanted: BTreeMap<String, u32>,
    printer: ScriptedPrinter,
    copies: BTreeSet<(String, u32)>,
    broken: Vec<String>,
}

impl KilledFarm {
    fn new(seed: u64) -> Self {
        Self {
            farm: life_cycle::quick_farm(BUSY_MACHINE),
            rng: ChaCha8Rng::seed_from_u64(seed),
            seed,
            dropped: 0,
            expectations: InvariantExpectations::default(),
            wanted: BTreeMap::new(),
            printer: ScriptedPrinter::default(),
            copies: BTreeSet::new(),
            broken: Vec::new(),
        }
    }

    fn kill_often(&mut self, kills: u64, budget: &SectionBudget, all: &AtomicU64) {
        for _ in 0..kills {
            if budget.left_secs() < 0.25 * budget.secs.min(20.0) {
                return;
            }
            self.farm.start();
            for _ in 0..self.rng.random_range(0..3) {
                self.drop_random_part();
            }
            if self.rng.random_bool(0.3) {
                self.submit_random_command();
            }
            // A kill a few milliseconds after the start hits the recovery, a later one the work.
            let max_ms = if self.rng.random_bool(0.5) { 120 } else { 1500 };
            std::thread::sleep(Duration::from_millis(self.rng.random_range(2..max_ms)));
            self.farm.kill();
            all.fetch_add(1, Ordering::Relaxed);
            if self.rng.random_bool(0.3) {
                self.take_printed_builds();
            }
        }
    }

    /// A part, sometimes in an order folder, sometimes with a ticket, sometimes the same as before, sometimes broken.
    fn drop_random_part(&mut self) {
        let (number, copies) = (self.dropped, self.rng.random_range(1..4));
        self.dropped += 1;
        let folder = if self.rng.random_bool(0.2) { "kit/" } else { "" };
        let name = match self.rng.random_range(0..4) {
            0 => format!("part{number}.stl"),
            _ => format!("part{number}_x{copies}.stl"),
        };
        let is_bad = self.rng.random_bool(0.1);
        let size = self.rng.random_range(5..25);
        let bytes =
            if is_bad { b"solid nonsense\nendsolid\n".to_vec() } else { stl(&block(12.0, 9.0, f64::from(size))) };
        let mut wanted = if name.contains("_x") { copies } else { 1 };
        if self.rng.random_bool(0.2) {
            wanted = self.rng.random_range(1..4);
            self.farm.drop_bytes(&format!("{folder}{name}.toml"), format!("copies = {wanted}\n").as_bytes());
        }
        if !is_bad {
            self.wanted.insert(name.clone(), wanted);
        }
        *self.expectations.dropped.entry(blake3::hash(&bytes).to_hex().to_string()).or_default() += 1;
        self.farm.drop_bytes(&format!("{folder}{name}"), &bytes);
    }

    /// Sends a command about an existing part, or `flush`, without waiting for the answer.
    fn submit_random_command(&mut self) {
        let kind = [CommandKind::Flush, CommandKind::Cancel, CommandKind::Retry][self.rng.random_range(0..3)];
        let pick = self.rng.random_range(0..1000);
        self.ask(async |ledger| {
            let state = if matches!(kind, CommandKind::Retry) { PartState::Refused } else { PartState::Waiting };
            let parts = ledger.parts_in_state(state).await?;
            let part = (!parts.is_empty()).then(|| parts[pick % parts.len()].id);
            if !matches!(kind, CommandKind::Flush) && part.is_none() {
                return Ok(());
            }
            submit_command(ledger, kind, part).await
        });
    }

    /// Runs a query on the ledger, if it exists already.
    fn ask<T: Default>(&self, question: impl AsyncFnOnce(&Ledger) -> Result<T, ledger::LedgerError>) -> T {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let Ok(ledger) = Ledger::open_existing(&self.farm.root().join("state/nestd.db")).await else {
                return T::default();
            };
            let answer = question(&ledger).await;
            ledger.close().await;
            answer.unwrap_or_default()
        })
    }

    /// Takes the build files from the queue; no copy may come again.
    fn take_printed_builds(&mut self) {
        for (name, placed) in self.printer.take_builds(&self.farm, &mut self.broken) {
            for copy in placed.into_iter().map(|p| (p.part_number.unwrap(), p.copy.unwrap())) {
                if !self.copies.insert(copy.clone()) {
                    self.broken.push(format!("I2, {DOUBLED}: copy {copy:?} is in {name} and in an earlier build"));
                }
            }
        }
    }

    /// Without further kills: everything that was cancelled is taken back, and everything is built.
    fn run_to_the_end(mut self) -> SectionResult {
        self.farm.start();
        let began = Instant::now();
        while !self.is_done() {
            if began.elapsed() > Duration::from_secs(120) {
                let log = self.farm.log();
                let lines: Vec<&str> = log.lines().collect();
                let tail = lines[lines.len().saturating_sub(15)..].join("\n");
                self.broken.push(format!("not everything was built\n{tail}"));
                break;
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        self.farm.stop();
        self.take_printed_builds();
        let expectations = InvariantExpectations { at_rest: true, ..self.expectations.clone() };
        self.broken.extend(self.farm.broken_invariants(&expectations));
        let wanted: u32 = self.wanted.values().sum();
        if self.copies.len() as u32 != wanted {
            let kind = if (self.copies.len() as u32) < wanted { LOST } else { DOUBLED };
            self.broken.push(format!("I2, {kind}: {wanted} copies were asked, the printer got {}", self.copies.len()));
        }
        let seed = self.seed;
        SectionResult {
            files: self.dropped,
            builds: self.printer.taken.len() as u64,
            broken: self.broken.iter().map(|text| format!("farm {seed}: {text}")).collect(),
            ..SectionResult::default()
        }
    }

    /// Takes back cancelled parts and publishes waiting ones; returns whether everything is built and at rest.
    fn is_done(&mut self) -> bool {
        self.take_printed_builds();
        let wanted = self.wanted.clone();
        let built: Vec<PartRow> = self.ask(async |ledger| {
            let asked = ledger.pending_commands().await?;
            for part in ledger.parts_in_state(PartState::Refused).await? {
                let is_asked = asked.iter().any(|row| row.part_id == Some(part.id));
                if wanted.contains_key(&part.name) && !is_asked {
                    submit_command(ledger, CommandKind::Retry, Some(part.id)).await?;
                }
            }
            let waits = !ledger.parts_in_state(PartState::Waiting).await?.is_empty();
            if waits && !asked.iter().any(|row| row.kind == CommandKind::Flush) {
                submit_command(ledger, CommandKind::Flush, None).await?;
            }
            ledger.parts_in_state(PartState::Built).await
        });
        let built: BTreeMap<String, u32> = built.into_iter().map(|part| (part.name, part.owed.copies)).collect();
        let work = intake::list_claims(&self.farm.folder("inbox")).unwrap_or_default();
        built == self.wanted && work.claims.is_empty() && work.unfinished.is_empty() && self.are_bad_parts_refused()
    }

    fn are_bad_parts_refused(&self) -> bool {
        let refused = self.ask(async |ledger| ledger.parts_in_state(PartState::Refused).await).len();
        refused + self.wanted.len() == self.dropped as usize
    }
}

async fn submit_command(
    ledger: &Ledger,
    kind: CommandKind,
    part: Option<ledger::PartId>,
) -> Result<(), ledger::LedgerError> {
    let machine = if matches!(kind, CommandKind::Flush) { MACHINE.to_owned() } else { String::new() };
    ledger
        .submit_command(&NewCommand { kind, machine, part, argument: Default::default(), asked_by: "test".to_owned() })
        .await
        .map(drop)
}
