//! A system call on the farm's files, read out of a stopped thread.

use std::{
    ffi::OsString,
    fs::{self, File},
    os::unix::{ffi::OsStringExt, fs::FileExt},
    path::{Path, PathBuf},
};

use nix::{libc, unistd::Pid};

/// Whether a call changes something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CallEffect {
    /// It changes contents, names or what is durable.
    Change,
    /// It only looks.
    Look,
}

/// A call on a path below the farm's root.
#[derive(Debug, Clone)]
pub struct SystemCall {
    /// Name of the system call, without the `at` of its newer forms.
    pub name: &'static str,
    /// Whether it changes something.
    pub kind: CallEffect,
    /// What it is about; a rename's source.
    pub path: PathBuf,
    /// A rename's or link's target.
    pub to: Option<PathBuf>,
    /// File descriptor, for calls on one.
    pub fd: Option<u64>,
    /// Bytes to be written, for writes.
    pub bytes: u64,
    /// The second argument: the length for `ftruncate`.
    pub argument: u64,
    /// Offset in the file, for `pwrite`.
    pub offset: Option<u64>,
    /// Flags of an open.
    pub flags: u64,
    /// The process.
    pub pid: i32,
    /// The thread that makes it; the first of a process has its number.
    pub thread: i32,
}

/// How the arguments of a call name its files.
enum ArgumentForm {
    Fd(usize),
    Path(usize),
    At(usize, usize),
    Paths(usize, usize),
    Ats((usize, usize), (usize, usize)),
}

/// Number, name, whether it changes something, and where its files are named.
const CALLS: [(u64, &str, CallEffect, ArgumentForm); 46] = {
    use ArgumentForm::*;
    use CallEffect::*;
    [
        (0, "read", Look, Fd(0)),
        (17, "pread", Look, Fd(0)),
        (19, "readv", Look, Fd(0)),
        (1, "write", Change, Fd(0)),
        (18, "pwrite", Change, Fd(0)),
        (20, "writev", Change, Fd(0)),
        (296, "pwritev", Change, Fd(0)),
        (326, "copy_file_range", Change, Fd(2)),
        (40, "sendfile", Change, Fd(0)),
        (2, "open", Look, Path(0)),
        (257, "open", Look, At(0, 1)),
        (4, "stat", Look, Path(0)),
        (6, "stat", Look, Path(0)),
        (5, "fstat", Look, Fd(0)),
        (262, "stat", Look, At(0, 1)),
        (332, "stat", Look, At(0, 1)),
        (217, "getdents", Look, Fd(0)),
        (82, "rename", Change, Paths(0, 1)),
        (264, "rename", Change, Ats((0, 1), (2, 3))),
        (316, "rename", Change, Ats((0, 1), (2, 3))),
        (86, "link", Change, Paths(0, 1)),
        (265, "link", Change, Ats((0, 1), (2, 3))),
        (88, "symlink", Change, Path(1)),
        (266, "symlink", Change, At(1, 2)),
        (87, "unlink", Change, Path(0)),
        (263, "unlink", Change, At(0, 1)),
        (83, "mkdir", Change, Path(0)),
        (258, "mkdir", Change, At(0, 1)),
        (84, "rmdir", Change, Path(0)),
        (74, "fsync", Change, Fd(0)),
        (75, "fsync", Change, Fd(0)),
        (76, "truncate", Change, Path(0)),
        (77, "ftruncate", Change, Fd(0)),
        (285, "fallocate", Change, Fd(0)),
        (280, "utimens", Change, At(0, 1)),
        (90, "chmod", Change, Path(0)),
        (91, "chmod", Change, Fd(0)),
        (268, "chmod", Change, At(0, 1)),
        (452, "chmod", Change, At(0, 1)),
        (92, "chown", Change, Path(0)),
        (93, "chown", Change, Fd(0)),
        (94, "chown", Change, Path(0)),
        (260, "chown", Change, At(0, 1)),
        (137, "statfs", Look, Path(0)),
        (138, "statfs", Look, Fd(0)),
        (78, "getdents", Look, Fd(0)),
    ]
};

/// `unlinkat` removes a folder with this flag.
const REMOVE_DIR: u64 = 0x200;

impl SystemCall {
    /// The call that a thread of a process is about to make, if it is about the farm's files.
    pub fn decode(pid: Pid, thread: Pid, regs: &libc::user_regs_struct, root: &Path) -> Option<Self> {
        let (number, name, kind, form) = CALLS.iter().find(|(number, ..)| *number == regs.orig_rax)?;
        let args = [regs.rdi, regs.rsi, regs.rdx, regs.r10, regs.r8, regs.r9];
        let process = TracedProcess { pid: pid.as_raw() };
        let (path, to, fd) = match *form {
            ArgumentForm::Fd(at) => (process.of_fd(args[at])?, None, Some(args[at])),
            ArgumentForm::Path(at) => (process.at(None, args[at])?, None, None),
            ArgumentForm::At(dir, at) => (process.at(Some(args[dir]), args[at])?, None, None),
            ArgumentForm::Paths(from, to) => (process.at(None, args[from])?, process.at(None, args[to]), None),
            ArgumentForm::Ats(from, to) => {
                let to = process.at(Some(args[to.0]), args[to.1]);
                (process.at(Some(args[from.0]), args[from.1])?, to, None)
            }
        };
        let is_ours = |path: &Path| path.starts_with(root) && path != root.join("log");
        if !is_ours(&path) && !to.as_deref().is_some_and(is_ours) {
            return None;
        }
        let flags = match *number {
            2 => args[1],
            257 | 263 => args[2],
            _ => 0,
        };
        let creates = *name == "open" && flags & (libc::O_CREAT | libc::O_TRUNC) as u64 != 0;
        Some(Self {
            name: if *number == 263 && flags & REMOVE_DIR != 0 { "rmdir" } else { name },
            kind: if creates { CallEffect::Change } else { *kind },
            path,
            to,
            fd,
            bytes: if matches!(*number, 1 | 18) { args[2] } else { 0 },
            argument: args[1],
            offset: (*number == 18).then_some(args[3]),
            flags,
            pid: pid.as_raw(),
            thread: thread.as_raw(),
        })
    }

    /// Where a descriptor stands in its file.
    pub fn position(&self) -> u64 {
        let info = fs::read_to_string(format!("/proc/{}/fdinfo/{}", self.pid, self.fd.unwrap())).unwrap_or_default();
        info.lines().find_map(|line| line.strip_prefix("pos:")).map_or(0, |pos| pos.trim().parse().unwrap())
    }
}

struct TracedProcess {
    pid: i32,
}

impl TracedProcess {
    fn of_fd(&self, fd: u64) -> Option<PathBuf> {
        let path = fs::read_link(format!("/proc/{}/fd/{}", self.pid, fd as i32)).ok()?;
        let text = path.into_os_string().into_vec();
        let text = text.strip_suffix(b" (deleted)").unwrap_or(&text).to_vec();
        Some(PathBuf::from(OsString::from_vec(text)))
    }

    /// The path at an address, as seen from a descriptor or from the working directory.
    fn at(&self, dir: Option<u64>, address: u64) -> Option<PathBuf> {
        let path = self.text(address)?;
        if path.is_absolute() {
            return Some(path);
        }
        let base = match dir.map(|dir| dir as i32) {
            None | Some(libc::AT_FDCWD) => fs::read_link(format!("/proc/{}/cwd", self.pid)).ok()?,
            Some(dir) => self.of_fd(dir as u64)?,
        };
        Some(if path.as_os_str().is_empty() { base } else { base.join(path) })
    }

    fn text(&self, address: u64) -> Option<PathBuf> {
        let memory = File::open(format!("/proc/{}/mem", self.pid)).ok()?;
        let (mut text, mut at) = (Vec::new(), address);
        while text.len() < 8192 {
            // A read must not cross into a page that is not there.
            let mut chunk = vec![0; (4096 - at % 4096).min(256) as usize];
            memory.read_exact_at(&mut chunk, at).ok()?;
            if let Some(end) = chunk.iter().position(|&byte| byte == 0) {
                text.extend_from_slice(&chunk[..end]);
                return Some(PathBuf::from(OsString::from_vec(text)));
            }
            text.extend_from_slice(&chunk);
            at += chunk.len() as u64;
        }
        None
    }
}
