//! Code that several test programs share, above all a farm in a temporary folder, served by the real daemon.
#![allow(dead_code)] // no test program uses all of it

pub mod balancer;
pub mod entries;
pub mod farm_files;
pub mod greedy;
pub mod grid;
pub mod http;
pub mod manifest;
pub mod random;
pub mod samples;
pub mod small_disk;
pub mod smtp;
pub mod trace;
pub mod trial;
pub mod webhook;

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Child, Command, Output, Stdio},
    time::{Duration, Instant},
};

use farm::InvariantExpectations;
use ledger::{Ledger, PartRow, PartState};
use solids::Mesh;
use tempfile::TempDir;

use farm_files::{assert_each_copy_once, drop_file, list_build_files};
#[allow(unused_imports)] // no test program uses all of it
pub use farm_files::{block, leaning_block, stl};

pub const MACHINE: &str = "test";

/// A farm with one machine.
pub struct TestFarm {
    dir: TempDir,
    machine: String,
    daemon: Option<Child>,
}

/// The usual profile of a test: small volume, quick settling, short searches.
pub const QUICK: &str = "volume_mm = [120, 120, 120]\nclearance_mm = 2.0\nsettle_secs = 0.3\nunfinished_secs = 2\nfinal_secs = 0.5\n\
                         arrival_secs = 0.5\nmax_attempts = 50\n";

impl TestFarm {
    /// A farm with the machine `test`, whose file contains `profile`; the daemon does not run yet.
    pub fn new(profile: &str) -> Self {
        Self::with_machine(MACHINE, profile)
    }

    /// A farm with a machine of another name.
    pub fn with_machine(machine: &str, profile: &str) -> Self {
        let dir = TempDir::new().unwrap();
        fs::create_dir_all(dir.path().join("config/profiles")).unwrap();
        let farm = Self { dir, machine: machine.to_owned(), daemon: None };
        fs::write(farm.config(), "scan_secs = 0.5\norphan_ticket_secs = 3\n[log]\nfilter = \"info\"\n").unwrap();
        farm.write_profile(machine, profile);
        farm
    }

    /// A farm with the daemon running on it.
    pub fn running(profile: &str) -> Self {
        let mut farm = Self::new(profile);
        farm.start();
        farm
    }

    pub fn root(&self) -> &Path {
        self.dir.path()
    }

    pub fn config(&self) -> PathBuf {
        self.root().join("config/nestd.toml")
    }

    /// Writes the file of a machine. Open builds rest while they wait, unless the text says otherwise: many farms share the cores.
    pub fn write_profile(&self, name: &str, text: &str) {
        let rest = if text.contains("improve_secs") { "" } else { "improve_secs = 0\n" };
        let text = format!("{rest}{text}");
        fs::write(self.profile(name), text).unwrap();
    }

    /// The file of a machine.
    pub fn profile(&self, name: &str) -> PathBuf {
        self.root().join(format!("config/profiles/{name}.toml"))
    }

    pub fn folder(&self, kind: &str) -> PathBuf {
        self.root().join(kind).join(&self.machine)
    }

    pub fn start(&mut self) {
        self.start_as(self.command(&["run"]));
    }

    /// Starts the daemon with a limit of open files.
    pub fn start_with_open_files(&mut self, most: u32) {
        self.start_under(&format!("ulimit -n {most}"));
    }

    /// Starts the daemon with a limit of address space, bytes.
    pub fn start_with_memory(&mut self, most: u64) {
        // One malloc arena, because reserved address space counts as well.
        self.start_under(&format!("ulimit -v {}; export MALLOC_ARENA_MAX=1", most / 1024));
    }

    /// Restarts the daemon if it has ended by itself, as the service manager does.
    pub fn start_again_where_it_ended(&mut self, most: u64) -> bool {
        let has_ended = self.has_ended();
        if has_ended {
            self.daemon = None;
            self.start_with_memory(most);
        }
        has_ended
    }

    /// Whether the daemon has ended by itself.
    pub fn has_ended(&mut self) -> bool {
        self.daemon.as_mut().is_none_or(|child| child.try_wait().unwrap().is_some())
    }

    fn start_under(&mut self, words: &str) {
        let daemon = self.command(&["run"]);
        let mut command = Command::new("sh");
        command.arg("-c").arg(format!("{words}; exec \"$0\" \"$@\"")).arg(daemon.get_program());
        command.args(daemon.get_args()).current_dir(self.root()).env("NESTD_ALLOW_ROOT", "1");
        self.start_as(command);
    }

    pub fn start_as(&mut self, mut command: Command) {
        let log = fs::File::options().create(true).append(true).open(self.root().join("log")).unwrap();
        let child = command.stdout(Stdio::null()).stderr(log).spawn().unwrap();
        self.daemon = Some(child);
        let (inbox, file) = (self.folder("inbox"), self.profile(&self.machine));
        wait_until("the daemon makes its folders", 10.0, || inbox.is_dir() || !file.exists());
    }

    /// The process id of the daemon.
    pub fn pid(&self) -> i32 {
        self.daemon.as_ref().unwrap().id() as i32
    }

    pub fn kill(&mut self) {
        if let Some(mut child) = self.daemon.take() {
            child.kill().unwrap();
            child.wait().unwrap();
        }
    }

    /// SIGTERM; asserts a clean exit within the 15 s that the service manager gives.
    pub fn stop(&mut self) {
        let mut child = self.daemon.take().unwrap();
        signal(child.id() as i32, rustix::process::Signal::TERM);
        let began = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            assert!(began.elapsed() < Duration::from_secs(15), "the daemon does not stop\n{}", self.log());
            std::thread::sleep(Duration::from_millis(20));
        };
        assert!(status.success(), "the daemon ended with {status}\n{}", self.log());
    }

    pub fn reload(&self) {
        signal(self.pid(), rustix::process::Signal::HUP);
    }

    pub fn log(&self) -> String {
        fs::read_to_string(self.root().join("log")).unwrap_or_default()
    }

    pub fn command(&self, args: &[&str]) -> Command {
        // NESTD_BIN names an installed binary to be tested instead.
        let binary = std::env::var_os("NESTD_BIN").unwrap_or_else(|| env!("CARGO_BIN_EXE_nestd").into());
        let mut command = Command::new(binary);
        command.env("NESTD_ALLOW_ROOT", "1"); // the tests of a container run as root
        command.args(args).arg("-c").arg(self.config()).arg("--root").arg(self.root()).current_dir(self.root());
        command
    }

    pub fn nestd(&self, args: &[&str]) -> Output {
        self.command(args).output().unwrap()
    }

    /// Runs a command that must succeed; its standard output.
    pub fn nestd_ok(&self, args: &[&str]) -> String {
        let output = self.nestd(args);
        let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(output.status.success(), "nestd {args:?} ended with {}\n{out}\n{err}\n{}", output.status, self.log());
        out.into_owned()
    }

    /// Flushes the machine of the farm.
    pub fn flush(&self) {
        self.flush_machine(&self.machine);
    }

    /// Runs `nestd flush`. On a busy machine the answer may come later; a refusal fails the test.
    pub fn flush_machine(&self, machine: &str) {
        let output = self.nestd(&["flush", machine]);
        let output_text =
            String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() != Some(2) && !output_text.contains("Refused"), "{output_text}\n{}", self.log());
    }

    /// Drops a file as a careful sender does.
    pub fn drop_bytes(&self, name: &str, bytes: &[u8]) {
        drop_file(self.root(), &self.folder("inbox").join(name), bytes);
    }

    pub fn drop_part(&self, name: &str, mesh: &Mesh) {
        self.drop_bytes(name, &stl(mesh));
    }

    /// Drops a file into a hot folder on another file system.
    pub fn drop_across(&self, name: &str, mesh: &Mesh) {
        fs::write(self.folder("inbox").join(name), stl(mesh)).unwrap();
    }

    /// Runs a query on the ledger.
    pub fn query_ledger<T>(&self, question: impl AsyncFnOnce(&Ledger) -> T) -> T {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let began = Instant::now();
            let address = settings::load_settings(Some(&self.config()), Some(self.root()))
                .map_or_else(|_| (&self.root().join("state/nestd.db")).into(), |settings| settings.ledger);
            let ledger = loop {
                match Ledger::open_existing(&address).await {
                    Ok(ledger) => break ledger,
                    Err(error) => assert!(began.elapsed().as_secs() < 10, "{error}\n{}", self.log()),
                }
                tokio::time::sleep(Duration::from_millis(50)).await;
            };
            let answer = question(&ledger).await;
            ledger.close().await;
            answer
        })
    }

    /// The violations of the invariants.
    pub fn broken_invariants(&self, expectations: &InvariantExpectations) -> Vec<String> {
        let settings = settings::load_settings(Some(&self.config()), Some(self.root())).unwrap();
        let invariant_report =
            self.query_ledger(async |ledger| farm::check_invariants(&settings, ledger, expectations).await.unwrap());
        invariant_report.violations.iter().map(ToString::to_string).collect()
    }

    pub fn parts(&self, state: PartState) -> Vec<PartRow> {
        self.query_ledger(async |ledger| ledger.parts_in_state(state).await.unwrap())
    }

    /// The parts in all states, state by state.
    pub fn all_parts(&self) -> Vec<PartRow> {
        self.query_ledger(async |ledger| {
            let mut parts = Vec::new();
            for state in PartState::ALL {
                parts.extend(ledger.parts_in_state(state).await.unwrap());
            }
            parts
        })
    }

    pub fn wait_for_parts(&self, state: PartState, count: usize) -> Vec<PartRow> {
        let mut parts = Vec::new();
        wait_until_or(
            &format!("{count} parts are {state}"),
            60.0,
            || self.log(),
            || {
                parts = self.parts(state);
                parts.len() == count
            },
        );
        parts
    }

    /// The published build files in the queue.
    pub fn queued(&self) -> Vec<PathBuf> {
        list_build_files(&self.folder("queue"))
    }

    pub fn wait_for_queued(&self, count: usize) -> Vec<PathBuf> {
        wait_until_or(&format!("{count} builds in the queue"), 60.0, || self.log(), || self.queued().len() >= count);
        self.queued()
    }

    /// Asserts that the ledger is consistent, and that each published copy is in exactly one build file.
    pub fn assert_ledger_agrees(&self) {
        let faults = self.query_ledger(async |ledger| ledger.find_inconsistencies().await.unwrap());
        assert!(faults.is_empty(), "the ledger does not agree with itself: {faults:#?}");
    }

    pub fn assert_nothing_lost_or_doubled(&self) {
        self.assert_ledger_agrees();
        let built: usize = self.parts(PartState::Built).iter().map(|p| p.owed.copies as usize).sum();
        assert_each_copy_once(&self.queued(), built);
    }
}

impl Drop for TestFarm {
    fn drop(&mut self) {
        self.kill();
    }
}

pub fn signal(pid: i32, signal: rustix::process::Signal) {
    rustix::process::kill_process(rustix::process::Pid::from_raw(pid).unwrap(), signal).unwrap();
}

/// CPU seconds of a process so far, user and system time; also of one that has ended and nobody has waited for.
pub fn cpu_secs(pid: i32) -> f64 {
    const TICKS_PER_SEC: f64 = 100.0;
    let fields = stat_fields(pid);
    fields[11..13].iter().map(|field| field.parse::<f64>().unwrap()).sum::<f64>() / TICKS_PER_SEC
}

/// The fields of `/proc/PID/stat` behind the name of the program, from the state on.
pub fn stat_fields(pid: i32) -> Vec<String> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
    stat.rsplit_once(')').unwrap().1.split_whitespace().map(ToOwned::to_owned).collect()
}

pub fn wait_until(what: &str, secs: f64, is_true: impl FnMut() -> bool) {
    wait_until_or(what, secs, String::new, is_true);
}

pub fn wait_until_or(what: &str, secs: f64, describe: impl Fn() -> String, mut is_true: impl FnMut() -> bool) {
    let began = Instant::now();
    while !is_true() {
        assert!(began.elapsed().as_secs_f64() < secs, "waited {secs} s in vain until {what}\n{}", describe());
        std::thread::sleep(Duration::from_millis(50));
    }
}
