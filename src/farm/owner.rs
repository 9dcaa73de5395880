//! Who serves a hot folder or a queue folder. Two daemons with different ledgers on one folder would each take half of the
//! parts and overwrite each other's files, and locks do not travel over every share: so a daemon writes its name into
//! `.nestd-owner` and keeps a number there moving for as long as it lives. Whoever finds another name there looks whether
//! that daemon lives: on its own server by its lock, elsewhere by whether the number moves.
//!
//! The same file tells an empty directory in the place of an unmounted share from a folder that somebody emptied.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Read, Write},
    os::unix::fs::{FileExt, MetadataExt, OpenOptionsExt},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use jiff::Timestamp;
use rustix::fs::{FlockOperation, flock};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::lock;

/// In each hot folder and each queue folder; a dot-file, which no scan and no printer takes.
const NAME: &str = ".nestd-owner";
/// In the state directory.
const FARM: &str = "nestd.farm";
/// The file is always this long, so that a beat is one write and never makes it shorter.
const BYTES: usize = 1024;
/// Between two beats.
pub const BEAT_EVERY: Duration = Duration::from_secs(4);
/// A number of a daemon on another server that has not moved for so long belongs to nobody.
const DEAD_AFTER: Duration = Duration::from_secs(15);

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
        "{} is another directory than before and its marker {NAME} is missing; mount it again, or, if it was replaced on \
         purpose, reload or restart nestd", .0.display()
    )]
    Replaced(PathBuf),
    /// The system said no.
    #[error("{} cannot be used: {source}", .folder.display())]
    Io {
        /// The folder.
        folder: PathBuf,
        /// The error of the system.
        #[source]
        source: io::Error,
    },
}

/// This daemon's hold on one folder.
#[derive(Debug, Clone)]
pub struct Hold {
    me: Owner,
    folder: PathBuf,
    /// Device and inode of the directory while it was ours.
    seen: Option<(u64, u64)>,
    /// Another one's beat, and since when it stands still.
    foreign: Option<(Owner, Instant)>,
}

impl Owner {
    /// The daemon of this process.
    pub fn of_this_process(state_dir: &Path, since: Timestamp) -> io::Result<Self> {
        let farm = farm_number(state_dir)?;
        let state_dir = fs::canonicalize(state_dir)?;
        Ok(Self { farm, host: lock::host_name(), state_dir, pid: std::process::id(), since, beat: 0, stopped: false })
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
        Self { me, folder: folder.to_owned(), seen: None, foreign: None }
    }

    /// Whether it is on the same folder as another hold.
    pub fn is_of(&self, other: &Self) -> bool {
        self.folder == other.folder
    }

    /// Device and inode of the folder while it was ours; `None` = it never was.
    pub fn seen(&self) -> Option<(u64, u64)> {
        self.seen
    }

    /// Takes hold of the folder, or shows that this daemon still serves it. To be called at every beat.
    pub fn keep(&mut self) -> Result<(), OwnerError> {
        self.check()?;
        self.me.beat += 1;
        write(&self.folder, &self.me).map_err(|source| self.io(source))?;
        self.seen = Some(identity(&self.folder).map_err(|source| self.io(source))?);
        Ok(())
    }

    /// Whether the folder may be used: it is there, it is the same as before, and nobody else serves it.
    pub fn check(&mut self) -> Result<(), OwnerError> {
        let now = identity(&self.folder).map_err(|source| self.io(source))?;
        let Some(owner) = read(&self.folder).map_err(|source| self.io(source))? else {
            self.foreign = None;
            return match self.seen {
                Some(seen) if seen != now => Err(OwnerError::Replaced(self.folder.clone())),
                _ => Ok(()),
            };
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
            Some((known, since)) if *known == owner && since.elapsed() >= DEAD_AFTER => Ok(()),
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

    /// As [`Hold::keep`], and waits until it is clear whether another daemon that is named there lives.
    pub fn keep_at_start(&mut self) -> Result<(), OwnerError> {
        let mut is_told = false;
        loop {
            match self.keep() {
                Err(unclear @ OwnerError::Unclear { .. }) => {
                    if !is_told {
                        tracing::info!("{unclear}; that takes up to {} s.", DEAD_AFTER.as_secs());
                    }
                    is_told = true;
                    std::thread::sleep(Duration::from_secs(1));
                }
                other => return other,
            }
        }
    }

    /// Says that this daemon serves it no more; a folder that is not ours is left alone.
    pub fn end(&mut self) {
        if self.seen.is_some() && read(&self.folder).is_ok_and(|owner| owner.is_some_and(|o| self.me.is_same_farm(&o)))
        {
            self.me.stopped = true;
            // What is not written looks like a daemon that was killed.
            let _ = write(&self.folder, &self.me);
        }
    }

    fn io(&self, source: io::Error) -> OwnerError {
        OwnerError::Io { folder: self.folder.clone(), source }
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

fn identity(folder: &Path) -> io::Result<(u64, u64)> {
    let meta = fs::metadata(folder)?;
    match meta.is_dir() {
        true => Ok((meta.dev(), meta.ino())),
        false => Err(io::ErrorKind::NotADirectory.into()),
    }
}

/// The marker of a folder; one that nobody can read is nobody's.
fn read(folder: &Path) -> io::Result<Option<Owner>> {
    let flags = rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK;
    let mut text = String::new();
    match OpenOptions::new().read(true).custom_flags(flags.bits() as i32).open(folder.join(NAME)) {
        Ok(file) => match file.take(BYTES as u64).read_to_string(&mut text) {
            Err(error) if error.raw_os_error().is_some() => return Err(error),
            _ => {}
        },
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
    }
    Ok(serde_json::from_str(text.trim_end()).ok())
}

/// In place, at full length: a reader sees the old beat or the new one.
fn write(folder: &Path, owner: &Owner) -> io::Result<()> {
    let mut text = serde_json::to_string(owner).map_err(io::Error::other)?;
    text.extend(std::iter::repeat_n(' ', BYTES.saturating_sub(text.len() + 1)));
    text.push('\n');
    let flags = rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK;
    let file: File = OpenOptions::new()
        .write(true)
        .create(true)
        .truncate(false)
        .custom_flags(flags.bits() as i32)
        .open(folder.join(NAME))?;
    if file.metadata()?.len() == 0 {
        crate::access::of_file(&file)?;
    }
    file.write_all_at(text.as_bytes(), 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn owner(host: &str, state_dir: &Path) -> Owner {
        Owner { host: host.to_owned(), ..Owner::of_this_process(state_dir, Timestamp::UNIX_EPOCH).unwrap() }
    }

    #[test]
    fn a_folder_has_one_owner_at_a_time_and_the_refusal_names_it() {
        let dir = tempfile::tempdir().unwrap();
        let (a, b, folder) = (dir.path().join("a"), dir.path().join("b"), dir.path().join("inbox"));
        for made in [&a, &b, &folder] {
            fs::create_dir(made).unwrap();
        }
        let lock = lock::Lock::take(&a, Timestamp::UNIX_EPOCH).unwrap();
        let mut first = Hold::new(owner(&lock::host_name(), &a), &folder);
        first.keep().unwrap();
        first.keep().unwrap();
        let mut second = Hold::new(owner(&lock::host_name(), &b), &folder);
        let refused = second.keep().unwrap_err().to_string();
        let pid = std::process::id();
        assert!(refused.contains(&format!("process {pid} on {}", lock::host_name())), "{refused}");
        assert!(refused.contains("since 1970-01-01") && refused.contains("Stop that one"), "{refused}");
        drop(lock);
        second.keep().unwrap();
        assert!(fs::metadata(folder.join(NAME)).unwrap().len() == BYTES as u64);
    }

    #[test]
    fn a_daemon_on_another_server_lives_while_its_number_moves() {
        let dir = tempfile::tempdir().unwrap();
        let mut far = Hold::new(owner("far", dir.path()), dir.path());
        let mut near = Hold::new(owner("near", dir.path()), dir.path());
        far.keep().unwrap();
        assert!(matches!(near.keep(), Err(OwnerError::Unclear { .. })));
        assert!(matches!(near.keep(), Err(OwnerError::Unclear { .. })));
        far.keep().unwrap();
        assert!(matches!(near.keep(), Err(OwnerError::Other { .. })));
        far.end();
        near.keep().unwrap();
        assert!(matches!(far.keep(), Err(OwnerError::Unclear { .. })));
    }

    #[test]
    fn an_empty_directory_in_its_place_is_not_the_folder_and_a_lost_marker_is_made_again() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("inbox");
        fs::create_dir(&folder).unwrap();
        let mut hold = Hold::new(owner("here", dir.path()), &folder);
        hold.keep().unwrap();
        fs::remove_file(folder.join(NAME)).unwrap();
        hold.keep().unwrap();
        fs::rename(&folder, dir.path().join("away")).unwrap();
        assert!(matches!(hold.keep(), Err(OwnerError::Io { .. })));
        fs::create_dir(&folder).unwrap();
        assert!(matches!(hold.keep(), Err(OwnerError::Replaced(_))));
        assert!(!folder.join(NAME).exists());
        fs::remove_dir(&folder).unwrap();
        fs::rename(dir.path().join("away"), &folder).unwrap();
        hold.keep().unwrap();
    }
}
