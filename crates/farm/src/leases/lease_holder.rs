//! The daemon that serves a folder, as it is named in the folder's marker, and how two of them are told apart.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Write},
    os::unix::fs::{MetadataExt, OpenOptionsExt},
    path::{Path, PathBuf},
};

use jiff::Timestamp;
use ledger::SharedFarm;
use rustix::fs::{FlockOperation, flock};
use serde::{Deserialize, Serialize};

use super::state_lock;

/// Name of the file with the farm's id in the state directory.
pub const FARM_ID_FILE: &str = "nestd.farm";

/// A daemon, as named in its marker.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeaseHolder {
    /// Id of its farm: a random number in its state directory.
    pub(crate) farm: String,
    /// Name of its server.
    pub(crate) host: String,
    /// Its state directory.
    pub(crate) state_dir: PathBuf,
    /// Where its state directory is: boot of the machine, device and inode; the database, where nodes share a ledger: of these the
    /// ledger says who serves a folder. "" = an older nestd wrote the marker.
    #[serde(default)]
    pub(crate) place: String,
    /// Process id.
    pub(crate) pid: u32,
    /// Start time.
    pub(crate) since: Timestamp,
    /// Changes as long as the daemon lives.
    pub(super) beat: u64,
    /// The daemon has stopped in order.
    pub(crate) stopped: bool,
}

impl LeaseHolder {
    /// Id of its farm.
    pub fn farm_id(&self) -> &str {
        &self.farm
    }

    /// The daemon of this process.
    pub fn for_this_process(state_dir: &Path, since: Timestamp) -> io::Result<Self> {
        let farm = FarmIdentity::read_or_create(state_dir)?;
        let state_dir = fs::canonicalize(state_dir)?;
        let place = if farm.database.is_empty() { find_place(&state_dir)? } else { farm.database };
        Ok(Self {
            place,
            farm: farm.id,
            host: state_lock::host_name(),
            state_dir,
            pid: std::process::id(),
            since,
            beat: 0,
            stopped: false,
        })
    }

    /// Whether the state directory has a farm id.
    pub(crate) fn has_farm_id(state_dir: &Path) -> bool {
        state_dir.join(FARM_ID_FILE).exists()
    }

    /// Its state directory.
    pub(crate) fn state_dir(&self) -> &Path {
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

    /// Whether both are the same farm: they share a ledger, whose leases say who of them serves what; or this process holds the
    /// lock of its state directory, so an earlier daemon of it is dead. A copied state directory is another farm, also on a machine that was copied with its name; so is one
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

/// What a state directory says of its farm.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct FarmIdentity {
    /// A random number.
    pub(crate) id: String,
    /// The database of the ledger that it shares with other nodes; "" = it has a ledger of its own.
    pub(crate) database: String,
}

impl FarmIdentity {
    /// The identity that the state directory has; `None` = it has none yet.
    pub(crate) fn read(state_dir: &Path) -> io::Result<Option<Self>> {
        match fs::read_to_string(state_dir.join(FARM_ID_FILE)) {
            Ok(text) => {
                let mut lines = text.lines().map(|line| line.trim().to_owned());
                let (id, database) = (lines.next().unwrap_or_default(), lines.next().unwrap_or_default());
                Ok((!id.is_empty()).then_some(Self { id, database }))
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The identity of the state directory, made at the first start.
    fn read_or_create(state_dir: &Path) -> io::Result<Self> {
        match Self::read(state_dir)? {
            Some(known) => Ok(known),
            None => {
                let new = Self { id: format!("{:032x}", rand::random::<u128>()), database: String::new() };
                new.write_into(state_dir).map(|()| new)
            }
        }
    }

    /// The identity once the ledger was opened: where nodes share it, they are one farm.
    pub(crate) fn of_ledger(known: Option<Self>, shared: Option<SharedFarm>) -> Option<Self> {
        match (known, shared) {
            (_, Some(SharedFarm { id, database })) => Some(Self { id, database }),
            (Some(known), None) => Some(Self { database: String::new(), ..known }),
            (None, None) => None,
        }
    }

    /// Writes it; it is on disk when this returns.
    pub(crate) fn write_into(&self, state_dir: &Path) -> io::Result<()> {
        let mut file = tempfile::Builder::new().prefix(".nestd-farm-").tempfile_in(state_dir)?;
        writeln!(file, "{}", self.id)?;
        if !self.database.is_empty() {
            writeln!(file, "{}", self.database)?;
        }
        file.as_file().sync_all()?;
        file.persist(state_dir.join(FARM_ID_FILE))?;
        File::open(state_dir)?.sync_all()
    }
}

/// Where a state directory is. A reboot changes it, because a copy of a machine boots anew too.
pub(super) fn find_place(state_dir: &Path) -> io::Result<String> {
    let meta = fs::metadata(state_dir)?;
    // Without it, the name of the server and the path must do.
    let Ok(boot) = fs::read_to_string("/proc/sys/kernel/random/boot_id") else { return Ok(String::new()) };
    Ok(format!("{}:{:x}:{:x}", boot.trim(), meta.dev(), meta.ino()))
}
