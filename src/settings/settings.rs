//! The validated settings of a farm.

use std::{
    collections::BTreeMap,
    path::PathBuf,
    sync::{Arc, RwLock},
};

use super::{Folders, Logging, MetricsFile, Notify, Profile, Web};
use crate::access::Access;

/// The settings as the daemon read them last, for those who work beside the farm; a reload changes them.
pub type Shared = Arc<RwLock<Arc<Settings>>>;

/// Everything the daemon needs to know, checked. Made only by reading a configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The configuration file that was read.
    pub file: PathBuf,
    /// The farm's root, absolute: relative folders are below it.
    pub root: PathBuf,
    /// The folder that holds the hot folders, except those that a profile names exactly.
    pub inbox_base: PathBuf,
    /// The state directory: ledger, content-addressed store, caches. On a local disk.
    pub state_dir: PathBuf,
    /// The ledger, by default `state_dir/nestd.db`.
    pub ledger: PathBuf,
    /// Seconds between two full scans of the hot folders.
    pub scan_secs: f64,
    /// Seconds after which a ticket without its part is refused.
    pub orphan_ticket_secs: f64,
    /// Threads that nest; 0 = one per core.
    pub threads: usize,
    /// What prepared meshes may take up in the state directory, bytes; 0 = none are kept.
    pub cache_bytes: u64,
    /// Limits of the readers.
    pub limits: build_file::Limits,
    /// Mode and group of what the daemon makes in the farm's folders.
    pub files: Access,
    /// What the log holds and what it looks like.
    pub log: Logging,
    /// The dashboard; `None` = no port is opened.
    pub web: Option<Web>,
    /// The file that holds the metrics; `None` = there is none.
    pub metrics: Option<MetricsFile>,
    /// Who is told what happens.
    pub notify: Notify,
    /// Machines by profile name.
    pub profiles: BTreeMap<String, Profile>,
}

impl Settings {
    /// Every folder of the farm: those of all profiles, and the state directory.
    pub fn folders(&self) -> Vec<PathBuf> {
        let of_profiles = self.profiles.values().flat_map(|profile| {
            let Folders { inbox, queue, error, archive } = &profile.folders;
            [inbox, queue, error, archive]
        });
        of_profiles.chain([&self.state_dir]).cloned().collect()
    }
}
