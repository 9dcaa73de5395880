//! The daemon that serves a folder, as it is named in the folder's marker, and how two of them are told apart.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Write},
    os::unix::fs::{MetadataExt, OpenOptionsExt},
    path::{Path, PathBuf},
};

use jiff::Timestamp;
use rustix::fs::{FlockOperation, flock};
use serde::{Deserialize, Serialize};

use super::state_lock;

/// Name of the file with the farm's id in the state directory.
pub const FARM_ID_FILE: &str = "nestd.farm";

/// A daemon, as named in its marker.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeaseHolder {
    /// Id of its farm: a random number in its state directory.
    pub(super) farm: String,
    /// Name of its server.
    pub(super) host: String,
    /// Its state directory.
    pub(super) state_dir: PathBuf,
    /// Where its state directory is: boot of the machine, device and inode. "" = an older nestd wrote the marker.
    #[serde(default)]
    pub(super) place: String,
    /// Process id.
    pub(super) pid: u32,
    /// Start time.
    pub(super) since: Timestamp,
    /// Changes as long as the daemon lives.
    pub(super) beat: u64,
    /// The daemon has stopped in order.
    pub(super) stopped: bool,
}

impl LeaseHolder {
    /// Id of its farm.
    pub fn farm_id(&self) -> &str {
        &self.farm
    }

    /// The daemon of this process.
    pub fn for_this_process(state_dir: &Path, since: Timestamp) -> io::Result<Self> {
        let farm = read_or_create_farm_id(state_dir)?;
        let state_dir = fs::canonicalize(state_dir)?;
        Ok(Self {
            place: find_place(&state_dir)?,
            farm,
            host: state_lock::host_name(),
            state_dir,
            pid: std::process::id(),
            since,
            beat: 0,
            stopped: false,
        })
    }

    /// Whether the state directory has a farm id.
    pub(super) fn has_farm_id(state_dir: &Path) -> bool {
        state_dir.join(FARM_ID_FILE).exists()
    }

    /// Its state directory.
    pub(super) fn state_dir(&self) -> &Path {
        &self.state_dir
    }

    /// Whether the daemon ran on this server.
    pub(super) fn is_on_this_host(&self) -> bool {
        self.host == state_lock::host_name()
    }

    /// Whether the daemon may be alive, as far as this can be decided at once: it has not stopped, and it holds its
    /// lock or is on another server.
    pub(super) fn may_be_alive(&self) -> bool {
        !(self.stopped || self.is_on_this_host() && self.is_state_lock_held() == Some(false))
    }

    /// Whether the daemon holds its lock on this server.
    pub(super) fn is_certainly_alive(&self) -> bool {
        self.is_on_this_host() && self.is_state_lock_held() == Some(true)
    }

    /// Whether both are the same farm: this process holds the lock of its state directory, so an earlier daemon of it
    /// is dead. A copied state directory is another farm, also on a machine that was copied with its name; so is one
    /// that was moved to another server. A container may have another name at each start.
    pub(super) fn is_same_farm(&self, other: &Self) -> bool {
        let is_known = !(self.place.is_empty() || other.place.is_empty());
        self.farm == other.farm
            && match is_known {
                true => self.place == other.place,
                false => (&self.host, &self.state_dir) == (&other.host, &other.state_dir),
            }
    }

    /// Changes the number that shows that the daemon lives. It is the time, so that two copies of one running machine
    /// write different numbers.
    pub(super) fn change_beat(&mut self) {
        let now = Timestamp::now().as_nanosecond() as u64;
        self.beat = now.max(self.beat + 1);
    }

    /// Whether the daemon holds the lock of its state directory; `None` = this cannot be decided from here. (Containers
    /// may share the name of their server and each have a folder of their own under the same path.)
    pub(super) fn holds_state_lock(&self, asks: &Self) -> Option<bool> {
        if self.host != asks.host || self.state_dir == asks.state_dir {
            return None;
        }
        self.is_state_lock_held()
    }

    fn is_state_lock_held(&self) -> Option<bool> {
        let nofollow = (rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK).bits();
        let path = self.state_dir.join(state_lock::NAME);
        let file = OpenOptions::new().read(true).custom_flags(nofollow as i32).open(path).ok()?;
        match flock(&file, FlockOperation::NonBlockingLockShared) {
            Ok(()) => Some(false),
            Err(rustix::io::Errno::WOULDBLOCK) => Some(true),
            Err(_) => None,
        }
    }
}

/// The id of a farm, created at its first start.
fn read_or_create_farm_id(state_dir: &Path) -> io::Result<String> {
    let path = state_dir.join(FARM_ID_FILE);
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

/// Where a state directory is. A reboot changes it, because a copy of a machine boots anew too.
pub(super) fn find_place(state_dir: &Path) -> io::Result<String> {
    let meta = fs::metadata(state_dir)?;
    // Without it, the name of the server and the path must do.
    let Ok(boot) = fs::read_to_string("/proc/sys/kernel/random/boot_id") else { return Ok(String::new()) };
    Ok(format!("{}:{:x}:{:x}", boot.trim(), meta.dev(), meta.ino()))
}
