//! The second stage: what the files say, merged and filled up with defaults. Nothing is checked yet but the kinds of the
//! values. The defaults of all options stand here and, documented, in `config/nestd.toml`; a test compares the two.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{Duplicates, KeepOut, LogFormat, MeshErrors, Told, duration::Secs, off::OrOff};
use crate::intake;

/// The farm file, `nestd.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct FarmInputs {
    pub root: PathBuf,
    pub scan_secs: Secs,
    pub orphan_ticket_secs: Secs,
    pub threads: usize,
    pub cache_bytes: u64,
    pub folders: FarmFolders,
    pub files: FileInputs,
    pub log: LogInputs,
    pub web: WebInputs,
    pub metrics: MetricsInputs,
    pub notify: NotifyInputs,
    pub limits: build_file::Limits,
    pub defaults: ProfileInputs,
}

impl Default for FarmInputs {
    fn default() -> Self {
        Self {
            root: "./farm".into(),
            scan_secs: Secs(10.0),
            orphan_ticket_secs: Secs(3600.0),
            threads: 0,
            cache_bytes: 1 << 30,
            folders: FarmFolders::default(),
            files: FileInputs::default(),
            log: LogInputs::default(),
            web: WebInputs::default(),
            metrics: MetricsInputs::default(),
            notify: NotifyInputs::default(),
            limits: build_file::Limits::default(),
            defaults: ProfileInputs::default(),
        }
    }
}

/// `[folders]` of the farm file: the folders that hold one folder per profile, and the state directory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct FarmFolders {
    pub inbox: PathBuf,
    pub queue: PathBuf,
    pub error: PathBuf,
    pub archive: PathBuf,
    pub state: PathBuf,
    pub ledger: PathBuf,
}

impl Default for FarmFolders {
    fn default() -> Self {
        Self {
            inbox: "inbox".into(),
            queue: "queue".into(),
            error: "error".into(),
            archive: "archive".into(),
            state: "state".into(),
            ledger: "nestd.db".into(),
        }
    }
}

/// `[files]` of the farm file: what the daemon makes in the farm's folders.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct FileInputs {
    pub mode: String,
    pub group: String,
}

impl Default for FileInputs {
    fn default() -> Self {
        Self { mode: "0660".into(), group: String::new() }
    }
}

/// `[log]` of the farm file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct LogInputs {
    pub filter: String,
    pub format: LogFormat,
}

impl Default for LogInputs {
    fn default() -> Self {
        // The watch crate warns each time a claim takes a folder away under it; scanning makes up for what it misses.
        Self { filter: "info,notify=error".into(), format: LogFormat::Auto }
    }
}

/// `[web]` of the farm file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct WebInputs {
    pub listen: String,
    pub token_file: OrOff<PathBuf>,
    pub hosts: Vec<String>,
    pub orders: bool,
}

impl Default for WebInputs {
    fn default() -> Self {
        Self { listen: "off".to_owned(), token_file: OrOff::OFF, hosts: Vec::new(), orders: true }
    }
}

/// `[metrics]` of the farm file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct MetricsInputs {
    pub textfile: OrOff<PathBuf>,
    pub every_secs: Secs,
}

impl Default for MetricsInputs {
    fn default() -> Self {
        Self { textfile: OrOff::OFF, every_secs: Secs(15.0) }
    }
}

/// `[notify]` of the farm file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct NotifyInputs {
    pub events: Vec<Told>,
    pub webhook: OrOff<String>,
    pub secret_file: OrOff<PathBuf>,
    pub command: Vec<String>,
    pub timeout_secs: Secs,
    pub keep_secs: Secs,
}

impl Default for NotifyInputs {
    fn default() -> Self {
        Self {
            events: vec![Told::Published, Told::Refused, Told::Unavailable, Told::AtRisk],
            webhook: OrOff::OFF,
            secret_file: OrOff::OFF,
            command: Vec::new(),
            timeout_secs: Secs(10.0),
            keep_secs: Secs(604_800.0),
        }
    }
}

/// A profile's file; also `[defaults]` of the farm file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct ProfileInputs {
    /// The only option without a default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume_mm: Option<[f64; 3]>,
    pub wall_margin_mm: f64,
    pub floor_margin_mm: f64,
    pub lid_margin_mm: f64,
    pub keep_out: Vec<KeepOut>,
    pub clearance_mm: f64,
    pub clearance_z_extra_mm: f64,
    pub layer_mm: f64,
    pub layer_area_cap: OrOff<f64>,
    pub print_hours_per_mm: f64,
    pub unit: build_file::Unit,
    pub orientation: nester::OrientationRule,
    pub keep_up: Vec<nester::Tilt>,
    pub not_down: Vec<nester::NotDown>,
    pub settle_secs: Secs,
    pub unfinished_secs: Secs,
    pub incomplete_secs: Secs,
    pub unlisted: intake::Unlisted,
    pub duplicates: Duplicates,
    pub mesh_errors: MeshErrors,
    pub final_secs: Secs,
    pub arrival_secs: Secs,
    pub max_attempts: u32,
    pub instances: build_file::Instances,
    pub arrangement: build_file::Arrangement,
    pub stl_output: bool,
    pub archive_days: u32,
    pub folders: ProfileFolders,
    pub trigger: TriggerInputs,
    pub nest: nester::Config,
}

impl Default for ProfileInputs {
    fn default() -> Self {
        Self {
            volume_mm: None,
            wall_margin_mm: 0.0,
            floor_margin_mm: 0.0,
            lid_margin_mm: 0.0,
            keep_out: Vec::new(),
            clearance_mm: 3.0,
            clearance_z_extra_mm: 0.0,
            layer_mm: nester::DEFAULT_LAYER_MM,
            layer_area_cap: OrOff::OFF,
            print_hours_per_mm: 0.1,
            unit: build_file::Unit::default(),
            orientation: nester::OrientationRule::default(),
            keep_up: Vec::new(),
            not_down: Vec::new(),
            settle_secs: Secs(5.0),
            unfinished_secs: Secs(120.0),
            incomplete_secs: Secs(600.0),
            unlisted: intake::Unlisted::default(),
            duplicates: Duplicates::default(),
            mesh_errors: MeshErrors::default(),
            final_secs: Secs(60.0),
            arrival_secs: Secs(20.0),
            max_attempts: 3,
            instances: build_file::Instances::default(),
            arrangement: build_file::Arrangement::default(),
            stl_output: false,
            archive_days: 90,
            folders: ProfileFolders::default(),
            trigger: TriggerInputs::default(),
            nest: nester::Config::default(),
        }
    }
}

/// `[folders]` of a profile's file: exact folders instead of those below the farm's.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct ProfileFolders {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inbox: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub queue: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub archive: Option<PathBuf>,
}

/// `[trigger]` of a profile.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct TriggerInputs {
    pub fill_height: OrOff<f64>,
    pub fill_density: OrOff<f64>,
    pub copies: OrOff<u32>,
    pub max_wait_secs: Secs,
    pub due_margin_secs: OrOff<Secs>,
    pub at: Vec<String>,
}

impl Default for TriggerInputs {
    fn default() -> Self {
        Self {
            fill_height: OrOff::OFF,
            fill_density: OrOff::OFF,
            copies: OrOff::OFF,
            max_wait_secs: Secs(86_400.0),
            due_margin_secs: OrOff(Some(Secs(3600.0))),
            at: Vec::new(),
        }
    }
}
