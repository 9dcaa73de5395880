//! A farm that a test controls step by step: it has real folders, a real ledger and real job threads, but no separate
//! process, no event loop and no waiting. Its clocks move only when the test advances them.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use jiff::SignedDuration;
use ledger::{
    BuildState, CommandId, CommandKind, CommandRow, Ledger, LedgerError, NewCommand, OperatorWord, PartId, PartRow,
    PartState, WordAnswer,
};
use settings::MachineProfile;
use solids::Mesh;
use tempfile::TempDir;
use tokio::runtime::{Builder, Runtime};

use super::super::{AlertKind, InvariantExpectations, QuoteMeshes, ReconcileReport};
use crate::{
    core::{farm::Farm, job_events},
    decisions::layout::CopyId,
    operate::operate::operate,
    process::time_source::{ClockHands, TimeSource},
    records::invariants,
    recover::restore::{repair_ledger, restore_ledger},
    run::{event_loop, open::open_farm, reload},
};

#[path = "../../../../tests/support/farm_files.rs"]
pub mod farm_files;
mod searches;

use farm_files::{assert_each_copy_once, drop_file, list_build_files};
pub use farm_files::{block, stl};

/// The machine of these tests.
pub const MACHINE: &str = "test";
/// The default profile of the tests: small volume, quick settling, short searches.
pub const QUICK: &str = "volume_mm = [120, 120, 120]\nclearance_mm = 2.0\nsettle_secs = 0.3\nunfinished_secs = 2\nfinal_secs = 0.05\n\
                         arrival_secs = 0.05\nimprove_secs = 0\nmax_attempts = 50\n";
/// Time by which the clocks advance between two ticks.
const STEP: Duration = Duration::from_millis(250);
/// Maximum number of ticks to wait for a condition.
const MOST_TICKS: usize = 480;
/// Real time that jobs have between two ticks while they are not waited for.
const MOMENT: Duration = Duration::from_millis(50);
/// Maximum number of these.
const MOST_MOMENTS: usize = 2400;
/// Maximum real time to wait for jobs. No job takes as long as a second.
const JOBS_END_WITHIN: Duration = Duration::from_secs(120);

/// A farm with one machine, `test`.
pub struct HandDrivenFarm {
    dir: TempDir,
    hands: ClockHands,
    time: TimeSource,
    runtime: Runtime,
    farm: Option<Farm>,
}

impl HandDrivenFarm {
    /// A farm that is not open yet. `profile` is the text of its machine's profile file.
    pub fn closed(profile: &str) -> Self {
        let dir = TempDir::new().unwrap();
        fs::create_dir_all(dir.path().join("config/profiles")).unwrap();
        // A farm sets the umask of its whole process. This mode keeps the usual umask for the other tests.
        let config = "scan_secs = 0.5\norphan_ticket_secs = 3\n[files]\nmode = \"0644\"\n";
        fs::write(dir.path().join("config/nestd.toml"), config).unwrap();
        let (hands, time) = ClockHands::make();
        let runtime = Builder::new_multi_thread().worker_threads(2).enable_all().build().unwrap();
        let farm = Self { dir, hands, time, runtime, farm: None };
        farm.write_profile(MACHINE, profile);
        farm
    }

    /// A farm that is open.
    pub fn open(profile: &str) -> Self {
        let mut farm = Self::closed(profile);
        farm.start();
        farm
    }

    /// Opens it, as the daemon does at its start.
    pub fn start(&mut self) {
        self.farm = Some(self.try_to_open().map_err(|failure| format!("{failure:#}")).unwrap());
        self.tick();
    }

    /// Why it does not open.
    pub fn start_failure(&self) -> anyhow::Error {
        self.try_to_open().err().unwrap()
    }

    fn try_to_open(&self) -> anyhow::Result<Farm> {
        let (config, root) = (self.root().join("config/nestd.toml"), self.root().to_owned());
        let load = Box::new(move || settings::load_settings(Some(&config), Some(&root)));
        let settings = load().unwrap();
        let opened = self.runtime.block_on(open_farm(load, settings, self.time.clone(), &mut None));
        opened.map_err(|(_, _, failure)| failure)
    }

    /// Closes it in an orderly way.
    pub fn stop(&mut self) {
        let mut farm = self.farm.take().unwrap();
        self.runtime.block_on(event_loop::shut_down(&mut farm));
    }

    /// Repairs the ledger of a closed farm from its folders.
    pub fn repair(&self) -> ReconcileReport {
        let settings =
            settings::load_settings(Some(&self.root().join("config/nestd.toml")), Some(self.root())).unwrap();
        self.runtime.block_on(repair_ledger(&settings, &[])).unwrap()
    }

    /// A backup of the ledger as it is now.
    pub fn write_backup(&self, name: &str) -> PathBuf {
        let backup = self.root().join(name);
        self.ask(async |ledger| ledger.write_backup(&backup).await.unwrap());
        backup
    }

    /// Puts a backup in place of the ledger of a closed farm.
    pub fn restore(&self, backup: &Path) -> ReconcileReport {
        let settings =
            settings::load_settings(Some(&self.root().join("config/nestd.toml")), Some(self.root())).unwrap();
        self.runtime.block_on(restore_ledger(&settings, Some(backup), &[])).unwrap().reconciled
    }

    /// Reads the configuration again.
    pub fn reload(&mut self) {
        self.runtime.block_on(reload::reload_configuration(self.farm.as_mut().unwrap()));
        self.tick();
    }

    /// Runs one tick. The jobs that it starts go on, and what they end with is not taken in yet.
    pub fn begin_tick(&mut self) {
        self.runtime.block_on(event_loop::run_tick(self.farm.as_mut().unwrap()));
    }

    /// Sets the wall clock, as a person does, and not the clock that only passes.
    pub fn set_wall_clock_by(&self, jump: SignedDuration) {
        self.hands.set_wall_clock_by(jump);
    }

    /// Runs one tick, and waits until all jobs have ended.
    pub fn tick(&mut self) {
        self.begin_tick();
        self.await_jobs();
    }

    /// Waits until all jobs have ended, and takes in what they end with.
    pub fn await_jobs(&mut self) {
        let farm = self.farm.as_mut().unwrap();
        self.runtime.block_on(job_events::wait_for_jobs(farm, Instant::now() + JOBS_END_WITHIN));
        assert!(farm.jobs.is_idle(), "a job does not end");
    }

    /// Advances the clocks and runs ticks meanwhile. Over a long time, the ticks are less frequent.
    pub fn pass_secs(&mut self, secs: f64) {
        let step = if secs < 10.0 { STEP } else { 4 * STEP };
        for _ in 0..(secs / step.as_secs_f64()).ceil() as usize {
            self.hands.pass(step);
            self.tick();
        }
    }

    /// Advances the clocks a little and runs a tick. Jobs that take longer than a moment go on.
    fn pass_moment(&mut self) {
        self.hands.pass(STEP);
        self.begin_tick();
        let farm = self.farm.as_mut().unwrap();
        self.runtime.block_on(job_events::wait_for_jobs(farm, Instant::now() + MOMENT));
    }

    /// Advances the clocks until a condition holds, while long jobs go on. Panics after some minutes.
    pub fn pass_moments_until(&mut self, what: &str, mut holds: impl FnMut(&Self) -> bool) {
        for _ in 0..MOST_MOMENTS {
            if holds(self) {
                return;
            }
            self.pass_moment();
        }
        panic!("it does not come to pass that {what}");
    }

    /// Advances the clocks at once by a long time, and then runs ticks, a second apart, until no file is read and no build
    /// is made.
    pub fn jump(&mut self, time: Duration) {
        self.hands.pass(time);
        self.tick();
        for _ in 0..MOST_TICKS {
            if !self.is_making() {
                return;
            }
            self.hands.pass(4 * STEP);
            self.tick();
        }
    }

    /// Whether files are read, builds are made, or commands wait for their answer.
    fn is_making(&self) -> bool {
        self.ask(async |ledger| {
            let mut making = ledger.pending_commands().await.unwrap().len();
            making += ledger.parts_in_state(PartState::Claimed).await.unwrap().len();
            for state in [BuildState::Nesting, BuildState::Verified] {
                making += ledger.builds_in_state(state).await.unwrap().len();
            }
            making > 0
        })
    }

    /// The profiles of the machines.
    pub fn profiles(&self) -> &BTreeMap<String, MachineProfile> {
        &self.farm.as_ref().unwrap().settings.profiles
    }

    /// The meshes of its waiting parts, as a quote in another process reads them.
    pub fn quote_meshes(&self) -> QuoteMeshes {
        QuoteMeshes::of_farm(&self.farm.as_ref().unwrap().settings)
    }

    /// The date by the farm's clock.
    pub fn date(&self) -> jiff::Timestamp {
        self.time.date()
    }

    /// Advances the clocks until a condition holds. Panics after two minutes of test time.
    pub fn pass_until(&mut self, what: &str, mut holds: impl FnMut(&Self) -> bool) {
        for _ in 0..MOST_TICKS {
            if holds(self) {
                return;
            }
            self.pass_secs(STEP.as_secs_f64());
        }
        let farm = self.farm.as_ref().unwrap();
        let alerts: Vec<String> = farm.alerts.active_alerts().map(|alert| alert.alert_text()).collect();
        let failures = &farm.nesting.failures;
        panic!("it does not come to pass that {what}; alerts: {alerts:#?}, failures of builds: {failures:#?}");
    }

    /// Whether an alert of this kind is active.
    pub fn has_alert(&self, kind: AlertKind) -> bool {
        self.farm.as_ref().unwrap().alerts.active_alerts().any(|alert| alert.kind == kind)
    }

    /// What the active alerts of a kind say.
    pub fn alert_text(&self, kind: AlertKind) -> String {
        let alerts = self.farm.as_ref().unwrap().alerts.active_alerts();
        alerts.filter(|alert| alert.kind == kind).map(|alert| alert.alert_text()).collect()
    }

    pub fn root(&self) -> &Path {
        self.dir.path()
    }

    pub fn folder(&self, kind: &str) -> PathBuf {
        self.folder_of(kind, MACHINE)
    }

    /// A folder of any machine.
    pub fn folder_of(&self, kind: &str, machine: &str) -> PathBuf {
        self.root().join(kind).join(machine)
    }

    pub fn write_profile(&self, name: &str, text: &str) {
        fs::write(self.root().join(format!("config/profiles/{name}.toml")), text).unwrap();
    }

    /// Sets the number of threads for nesting, which takes effect at the start.
    pub fn write_threads(&self, threads: usize) {
        let file = self.root().join("config/nestd.toml");
        let text = fs::read_to_string(&file).unwrap();
        fs::write(file, format!("threads = {threads}\n{text}")).unwrap();
    }

    /// Sets the time zone of the farm, which takes effect at the start or a reload.
    pub fn write_time_zone(&self, name: &str) {
        let file = self.root().join("config/nestd.toml");
        let text = fs::read_to_string(&file).unwrap();
        let others = text.lines().filter(|line| !line.starts_with("time_zone"));
        let text = format!("time_zone = \"{name}\"\n{}\n", others.collect::<Vec<_>>().join("\n"));
        fs::write(file, text).unwrap();
    }

    /// Drops a file as a careful sender does.
    pub fn drop_bytes(&self, name: &str, bytes: &[u8]) {
        drop_file(self.root(), &self.folder("inbox").join(name), bytes);
    }

    pub fn drop_part(&self, name: &str, mesh: &Mesh) {
        self.drop_bytes(name, &stl(mesh));
    }

    /// Gives the daemon a command.
    pub fn order(&self, kind: CommandKind, part: Option<PartId>) -> CommandId {
        let machine = if part.is_some() { String::new() } else { MACHINE.to_owned() };
        let command = NewCommand { kind, machine, part, argument: Default::default(), asked_by: "a@test".to_owned() };
        self.submit_command(&command)
    }

    /// Gives the daemon a command of anybody.
    pub fn submit_command(&self, command: &NewCommand) -> CommandId {
        self.ask(async |ledger| ledger.submit_command(command).await.unwrap())
    }

    /// Gives the daemon a command and advances the clocks until it is answered.
    pub fn order_and_wait(&mut self, kind: CommandKind, part: Option<PartId>) -> CommandRow {
        let id = self.order(kind, part);
        let answer = |farm: &Self| farm.ask(async |ledger| ledger.find_command(id).await.unwrap().unwrap());
        self.pass_until("the order is answered", |farm| answer(farm).answered_at.is_some());
        answer(self)
    }

    /// Runs a query on the ledger.
    pub fn ask<T>(&self, question: impl AsyncFnOnce(&Ledger) -> T) -> T {
        self.runtime.block_on(question(&self.farm.as_ref().unwrap().ledger))
    }

    /// Says a word of a person, as every face does.
    pub fn say(&self, word: &OperatorWord, anyway: bool) -> Result<WordAnswer, LedgerError> {
        let settings = &self.farm.as_ref().unwrap().settings;
        self.ask(async |ledger| operate(ledger, settings, word, "ann@farm", anyway).await)
    }

    pub fn parts(&self, state: PartState) -> Vec<PartRow> {
        self.ask(async |ledger| ledger.parts_in_state(state).await.unwrap())
    }

    pub fn wait_for_parts(&mut self, state: PartState, count: usize) -> Vec<PartRow> {
        self.pass_until(&format!("{count} parts are {state}"), |farm| farm.parts(state).len() == count);
        self.parts(state)
    }

    /// The copies that stand in the open build.
    pub fn open_copies(&self) -> BTreeSet<CopyId> {
        self.farm.as_ref().unwrap().machines[MACHINE].open.standing.clone()
    }

    /// What `STATUS.txt` says next.
    pub fn status_text(&self) -> String {
        self.farm.as_ref().unwrap().machines[MACHINE].status.0.clone()
    }

    pub fn status_text_of(&self, machine: &str) -> String {
        self.farm.as_ref().unwrap().machines[machine].status.0.clone()
    }

    /// What `status.json` says next.
    pub fn status_json(&self) -> serde_json::Value {
        self.farm.as_ref().unwrap().machines[MACHINE].status.1.clone()
    }

    /// Why it has halted, as the pages say it.
    pub fn halt_reason(&self) -> String {
        self.farm.as_ref().unwrap().lifecycle.services.halt_reason().unwrap_or_default()
    }

    /// The published build files in the queue.
    pub fn queued(&self) -> Vec<PathBuf> {
        list_build_files(&self.folder("queue"))
    }

    pub fn wait_for_queued(&mut self, count: usize) -> Vec<PathBuf> {
        self.pass_until(&format!("{count} builds are in the queue"), |farm| farm.queued().len() >= count);
        self.queued()
    }

    /// Asserts that the ledger is consistent and agrees with the folders, and that each published copy is in exactly
    /// one build file.
    pub fn assert_nothing_lost_or_doubled(&self) {
        self.assert_ledger_agrees_with_folders();
        self.assert_each_copy_is_queued_once();
    }

    /// Asserts that the ledger is consistent and agrees with the folders.
    pub fn assert_ledger_agrees_with_folders(&self) {
        let faults = self.ask(async |ledger| ledger.find_inconsistencies().await.unwrap());
        assert!(faults.is_empty(), "the ledger does not agree with itself: {faults:#?}");
        assert_eq!(self.violations(), [""; 0]);
    }

    /// What breaks an invariant.
    pub fn violations(&self) -> Vec<String> {
        let settings = &self.farm.as_ref().unwrap().settings;
        let report = self.ask(async |ledger| {
            invariants::check_invariants(settings, ledger, &InvariantExpectations::default()).await.unwrap()
        });
        report.violations.iter().map(ToString::to_string).collect()
    }

    fn assert_each_copy_is_queued_once(&self) {
        let built: usize = self.parts(PartState::Built).iter().map(|p| p.wanted_copies() as usize).sum();
        assert_each_copy_once(&self.queued(), built);
    }
}
