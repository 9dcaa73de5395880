//! The validated settings of a farm.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::{Arc, RwLock},
};

use access::FilePermissions;
use language::Language;
use ledger::LedgerAddress;

use crate::{
    FarmZone, LogSettings, MachineFolders, MachineProfile, Materials, MetricsFile, NodeSettings, NotifySettings,
    WebSettings,
};

/// The settings that the daemon loaded last, shared with the other tasks. A reload replaces them.
pub type SharedSettings = Arc<RwLock<Arc<Settings>>>;

/// The complete, validated settings of the daemon. Created only by loading a configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The configuration file that was read.
    pub file: PathBuf,
    /// Absolute root of the farm. Relative folders are below it.
    pub root: PathBuf,
    /// Its time zone.
    pub time_zone: FarmZone,
    /// The language of what it writes into folders, and of pages where a browser asks for none that is known.
    pub language: Language,
    /// This daemon among those that share one ledger.
    pub node: NodeSettings,
    /// The folder that contains the hot folders, except those that a machine sets itself.
    pub inbox_base: PathBuf,
    /// The state directory: ledger, content-addressed store, caches. On a local disk.
    pub state_dir: PathBuf,
    /// The ledger, by default the file `state_dir/nestd.db`.
    pub ledger: LedgerAddress,
    /// Seconds between two full scans of the hot folders.
    pub scan_secs: f64,
    /// Seconds after which a ticket without its part is refused.
    pub orphan_ticket_secs: f64,
    /// What nesting may use of the computer.
    pub resources: ResourceSettings,
    /// Limits for reading part files.
    pub limits: build_file::ReadLimits,
    /// Mode and group of the files that the daemon creates in the farm's folders.
    pub files: FilePermissions,
    /// What people and other programs see of the daemon.
    pub interfaces: InterfaceSettings,
    /// What materials are called.
    pub materials: Materials,
    /// The profiles by the names of their machines.
    pub profiles: BTreeMap<String, MachineProfile>,
}

/// What nesting may use of the computer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResourceSettings {
    /// Threads for nesting; 0 = one per core.
    pub threads: usize,
    /// Maximum size of the prepared meshes kept in the state directory, bytes; 0 = none are kept.
    pub cache_bytes: u64,
}

impl ResourceSettings {
    /// The number of threads for nesting.
    pub fn thread_count(&self) -> usize {
        match self.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        }
    }
}

/// What people and other programs see of the daemon: log, pages, metrics and notifications.
#[derive(Debug, Clone, PartialEq)]
pub struct InterfaceSettings {
    /// Settings of the log.
    pub log: LogSettings,
    /// The dashboard; `None` = no port is opened.
    pub web: Option<WebSettings>,
    /// The metrics file; `None` = none is written.
    pub metrics: Option<MetricsFile>,
    /// Settings of notifications.
    pub notify: NotifySettings,
}

impl Settings {
    /// Every folder of the farm on this server: those of its machines, and the state directory.
    pub fn all_folders(&self) -> Vec<PathBuf> {
        let own = self.profiles.values().filter(|profile| profile.of_node.is_empty());
        let of_machines = own.flat_map(|profile| {
            let MachineFolders { inbox, queue: _, error, archive } = &profile.folders;
            [inbox, error, archive].map(PathBuf::as_path).into_iter().chain(profile.queue_folders())
        });
        of_machines.chain([self.state_dir.as_path()]).map(Path::to_owned).collect()
    }
}
