//! Who serves a folder of a machine: hot folder, queue, archive, error folder. Two daemons with different ledgers on one folder
//! would each take half of the parts and overwrite each other's files, and locks do not travel over every share: so a daemon
//! writes its name into `.nestd-owner` and keeps a number there moving for as long as it lives. Whoever finds another name
//! there looks whether that daemon lives: on its own server by its lock, elsewhere by whether the number moves.
//!
//! The same file tells an empty directory in the place of an unmounted share from a folder that somebody emptied; `marked`
//! remembers over restarts which folders had one.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Read, Write},
    os::unix::fs::{FileExt, MetadataExt, OpenOptionsExt},
    path::{Path, PathBuf},
    time::Instant,
};

use jiff::Timestamp;
use rustix::fs::{FlockOperation, flock};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{
    lease::{Stamp, dead_after},
    lock, served,
};

/// In each folder; a dot-file, which no scan and no printer takes.
pub(super) const NAME: &str = ".nestd-owner";
/// In the state directory.
pub const FARM: &str = "nestd.farm";
/// The file is always this long, so that a beat is one write and never makes it shorter.
const BYTES: usize = 1024;

/// A daemon, as its marker names it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Owner {
    /// Its farm: a random number in its state directory.
    farm: String,
    /// Its server.
    host: String,
    /// Its state directory.
    state_dir: PathBuf,
    /// Its process.
    pid: u32,
    /// When it started.
    since: Timestamp,
    /// Moves while it lives.
    beat: u64,
    /// It has stopped in order.
    stopped: bool,
}

/// Why a folder cannot be served.
#[derive(Debug, Error)]
pub enum OwnerError {
    /// Another daemon serves it.
    #[error(
        "{} is served by another nestd: process {} on {} since {}, with the state folder {}. Stop that one, or give each \
         farm folders of its own",
        .folder.display(), .owner.pid, .owner.host, .owner.since.strftime("%Y-%m-%d %H:%M:%S UTC"), .owner.state_dir.display()
    )]
    Other {
        /// The folder.
        folder: PathBuf,
        /// Who serves it.
        owner: Box<Owner>,
    },
    /// Another daemon is named, and it is not known yet whether it lives.
    #[error("{} is marked by process {} on {}: waiting whether that one lives", .folder.display(), .owner.pid, .owner.host)]
    Unclear {
        /// The folder.
        folder: PathBuf,
        /// Who is named.
        owner: Box<Owner>,
    },
    /// It is another directory than before, and nobody's: an empty mount point.
    #[error(
        "{} is not the folder that was there before: its marker {NAME} is missing. Mount it again; if it was replaced or \
         emptied on purpose: touch {}", .0.display(), .0.join(NAME).display()
    )]
    Replaced(PathBuf),
    /// Files of its parts are claimed still, by this farm or by one that took them over.
    #[error("{claims} of the claims in {} are not let go yet", .folder.display())]
    NotLetGo {
        /// The hot folder.
        folder: PathBuf,
        /// How many.
        claims: usize,
    },
    /// The system said no.
    #[error("{} cannot be used: {why}", .folder.display())]
    Io {
        /// The folder.
        folder: PathBuf,
        /// The error of the system; told already, so that a chain of errors does not tell it again.
        why: io::Error,
    },
}

/// This daemon's hold on one folder.
#[derive(Debug, Clone)]
pub struct Hold {
    me: Owner,
    folder: PathBuf,
    /// Device and inode of the directory while it was ours.
    seen: Option<(u64, u64)>,
    /// That it is ours is written down for the next start.
    is_known: bool,
    /// Another one's beat, and since when it stands still.
    foreign: Option<(Owner, Instant)>,
}

/// What the marker of a folder says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Mark {
    /// There is none.
    Missing,
    /// There is one without a name: a person accepts the folder as it is, or a crash tore it.
    Blank,
    /// The daemon that served it last.
    Of(Box<Owner>),
}

impl Owner {
    /// Number of its farm.
    pub fn farm(&self) -> &str {
        &self.farm
    }

    /// The daemon of this process.
    pub fn of_this_process(state_dir: &Path, since: Timestamp) -> io::Result<Self> {
        let farm = farm_number(state_dir)?;
        let state_dir = fs::canonicalize(state_dir)?;
        Ok(Self { farm, host: lock::host_name(), state_dir, pid: std::process::id(), since, beat: 0, stopped: false })
    }

    /// Whether the farm of a state directory has a number yet.
    pub(super) fn is_made(state_dir: &Path) -> bool {
        state_dir.join(FARM).exists()
    }

    /// Its state directory.
    pub(super) fn state_dir(&self) -> &Path {
        &self.state_dir
    }

    /// Whether it is a daemon of this server.
    pub(super) fn is_here(&self) -> bool {
        self.host == lock::host_name()
    }

    /// Whether it may live, as far as can be told at once: it has not stopped, and holds its lock or is of another server.
    pub(super) fn may_live(&self) -> bool {
        !(self.stopped || self.is_here() && self.lock_is_held() == Some(false))
    }

    /// The same farm: its state directory is locked by this process, so that an earlier daemon of it is dead. A copy of a
    /// state directory, or one that was moved to another server, is another farm.
    fn is_same_farm(&self, other: &Self) -> bool {
        (&self.farm, &self.host, &self.state_dir) == (&other.farm, &other.host, &other.state_dir)
    }

    /// On its own server a daemon holds the lock of its state directory; `None` = nobody can tell from here. (Containers
    /// may have the name of their server, and each its own folder under the same path.)
    fn holds_its_lock(&self, asks: &Self) -> Option<bool> {
        if self.host != asks.host || self.state_dir == asks.state_dir {
            return None;
        }
        self.lock_is_held()
    }

    fn lock_is_held(&self) -> Option<bool> {
        let nofollow = (rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK).bits();
        let path = self.state_dir.join(lock::NAME);
        let file = OpenOptions::new().read(true).custom_flags(nofollow as i32).open(path).ok()?;
        match flock(&file, FlockOperation::NonBlockingLockShared) {
            Ok(()) => Some(false),
            Err(rustix::io::Errno::WOULDBLOCK) => Some(true),
            Err(_) => None,
        }
    }
}

impl Hold {
    /// A hold that is not taken yet.
    pub fn new(me: Owner, folder: &Path) -> Self {
        Self { me, folder: folder.to_owned(), seen: None, is_known: false, foreign: None }
    }

    /// Where it is.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The number of this farm.
    pub fn farm(&self) -> &str {
        &self.me.farm
    }

    /// Whether the marker names this farm at this moment: what is done in the folder right after is not done in another's.
    pub fn demand_mine(&self) -> Result<(), OwnerError> {
        let folder = self.folder.clone();
        match read(&self.folder).map_err(|source| self.io(source))? {
            Mark::Of(owner) if self.me.is_same_farm(&owner) => Ok(()),
            Mark::Of(owner) => Err(OwnerError::Other { folder, owner }),
            Mark::Missing | Mark::Blank => Err(OwnerError::Replaced(folder)),
        }
    }

    /// Whether it is on the same folder as another hold.
    pub fn is_of(&self, other: &Self) -> bool {
        self.folder == other.folder
    }

    /// Whether the folder was never served: then it may be made. An empty directory in the place of one that was would
    /// hinder whoever mounts it again.
    pub fn is_new(&self) -> bool {
        self.seen.is_none() && !served::is_known(&self.me.state_dir, &self.folder)
    }

    /// Device and inode of the folder while it was ours in this run; `None` = it never was.
    pub fn seen(&self) -> Option<(u64, u64)> {
        self.seen
    }

    /// Takes hold of the folder, or shows that this daemon still serves it. To be called at every beat.
    pub fn keep(&mut self) -> Result<(), OwnerError> {
        let looked = Stamp::now();
        self.check()?;
        self.me.beat += 1;
        write(&self.folder, &self.me, looked).map_err(|source| self.io(source))?;
        let now = identity(&self.folder).map_err(|source| self.io(source))?;
        if !self.is_known || self.seen != Some(now) {
            // On a full disk the folder is served all the same; the next beat tries again.
            self.is_known = served::remember(&self.me.state_dir, &self.folder, now).is_ok();
        }
        self.seen = Some(now);
        Ok(())
    }

    /// Whether the folder may be used: it is there, it is the same as before, and nobody else serves it.
    pub fn check(&mut self) -> Result<(), OwnerError> {
        let now = identity(&self.folder).map_err(|source| self.io(source))?;
        let owner = match read(&self.folder).map_err(|source| self.io(source))? {
            Mark::Of(owner) => *owner,
            mark => {
                self.foreign = None;
                return match self.is_in_its_place(&mark, now) {
                    true => Ok(()),
                    false => Err(OwnerError::Replaced(self.folder.clone())),
                };
            }
        };
        if owner.stopped || self.me.is_same_farm(&owner) {
            self.foreign = None;
            // A share that was mounted again may have another number.
            self.seen = self.seen.map(|_| now);
            return Ok(());
        }
        let (folder, boxed) = (self.folder.clone(), Box::new(owner.clone()));
        match owner.holds_its_lock(&self.me) {
            Some(true) => return Err(OwnerError::Other { folder, owner: boxed }),
            Some(false) => return Ok(()),
            None => {}
        }
        match &self.foreign {
            Some((known, since)) if *known == owner && since.elapsed() >= dead_after() => Ok(()),
            Some((known, _)) if *known == owner => Err(OwnerError::Unclear { folder, owner: boxed }),
            known => {
                let moved = known.as_ref().is_some_and(|(known, _)| known.beat != owner.beat);
                self.foreign = Some((owner, Instant::now()));
                Err(match moved {
                    true => OwnerError::Other { folder, owner: boxed },
                    false => OwnerError::Unclear { folder, owner: boxed },
                })
            }
        }
    }

    /// Says that this daemon serves it no more; a folder that is not ours is left alone.
    pub fn end(&mut self) {
        let looked = Stamp::now();
        let is_ours = |mark| matches!(mark, Mark::Of(owner) if self.me.is_same_farm(&owner));
        if self.seen.is_some() && read(&self.folder).is_ok_and(is_ours) {
            self.me.stopped = true;
            // What is not written looks like a daemon that was killed.
            let _ = write(&self.folder, &self.me, looked);
        }
    }

    /// Whether a folder that names nobody is the one that was served, or one that may be served.
    fn is_in_its_place(&self, mark: &Mark, now: (u64, u64)) -> bool {
        let was = self.seen.or_else(|| served::known(&self.me.state_dir, &self.folder));
        *mark == Mark::Blank || was.is_none_or(|was| was == now)
    }

    fn io(&self, source: io::Error) -> OwnerError {
        OwnerError::Io { folder: self.folder.clone(), why: source }
    }
}

/// The number of a farm, made at its first start.
fn farm_number(state_dir: &Path) -> io::Result<String> {
    let path = state_dir.join(FARM);
    match fs::read_to_string(&path) {
        Ok(number) if !number.trim().is_empty() => return Ok(number.trim().to_owned()),
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let number = format!("{:032x}", rand::random::<u128>());
    let mut file = tempfile::Builder::new().prefix(".nestd-farm-").tempfile_in(state_dir)?;
    writeln!(file, "{number}")?;
    file.as_file().sync_all()?;
    file.persist(&path)?;
    File::open(state_dir)?.sync_all()?;
    Ok(number)
}

/// Device and inode of a folder.
pub(super) fn identity(folder: &Path) -> io::Result<(u64, u64)> {
    let meta = fs::metadata(folder)?;
    match meta.is_dir() {
        true => Ok((meta.dev(), meta.ino())),
        false => Err(io::ErrorKind::NotADirectory.into()),
    }
}

/// The marker of a folder; one that nobody can read is nobody's.
pub(super) fn read(folder: &Path) -> io::Result<Mark> {
    let flags = rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK;
    let mut text = String::new();
    match OpenOptions::new().read(true).custom_flags(flags.bits() as i32).open(folder.join(NAME)) {
        Ok(file) => match file.take(BYTES as u64).read_to_string(&mut text) {
            Err(error) if error.raw_os_error().is_some() => return Err(error),
            _ => {}
        },
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Mark::Missing),
        Err(error) => return Err(error),
    }
    Ok(serde_json::from_str(text.trim_end()).map_or(Mark::Blank, |owner| Mark::Of(Box::new(owner))))
}

/// In place, at full length: a reader sees the old beat or the new one. Not when `looked` is long ago: who stood still since
/// would write over the name of one that took the folder meanwhile.
fn write(folder: &Path, owner: &Owner, looked: Stamp) -> io::Result<()> {
    let mut text = serde_json::to_string(owner).map_err(io::Error::other)?;
    text.extend(std::iter::repeat_n(' ', BYTES.saturating_sub(text.len() + 1)));
    text.push('\n');
    let flags = rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK;
    let mut open = OpenOptions::new();
    open.write(true).create(true).truncate(false).custom_flags(flags.bits() as i32);
    let file = match open.open(folder.join(NAME)) {
        // An administrator made it, to accept the folder: the folder is ours, and so is the name in it.
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied && read(folder)? == Mark::Blank => {
            fs::remove_file(folder.join(NAME))?;
            open.open(folder.join(NAME))?
        }
        other => other?,
    };
    if file.metadata()?.len() == 0 {
        crate::access::of_file(&file)?;
    }
    match looked.holds() {
        true => file.write_all_at(text.as_bytes(), 0),
        false => Err(io::ErrorKind::TimedOut.into()),
    }
}

#[cfg(test)]
#[path = "owner_tests.rs"]
mod tests;
