//! The reference life-cycle: parts with a ticket, an order list and an order folder are dropped; one is cancelled and
//! taken back, one is refused; the batch is flushed, nested, written, published, archived and taken by the printer.
//! When the daemon is killed, the script continues at the same step.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    time::{Duration, Instant},
};

use farm::InvariantExpectations;
use ledger::{BuildState, CommandId, CommandKind, CommandState, Ledger, NewCommand, PartRow, PartState};

use crate::support::{MACHINE, TestFarm, block, stl};

/// How a part of the script ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScriptEnd {
    /// The whole script is done.
    Done,
    /// The daemon is gone.
    DaemonEnded,
    /// It took too long.
    Stuck,
}

/// Everything is as short as the configuration allows.
pub const FARM: &str = "scan_secs = 0.2\ncache_bytes = 0\nthreads = 1\n[log]\nfilter = \"info\"\n";
const PROFILE: &str = "volume_mm = [60, 60, 60]\nclearance_mm = 2.0\nsettle_secs = 0.05\nunfinished_secs = 0.5\n\
    final_secs = 0.05\narrival_secs = 0.05\nduplicates = \"accept\"\nmax_attempts = 100\n";
/// A machine on which much goes on: it builds as soon as eight copies wait.
pub const BUSY_MACHINE: &str = "volume_mm = [120, 120, 120]\nclearance_mm = 2.0\nsettle_secs = 0.05\nunfinished_secs = 0.5\n\
    final_secs = 0.1\narrival_secs = 0.1\nduplicates = \"accept\"\nmax_attempts = 100\n[trigger]\ncopies = 8\n";
/// The parts that are printed, with their copies.
const PRINTED: [(&str, u32); 3] = [("ring.stl", 2), ("plate.stl", 3), ("lid.stl", 1)];
const FOREIGN: &str = "a colleague's notes.tmp";

/// The steps of the script.
const STEPS: [ScriptStep; 7] = [
    ScriptStep::Drop,
    ScriptStep::AwaitReading,
    ScriptStep::Cancel("lid.stl"),
    ScriptStep::Retry("lid.stl", PartState::Waiting),
    ScriptStep::Retry("bad.stl", PartState::Refused),
    ScriptStep::Flush,
    ScriptStep::AwaitQuiet,
];

#[derive(Debug, Clone, Copy)]
enum ScriptStep {
    Drop,
    AwaitReading,
    Cancel(&'static str),
    Retry(&'static str, PartState),
    Flush,
    AwaitQuiet,
}

/// A farm with the shortest times; its daemon does not run yet.
pub fn quick_farm(machine: &str) -> TestFarm {
    let farm = TestFarm::new(machine);
    fs::write(farm.config(), FARM).unwrap();
    farm
}

/// A farm on which the script runs.
pub struct LifeCycle {
    pub farm: TestFarm,
    /// What the script knows independently of the ledger.
    pub expectations: InvariantExpectations,
    /// Violations that were found.
    pub broken: Vec<String>,
    /// Build files that the printer has taken.
    pub taken: BTreeSet<String>,
    at: usize,
    command: Option<CommandId>,
    commanded_at: Instant,
    /// The script continues when the daemon refuses something because of an injected fault.
    pub timeout: Duration,
    /// Nothing is cancelled and taken back.
    skips_orders: bool,
}

impl LifeCycle {
    pub fn new() -> Self {
        Self::with("")
    }

    /// With additional lines in the machine file.
    pub fn with(more: &str) -> Self {
        Self {
            farm: quick_farm(&format!("{PROFILE}{more}")),
            expectations: InvariantExpectations::default(),
            broken: Vec::new(),
            taken: BTreeSet::new(),
            at: 0,
            command: None,
            commanded_at: Instant::now(),
            timeout: Duration::from_secs(60),
            skips_orders: false,
        }
    }

    /// A life-cycle whose parts were dropped by the caller, who passes the expectations; the script only waits for the
    /// build.
    pub fn after_dropping(more: &str, expectations: InvariantExpectations) -> Self {
        let mut life = Self::with(more);
        let foreign = life.farm.folder("inbox").join(FOREIGN);
        life.expectations = InvariantExpectations {
            untouched: expectations.untouched.into_iter().map(|(_, hash)| (foreign.clone(), hash)).collect(),
            ..expectations
        };
        life.at = STEPS.iter().position(|step| matches!(step, ScriptStep::AwaitReading)).unwrap();
        life.skips_orders = true;
        life
    }

    /// Waits until a daemon that was started serves.
    pub fn wait_for_sign_of_life(&self) {
        let pid = self.farm.pid() as u32;
        let serves = || {
            self.farm
                .query_ledger(async |ledger| ledger.find_node("").await)
                .is_ok_and(|d| d.is_some_and(|d| d.pid == pid))
        };
        crate::support::wait_until("the daemon gives a sign of life", 20.0, serves);
    }

    /// Continues the script while the daemon with this process id runs.
    pub fn play(&mut self, pid: i32, has_ended: &mut dyn FnMut() -> bool) -> ScriptEnd {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let began = Instant::now();
            let mut ledger = None;
            let end = loop {
                if has_ended() {
                    break ScriptEnd::DaemonEnded;
                }
                if began.elapsed() > self.timeout {
                    break ScriptEnd::Stuck;
                }
                if ledger.is_none() {
                    ledger = Ledger::open_existing(&self.farm.root().join("state/nestd.db")).await.ok();
                }
                if let Some(ledger) = &ledger
                    && self.is_serving(ledger, pid).await
                    && self.step(ledger).await.unwrap_or(false)
                {
                    self.at += 1;
                    self.command = None;
                    if self.at == STEPS.len() {
                        break ScriptEnd::Done;
                    }
                    continue;
                }
                tokio::time::sleep(Duration::from_millis(20)).await;
            };
            if let Some(ledger) = ledger {
                ledger.close().await;
            }
            end
        })
    }

    /// Whether the daemon is past its start.
    async fn is_serving(&self, ledger: &Ledger, pid: i32) -> bool {
        let is_it = |daemon: Option<ledger::NodeRow>| daemon.is_some_and(|row| row.pid == pid as u32);
        self.farm.folder("archive").is_dir() && ledger.find_node("").await.is_ok_and(is_it)
    }

    /// Whether the step is done.
    async fn step(&mut self, ledger: &Ledger) -> Result<bool, ledger::LedgerError> {
        match STEPS[self.at] {
            ScriptStep::Drop => {
                self.drop_all();
                Ok(true)
            }
            ScriptStep::AwaitReading | ScriptStep::Cancel(_) | ScriptStep::Retry(..) if self.skips_orders => Ok(true),
            ScriptStep::AwaitReading => {
                let waiting = ledger.parts_in_state(PartState::Waiting).await?.len();
                Ok(waiting == PRINTED.len() && !ledger.parts_in_state(PartState::Refused).await?.is_empty())
            }
            ScriptStep::Cancel(name) => {
                self.order(ledger, CommandKind::Cancel, name).await?;
                Ok(part(ledger, name).await?.state == PartState::Refused)
            }
            ScriptStep::Retry(name, then) => {
                let answered = self.order(ledger, CommandKind::Retry, name).await?;
                Ok(answered && part(ledger, name).await?.state == then)
            }
            ScriptStep::Flush => self.flush(ledger).await,
            ScriptStep::AwaitQuiet => Ok(self.is_quiet()),
        }
    }

    pub fn drop_all(&mut self) {
        let files: [(&str, Vec<u8>); 4] = [
            ("ring.stl", stl(&block(10.0, 12.0, 5.0))),
            ("plate.stl", stl(&block(20.0, 5.0, 3.0))),
            ("kit/lid.stl", stl(&block(6.0, 6.0, 6.0))),
            ("bad.stl", b"solid nonsense\nendsolid\n".to_vec()),
        ];
        self.farm.drop_bytes("ring.stl.toml", b"copies = 2\norder = \"K-17\"\n");
        self.farm.drop_bytes("order.csv", b"file,copies\nplate.stl,3\nbad.stl,1\n");
        self.farm.drop_bytes(FOREIGN, b"not nestd's");
        let foreign = self.farm.folder("inbox").join(FOREIGN);
        self.expectations.untouched.push((foreign.clone(), intake::hash_file(&foreign).unwrap()));
        for (name, bytes) in files {
            *self.expectations.dropped.entry(blake3::hash(&bytes).to_hex().to_string()).or_default() += 1;
            self.farm.drop_bytes(name, &bytes);
        }
    }

    /// Sends a command once; returns whether it was answered.
    async fn order(&mut self, ledger: &Ledger, kind: CommandKind, about: &str) -> Result<bool, ledger::LedgerError> {
        let Some(id) = self.command else {
            let (machine, part) = match kind {
                CommandKind::Flush => (about.to_owned(), None),
                _ => (String::new(), Some(part(ledger, about).await?.id)),
            };
            let command = NewCommand { kind, machine, part, argument: Default::default(), asked_by: "test".to_owned() };
            self.command = Some(ledger.submit_command(&command).await?);
            self.commanded_at = Instant::now();
            return Ok(false);
        };
        Ok(ledger.find_command(id).await?.is_some_and(|row| row.state != CommandState::Asked))
    }

    /// Sends `flush` until everything is built: copies that found no place need another build.
    async fn flush(&mut self, ledger: &Ledger) -> Result<bool, ledger::LedgerError> {
        let answered = self.order(ledger, CommandKind::Flush, MACHINE).await?;
        self.take_as_a_printer_does();
        if ledger.parts_in_state(PartState::Built).await?.len() == PRINTED.len() {
            return Ok(true);
        }
        let nesting = ledger.builds_in_state(BuildState::Nesting).await?.len();
        if answered && nesting == 0 && self.commanded_at.elapsed() > Duration::from_secs(2) {
            self.command = None;
        }
        Ok(false)
    }

    /// Whether no work is in progress any more; the check at rest reports leftovers.
    fn is_quiet(&mut self) -> bool {
        self.take_as_a_printer_does();
        let inbox = self.farm.folder("inbox");
        let work = intake::list_claims(&inbox).unwrap_or_default();
        work.claims.is_empty() && work.unfinished.is_empty() && !inbox.join("order.csv").exists()
    }

    /// Takes each build file as soon as it appears, as a printer does; no file name may come again.
    pub fn take_as_a_printer_does(&mut self) {
        for file in self.farm.queued() {
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            let to = self.farm.root().join("taken").join(&name);
            fs::create_dir_all(to.parent().unwrap()).unwrap();
            if !self.taken.insert(name.clone()) {
                self.broken.push(format!("I3: {name} appeared in the queue again after the printer had taken it"));
            }
            let _ = fs::rename(file, to);
        }
    }

    /// The current step of the script.
    pub fn step_name(&self) -> String {
        format!("{:?}", STEPS[self.at])
    }

    /// Collects violations while work may be in progress.
    pub fn check_after_crash(&mut self) {
        if self.farm.root().join("state/nestd.db").exists() && self.at > 0 {
            let found = self.try_invariants(&self.expectations.clone());
            self.broken.extend(found);
        }
    }

    /// Returns nothing when the ledger has no schema yet, after an early crash.
    fn try_invariants(&self, expectations: &InvariantExpectations) -> Vec<String> {
        let settings = settings::load_settings(Some(&self.farm.config()), Some(self.farm.root())).unwrap();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let Ok(ledger) = Ledger::open_existing(&settings.ledger).await else { return Vec::new() };
            let invariant_report = farm::check_invariants(&settings, &ledger, expectations).await.unwrap();
            ledger.close().await;
            invariant_report.violations.iter().map(ToString::to_string).collect()
        })
    }

    /// After the script has ended and the daemon was stopped: collects violations, and checks that everything was done.
    pub fn check_at_rest(&mut self) {
        self.take_as_a_printer_does();
        let expectations = InvariantExpectations { at_rest: true, ..self.expectations.clone() };
        self.broken.extend(self.farm.broken_invariants(&expectations));
        let built: BTreeMap<String, u32> =
            self.farm.parts(PartState::Built).into_iter().map(|part| (part.name, part.owed.copies)).collect();
        let asked: BTreeMap<String, u32> = PRINTED.iter().map(|&(name, copies)| (name.to_owned(), copies)).collect();
        if built != asked {
            self.broken.push(format!("I2: built are {built:?}, asked were {asked:?}"));
        }
        self.compare_taken_copies();
        let lists = self.farm.folder("archive").join("order-lists/order.csv");
        if !lists.exists() {
            self.broken.push(format!("I1: the order list is not at {}", lists.display()));
        }
    }

    /// Checks that the files that the printer took hold each copy exactly once.
    fn compare_taken_copies(&mut self) {
        let mut copies = Vec::new();
        for name in &self.taken {
            let file = self.farm.root().join("taken").join(name);
            match build_file::read_build(&file, &Default::default()) {
                Ok(placed) => copies.extend(placed.into_iter().map(|p| (p.part_number, p.copy))),
                Err(error) => self.broken.push(format!("I3: {name} was published and cannot be read: {error}")),
            }
        }
        let distinct: BTreeSet<_> = copies.iter().cloned().collect();
        let asked: u32 = PRINTED.iter().map(|(_, copies)| copies).sum();
        if distinct.len() != copies.len() || copies.len() as u32 != asked {
            self.broken.push(format!("I2: the printer got {} copies of {asked}: {copies:?}", copies.len()));
        }
    }

    /// Runs the daemon normally until the script is done, then checks at rest.
    pub fn run_to_the_end(&mut self) {
        self.farm.start();
        let end = self.play(self.farm.pid(), &mut || false);
        if end != ScriptEnd::Done {
            let log: String = self.farm.log();
            let tail: Vec<&str> = log.lines().rev().take(15).collect();
            let (step, tail) = (STEPS[self.at], tail.into_iter().rev().collect::<Vec<_>>().join("\n"));
            let left = intake::files_below(&self.farm.folder("inbox")).unwrap_or_default();
            self.broken.push(format!(
                "the script ended as {end:?} at the step {step:?}; in the hot folder stand {left:?}; the log ends with\n{tail}"
            ));
            self.farm.kill();
            return;
        }
        self.farm.stop();
        self.check_at_rest();
    }
}

async fn part(ledger: &Ledger, name: &str) -> Result<PartRow, ledger::LedgerError> {
    Ok(ledger.parts_named(name).await?.pop().expect("a part of this name was recorded before"))
}
