//! Records what the daemon does to the farm's files from the first scan to the published build.

use std::{
    fs::File,
    os::unix::fs::FileExt,
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use nestd::farm::Witness;
use nix::libc;

use super::{
    super::{
        life::Life,
        trace::{Call, Traced, Verdict, Watch},
    },
    tree::{Op, Tree, What},
};

/// Fires by itself: nobody else may open the ledger while its files are recorded.
pub const TRIGGER: &str = "[trigger]\ncopies = 6\n";

/// A recorded life-cycle.
pub struct Recording {
    /// The folders before the daemon's first operation, with what was dropped.
    pub base: Tree,
    /// What it did.
    pub ops: Vec<Op>,
    /// What was dropped.
    pub witness: Witness,
}

/// What is rebuilt: not the configuration, which every farm has, nor what says nothing about parts and builds.
fn is_wanted(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let is_status = |name: &str| matches!(name, "STATUS.txt" | "status.json");
    let hidden = |of: &str| format!(".nestd-{}.tmp", &blake3::hash(of.as_bytes()).to_hex()[..24]);
    let is_noise = is_status(&name) || name == hidden("STATUS.txt") || name == hidden("status.json");
    !is_noise
        && !matches!(&*name, ".nestd-owner" | "nestd.lock" | "nestd.db-shm")
        && !["config", "log", "sending", "taken"].iter().any(|top| path.starts_with(top))
}

/// Plays the life-cycle once.
pub fn record() -> Recording {
    let mut life = Life::with(TRIGGER);
    life.farm.start();
    life.wait_for_sign_of_life();
    life.farm.stop();
    life.drop_all();
    let root = life.farm.root().to_owned();
    let base = Tree::read(&root, &is_wanted);
    let state = Arc::new(Mutex::new((base.clone(), Vec::new())));
    let watch = Record { root: root.clone(), state: state.clone() };
    let traced = Traced::start(life.farm.command(&["run"]), &root, watch).unwrap();
    let began = Instant::now();
    let is_done = |life: &Life| {
        let inbox = life.farm.folder("inbox");
        let work = nestd::intake::work(&inbox).unwrap_or_default();
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
    Recording { base, ops, witness: life.witness.clone() }
}

struct Record {
    root: PathBuf,
    /// The folders as they are now, and what was done so far.
    state: Arc<Mutex<(Tree, Vec<Op>)>>,
}

impl Watch for Record {
    fn before(&mut self, _: &Call) -> Verdict {
        Verdict::Let
    }

    fn after(&mut self, call: &Call, result: i64) -> bool {
        if result >= 0 {
            let mut state = self.state.lock().unwrap();
            let (tree, ops) = &mut *state;
            for what in self.operations(call, result, tree) {
                let path = call.to.as_ref().unwrap_or(&call.path);
                let path = path.strip_prefix(&self.root).unwrap_or(path).to_owned();
                let is_of_ledger = path.starts_with("state/nestd.db") || path.starts_with("state/nestd.db-wal");
                let op = Op { what, is_of_ledger, path };
                tree.allocate(&op);
                tree.apply(&op);
                ops.push(op);
            }
        }
        true
    }
}

impl Record {
    fn below<'a>(&self, path: &'a Path) -> Option<&'a Path> {
        path.strip_prefix(&self.root).ok().filter(|path| is_wanted(path))
    }

    /// The operations of a call that succeeded.
    fn operations(&self, call: &Call, result: i64, tree: &Tree) -> Vec<What> {
        self.try_operations(call, result, tree).unwrap_or_default()
    }

    fn try_operations(&self, call: &Call, result: i64, tree: &Tree) -> Option<Vec<What>> {
        let path = self.below(&call.path)?;
        let dir = || tree.find(path.parent()?);
        let name = || path.file_name().map(ToOwned::to_owned);
        Some(match call.name {
            "open" if call.flags & (libc::O_CREAT | libc::O_TRUNC) as u64 != 0 => match tree.find(path) {
                None => vec![What::Put { dir: dir()?, name: name()?, node: tree.next(), is_dir: false }],
                Some(node) if call.flags & libc::O_TRUNC as u64 != 0 => vec![What::Truncate { node, bytes: 0 }],
                Some(_) => Vec::new(),
            },
            "mkdir" => vec![What::Put { dir: dir()?, name: name()?, node: tree.next(), is_dir: true }],
            "unlink" | "rmdir" => vec![What::Remove { dir: dir()?, name: name()? }],
            "rename" | "link" => {
                let to = self.below(call.to.as_deref()?)?;
                let (to_dir, to_name) = (tree.find(to.parent()?)?, to.file_name()?.to_owned());
                let node = tree.find(path)?;
                match call.name {
                    "link" => vec![What::Link { dir: to_dir, name: to_name, node }],
                    _ => vec![What::Move { from: dir()?, from_name: name()?, to: to_dir, to_name, node }],
                }
            }
            "write" | "pwrite" | "writev" | "pwritev" | "copy_file_range" | "sendfile" => {
                let offset = call.offset.unwrap_or_else(|| call.position().saturating_sub(result as u64));
                let mut data = vec![0; result as usize];
                File::open(format!("/proc/{}/fd/{}", call.pid, call.fd?))
                    .ok()?
                    .read_exact_at(&mut data, offset)
                    .ok()?;
                vec![What::Write { node: tree.find(path)?, offset, data }]
            }
            "ftruncate" => vec![What::Truncate { node: tree.find(path)?, bytes: call.argument }],
            "fsync" => vec![What::Sync { node: tree.find(path)? }],
            _ => Vec::new(),
        })
    }
}
