//! Folders that respond slowly, for example a network share, a failing disk, or a copy of 2 GiB. The event loop feeds
//! the watchdog and serves all machines, so it never accesses the files of a machine. Only job threads do this, and
//! only they wait.

use std::{
    collections::HashSet,
    fs,
    os::unix::net::UnixDatagram,
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use ledger::{PartRow, PartState};

use crate::support::{
    MACHINE, QUICK, TestFarm, block, signal, stl,
    trace::{CallVerdict, CallWatcher, SystemCall, TracedDaemon, is_allowed},
    wait_until_or,
};

const SECOND: &str = "second";
/// Duration of a slow call.
const SLOW: Duration = Duration::from_secs(6);
/// Maximum time between two signs of life. The loop sends one every 0.5 s, but on a busy machine the ledger may wait
/// for the disk.
const LONGEST_SILENCE: Duration = Duration::from_secs(5);

/// The observed system calls of a daemon.
#[derive(Clone, Default)]
struct SeenCalls {
    is_watched: Arc<AtomicBool>,
    by_the_loop: Arc<Mutex<Vec<String>>>,
    slowed: Arc<Mutex<Vec<String>>>,
}

/// Delays the first rename, unlink and copy call in each of the `slow` folders. Records the calls of the event loop in
/// all folders of machines.
struct SlowFolders {
    root: PathBuf,
    slow: &'static [&'static str],
    /// Calls that were delayed, each with its folder.
    known: HashSet<(&'static str, &'static str)>,
    seen: SeenCalls,
}

/// Folders with files of machines. They may be network shares, or contain large files.
const FOLDERS: [&str; 6] = ["inbox", "queue", "error", "archive", "state/store", "state/damaged"];

impl CallWatcher for SlowFolders {
    fn before(&mut self, call: &SystemCall) -> CallVerdict {
        let Ok(path) = call.path.strip_prefix(&self.root) else { return CallVerdict::Let };
        if !self.seen.is_watched.load(Ordering::SeqCst) {
            return CallVerdict::Let;
        }
        let call_text = format!("{} {}", call.name, path.display());
        // The event loop is the first thread of the process.
        if call.thread == call.pid && FOLDERS.iter().any(|folder| path.starts_with(folder)) {
            self.seen.by_the_loop.lock().unwrap().push(call_text.clone());
        }
        let is_long = matches!(call.name, "rename" | "unlink" | "copy_file_range");
        let folder = self.slow.iter().find(|folder| is_long && path.starts_with(folder));
        match folder.is_some_and(|folder| self.known.insert((call.name, folder))) {
            true => {
                self.seen.slowed.lock().unwrap().push(call_text);
                CallVerdict::Delay(SLOW)
            }
            false => CallVerdict::Let,
        }
    }

    fn after(&mut self, _: &SystemCall, _: i64) -> bool {
        true
    }
}

/// A farm with two machines whose daemon is traced, and the messages of the daemon to the service manager.
struct TracedFarm {
    farm: TestFarm,
    seen: SeenCalls,
    daemon: Option<TracedDaemon<SlowFolders>>,
    alive: Arc<Mutex<Vec<Instant>>>,
}

impl TracedFarm {
    fn new() -> Self {
        let farm = TestFarm::new(QUICK);
        farm.write_profile(SECOND, QUICK);
        Self { farm, seen: SeenCalls::default(), daemon: None, alive: Arc::default() }
    }

    /// Starts the daemon and waits until its loop runs. From then on, its calls are observed.
    fn start(&mut self, slow: &'static [&'static str]) {
        let socket = self.farm.root().join("notify");
        let _ = fs::remove_file(&socket);
        let listener = UnixDatagram::bind(&socket).unwrap();
        let alive = self.alive.clone();
        std::thread::spawn(move || {
            let mut message = [0; 1024];
            while let Ok(length) = listener.recv(&mut message) {
                if message[..length].windows(8).any(|words| words == b"WATCHDOG") {
                    alive.lock().unwrap().push(Instant::now());
                }
            }
        });
        let mut command = self.farm.command(&["run"]);
        command.env("NOTIFY_SOCKET", socket);
        let watch =
            SlowFolders { root: self.farm.root().to_owned(), slow, known: HashSet::new(), seen: self.seen.clone() };
        let before = self.farm.log().matches("The farm is open").count();
        self.daemon = Some(TracedDaemon::start(command, self.farm.root(), watch).unwrap());
        self.wait_for("the farm is open", || self.farm.log().matches("The farm is open").count() > before);
        self.seen.is_watched.store(true, Ordering::SeqCst);
    }

    fn stop(&mut self) {
        self.seen.is_watched.store(false, Ordering::SeqCst);
        let (_, in_time) = self.daemon.take().unwrap().stop();
        assert!(in_time, "the daemon does not stop\n{}", self.farm.log());
    }

    fn wait_for(&self, what: &str, holds: impl FnMut() -> bool) {
        wait_until_or(what, 90.0, || self.farm.log(), holds);
    }

    fn part(&self, state: PartState, name: &str) -> Option<PartRow> {
        self.farm.parts(state).into_iter().find(|part| part.name == name)
    }

    fn drop_at_second(&self, name: &str, bytes: &[u8]) {
        let outside = self.farm.root().join("sending");
        fs::write(&outside, bytes).unwrap();
        fs::rename(outside, self.farm.root().join("inbox").join(SECOND).join(name)).unwrap();
    }

    fn stored(&self, part: &PartRow) -> PathBuf {
        self.farm.root().join("state/store").join(&part.file.content_hash[..2]).join(&part.file.content_hash)
    }

    /// The longest time between two signs of life since a moment.
    fn longest_silence(&self, since: Instant) -> Duration {
        let mut times = vec![since];
        times.extend(self.alive.lock().unwrap().iter().copied().filter(|at| *at > since));
        times.push(Instant::now());
        times.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap()
    }
}

fn the_event_loop_touches_no_file_of_a_machine_whatever_becomes_of_a_part() {
    let mut traced = TracedFarm::new();
    traced.start(&[]);
    let farm = &traced.farm;
    let cube = block(10.0, 12.0, 14.0);
    farm.drop_part("first_x2.stl", &cube);
    farm.drop_part("again.stl", &cube);
    farm.drop_bytes("broken.stl", b"solid nothing");
    farm.drop_bytes("unclear.stl.toml", b"copies = \"many\"");
    farm.drop_part("unclear.stl", &block(9.0, 9.0, 9.0));
    traced.wait_for("two wait and two are refused", || {
        farm.parts(PartState::Waiting).len() == 2 && farm.parts(PartState::Refused).len() == 2
    });
    let first = traced.part(PartState::Waiting, "first_x2.stl").unwrap();
    farm.nestd_ok(&["cancel", &first.id.to_string()]);
    farm.nestd_ok(&["retry", &first.id.to_string()]);
    traced.wait_for("it waits again", || traced.part(PartState::Waiting, "first_x2.stl").is_some());
    farm.flush();
    traced.wait_for("they are built", || farm.parts(PartState::Built).len() == 2);
    traced.wait_for("their files are forgotten", || !traced.stored(&first).exists());
    farm.drop_part("kept.stl", &block(8.0, 9.0, 10.0));
    traced.wait_for("another waits", || traced.part(PartState::Waiting, "kept.stl").is_some());
    farm.write_profile(SECOND, &format!("{QUICK}archive_days = 3\n"));
    signal(traced.daemon.as_ref().unwrap().pid(), rustix::process::Signal::HUP);
    traced.wait_for("it is reloaded", || farm.log().contains("The configuration was read again"));
    let kept = traced.part(PartState::Waiting, "kept.stl").unwrap();
    traced.stop();
    // The state after a crash: somebody wrote to a claimed original after its row was committed. The stored file is
    // also damaged.
    let claim = traced.farm.folder("inbox").join(".claimed").join(&kept.file.claim);
    fs::create_dir_all(&claim).unwrap();
    fs::write(claim.join("kept.stl"), stl(&block(8.0, 9.0, 11.0))).unwrap();
    let stored = traced.stored(&kept);
    fs::write(stored, "rotten").unwrap();
    traced.start(&[]);
    let farm = &traced.farm;
    traced.wait_for("the revision is taken", || farm.parts(PartState::Waiting).len() == 2);
    farm.flush();
    let attention = farm.root().join("state/attention.json");
    let is_asked = || fs::read_to_string(&attention).unwrap_or_default().contains("file-damaged");
    traced.wait_for("the rotten one is asked for again", is_asked);
    farm.drop_part("healed.stl", &block(8.0, 9.0, 10.0));
    traced.wait_for("it is healed", || !is_asked());
    farm.flush();
    traced.wait_for("all are built", || farm.parts(PartState::Built).len() == 4);
    let by_the_loop = traced.seen.by_the_loop.lock().unwrap().clone();
    assert!(by_the_loop.is_empty(), "{by_the_loop:#?}");
    traced.stop();
    traced.farm.assert_nothing_lost_or_doubled();
    assert_eq!(traced.farm.broken_invariants(&Default::default()), [""; 0]);
}

fn a_slow_folder_holds_up_neither_the_watchdog_nor_another_machine() {
    let mut traced = TracedFarm::new();
    traced.start(&["inbox/test/.claimed", "error/test", "state/store"]);
    let began = Instant::now();
    let farm = &traced.farm;
    farm.drop_part("cancelled.stl", &block(10.0, 12.0, 14.0));
    farm.drop_part("printed.stl", &block(10.0, 12.0, 15.0));
    farm.drop_bytes("broken.stl", b"solid nothing");
    traced.wait_for("both wait", || farm.parts(PartState::Waiting).len() == 2);
    let cancelled = traced.part(PartState::Waiting, "cancelled.stl").unwrap();
    let mut cancel = farm.command(&["cancel", &cancelled.id.to_string()]).spawn().unwrap();
    traced.wait_for("its original is copied", || is_slowed(&traced, Path::new("error/test/part-")));
    // Meanwhile, the other machine accepts and prints its own part.
    traced.drop_at_second("other.stl", &stl(&block(20.0, 12.0, 14.0)));
    let queue = farm.root().join("queue").join(SECOND);
    traced.wait_for("the other one waits", || traced.part(PartState::Waiting, "other.stl").is_some());
    farm.nestd_ok(&["flush", SECOND]);
    let is_printed = || {
        let names = fs::read_dir(&queue).into_iter().flatten().flatten().map(|file| file.file_name());
        names
            .into_iter()
            .any(|name| name.to_string_lossy().ends_with(".build.3mf") && !name.to_string_lossy().starts_with('.'))
    };
    traced.wait_for("the other machine prints", is_printed);
    traced.wait_for("it is cancelled", || traced.part(PartState::Refused, "cancelled.stl").is_some());
    cancel.wait().unwrap();
    farm.nestd(&["flush", MACHINE]);
    traced.wait_for("the rest is built", || traced.part(PartState::Built, "printed.stl").is_some());
    traced.wait_for("its file is forgotten", || farm.root().join("state/store").is_dir() && forgotten(&traced));
    let (silence, slowed) = (traced.longest_silence(began), traced.seen.slowed.lock().unwrap().clone());
    assert!(slowed.len() >= 5, "too little was slow to tell: {slowed:#?}");
    assert!(silence < LONGEST_SILENCE, "the loop was silent for {silence:?}; slow were {slowed:#?}\n{}", farm.log());
}

fn is_slowed(traced: &TracedFarm, begins: &Path) -> bool {
    traced.seen.slowed.lock().unwrap().iter().any(|call| call.contains(&*begins.to_string_lossy()))
}

/// Whether the stored files of all built parts were removed.
fn forgotten(traced: &TracedFarm) -> bool {
    traced.farm.parts(PartState::Built).iter().all(|part| !traced.stored(part).exists())
}

/// Why processes cannot be traced here.
pub fn missing() -> Option<String> {
    (!is_allowed()).then(|| "needs the right to trace processes (ptrace)".to_owned())
}

/// The tests, by name.
pub const CASES: [(&str, fn()); 2] = [
    (
        "the_event_loop_touches_no_file_of_a_machine_whatever_becomes_of_a_part",
        the_event_loop_touches_no_file_of_a_machine_whatever_becomes_of_a_part,
    ),
    (
        "a_slow_folder_holds_up_neither_the_watchdog_nor_another_machine",
        a_slow_folder_holds_up_neither_the_watchdog_nor_another_machine,
    ),
];
