//! Records the daemon's operations on the farm's files from the first scan to the published build.

use std::{
    fs::File,
    os::unix::fs::FileExt,
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use farm::InvariantExpectations;
use nix::libc;

use super::tree::{FileOperation, InodeTree, OperationKind};
use crate::{
    harness::life_cycle::LifeCycle,
    support::trace::{CallVerdict, CallWatcher, SystemCall, TracedDaemon},
};

/// A trigger that fires without a command, because no other process may open the ledger while its files are recorded.
pub const TRIGGER: &str = "[trigger]\ncopies = 6\n";

/// A recorded life-cycle.
pub struct RecordedRun {
    /// The folders before the daemon's first operation, with the dropped files.
    pub base: InodeTree,
    /// The daemon's operations.
    pub ops: Vec<FileOperation>,
    /// The dropped files.
    pub expectations: InvariantExpectations,
}

/// Whether a path is rebuilt: not the configuration, which every farm has, and not files that hold nothing about parts
/// and builds.
fn is_wanted(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let is_status = |name: &str| matches!(name, "STATUS.txt" | "status.json");
    let hidden = |of: &str| format!(".nestd-{}.tmp", &blake3::hash(of.as_bytes()).to_hex()[..24]);
    let is_noise = is_status(&name) || name == hidden("STATUS.txt") || name == hidden("status.json");
    !is_noise
        && !matches!(&*name, ".nestd-owner" | "nestd.lock" | "nestd.db-shm")
        && !["config", "log", "sending", "taken"].iter().any(|top| path.starts_with(top))
}

/// Runs the life-cycle once.
pub fn record_run() -> RecordedRun {
    let mut life = LifeCycle::with(TRIGGER);
    life.farm.start();
    life.wait_for_sign_of_life();
    life.farm.stop();
    life.drop_all();
    let root = life.farm.root().to_owned();
    let base = InodeTree::read(&root, &is_wanted);
    let state = Arc::new(Mutex::new((base.clone(), Vec::new())));
    let watch = OperationRecorder { root: root.clone(), state: state.clone() };
    let traced = TracedDaemon::start(life.farm.command(&["run"]), &root, watch).unwrap();
    let began = Instant::now();
    let is_done = |life: &LifeCycle| {
        let inbox = life.farm.folder("inbox");
        let work = intake::list_claims(&inbox).unwrap_or_default();
        let is_refused = life.farm.folder("error").join("bad.stl").exists();
        !life.farm.queued().is_empty() && work.claims.is_empty() && work.unfinished.is_empty() && is_refused
    };
    while !is_done(&life) {
        assert!(began.elapsed() < Duration::from_secs(60), "no build was published\n{}", life.farm.log());
        std::thread::sleep(Duration::from_millis(50));
    }
    std::thread::sleep(Duration::from_secs(1));
    drop(traced.kill());
    let ops = std::mem::take(&mut state.lock().unwrap().1);
    RecordedRun { base, ops, expectations: life.expectations.clone() }
}

struct OperationRecorder {
    root: PathBuf,
    /// The current folders, and the operations so far.
    state: Arc<Mutex<(InodeTree, Vec<FileOperation>)>>,
}

impl CallWatcher for OperationRecorder {
    fn before(&mut self, _: &SystemCall) -> CallVerdict {
        CallVerdict::Let
    }

    fn after(&mut self, call: &SystemCall, result: i64) -> bool {
        if result >= 0 {
            let mut state = self.state.lock().unwrap();
            let (tree, ops) = &mut *state;
            for what in self.operations(call, result, tree) {
                let path = call.to.as_ref().unwrap_or(&call.path);
                let path = path.strip_prefix(&self.root).unwrap_or(path).to_owned();
                let is_of_ledger = path.starts_with("state/nestd.db") || path.starts_with("state/nestd.db-wal");
                let op = FileOperation { what, is_of_ledger, path };
                tree.allocate(&op);
                tree.apply(&op);
                ops.push(op);
            }
        }
        true
    }
}

impl OperationRecorder {
    fn below<'a>(&self, path: &'a Path) -> Option<&'a Path> {
        path.strip_prefix(&self.root).ok().filter(|path| is_wanted(path))
    }

    /// The operations of a call that succeeded.
    fn operations(&self, call: &SystemCall, result: i64, tree: &InodeTree) -> Vec<OperationKind> {
        self.try_operations(call, result, tree).unwrap_or_default()
    }

    fn try_operations(&self, call: &SystemCall, result: i64, tree: &InodeTree) -> Option<Vec<OperationKind>> {
        let path = self.below(&call.path)?;
        let dir = || tree.find(path.parent()?);
        let name = || path.file_name().map(ToOwned::to_owned);
        Some(match call.name {
            "open" if call.flags & (libc::O_CREAT | libc::O_TRUNC) as u64 != 0 => match tree.find(path) {
                None => vec![OperationKind::Put { dir: dir()?, name: name()?, node: tree.next(), is_dir: false }],
                Some(node) if call.flags & libc::O_TRUNC as u64 != 0 => {
                    vec![OperationKind::Truncate { node, bytes: 0 }]
                }
                Some(_) => Vec::new(),
            },
            "mkdir" => vec![OperationKind::Put { dir: dir()?, name: name()?, node: tree.next(), is_dir: true }],
            "unlink" | "rmdir" => vec![OperationKind::Remove { dir: dir()?, name: name()? }],
            "rename" | "link" => {
                let to = self.below(call.to.as_deref()?)?;
                let (to_dir, to_name) = (tree.find(to.parent()?)?, to.file_name()?.to_owned());
                let node = tree.find(path)?;
                match call.name {
                    "link" => vec![OperationKind::Link { dir: to_dir, name: to_name, node }],
                    _ => vec![OperationKind::Move { from: dir()?, from_name: name()?, to: to_dir, to_name, node }],
                }
            }
            "write" | "pwrite" | "writev" | "pwritev" | "copy_file_range" | "sendfile" => {
                let offset = call.offset.unwrap_or_else(|| call.position().saturating_sub(result as u64));
                let mut data = vec![0; result as usize];
                File::open(format!("/proc/{}/fd/{}", call.pid, call.fd?))
                    .ok()?
                    .read_exact_at(&mut data, offset)
                    .ok()?;
                vec![OperationKind::Write { node: tree.find(path)?, offset, data }]
            }
            "ftruncate" => vec![OperationKind::Truncate { node: tree.find(path)?, bytes: call.argument }],
            "fsync" => vec![OperationKind::Sync { node: tree.find(path)? }],
            _ => Vec::new(),
        })
    }
}
