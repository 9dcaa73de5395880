//! The second stage: the values of all files, merged, with defaults for missing ones. Only types are checked here. All
//! defaults are defined here and documented in `config/nestd.toml`; a test compares both.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{
    DuplicatePolicy, KeepOutZone, LogFormat, MeshErrorPolicy, NotificationKind, duration::DurationSecs,
    optional::OptionalValue,
};
use crate::intake;

/// The farm file, `nestd.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct FarmInputs {
    pub root: PathBuf,
    pub scan_secs: DurationSecs,
    pub orphan_ticket_secs: DurationSecs,
    pub threads: usize,
    pub cache_bytes: u64,
    pub folders: FarmFolders,
    pub files: FileInputs,
    pub log: LogInputs,
    pub web: WebInputs,
    pub metrics: MetricsInputs,
    pub notify: NotifyInputs,
    pub limits: build_file::ReadLimits,
    pub defaults: ProfileInputs,
}

impl Default for FarmInputs {
    fn default() -> Self {
        Self {
            root: "./farm".into(),
            scan_secs: DurationSecs(10.0),
            orphan_ticket_secs: DurationSecs(3600.0),
            threads: 0,
            cache_bytes: 1 << 30,
            folders: FarmFolders::default(),
            files: FileInputs::default(),
            log: LogInputs::default(),
            web: WebInputs::default(),
            metrics: MetricsInputs::default(),
            notify: NotifyInputs::default(),
            limits: build_file::ReadLimits::default(),
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

/// `[files]` of the farm file: mode and group of the files that the daemon creates.
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
        // The notify crate warns whenever a claim moves a watched folder away. This is harmless, because the periodic
        // scan finds what the watcher misses.
        Self { filter: "info,notify=error".into(), format: LogFormat::Auto }
    }
}

/// `[web]` of the farm file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct WebInputs {
    pub listen: String,
    pub token_file: OptionalValue<PathBuf>,
    pub hosts: Vec<String>,
    pub orders: bool,
}

impl Default for WebInputs {
    fn default() -> Self {
        Self { listen: "off".to_owned(), token_file: OptionalValue::OFF, hosts: Vec::new(), orders: true }
    }
}

/// `[metrics]` of the farm file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct MetricsInputs {
    pub textfile: OptionalValue<PathBuf>,
    pub every_secs: DurationSecs,
}

impl Default for MetricsInputs {
    fn default() -> Self {
        Self { textfile: OptionalValue::OFF, every_secs: DurationSecs(15.0) }
    }
}

/// `[notify]` of the farm file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct NotifyInputs {
    pub events: Vec<NotificationKind>,
    pub webhook: OptionalValue<String>,
    pub secret_file: OptionalValue<PathBuf>,
    pub command: Vec<String>,
    pub timeout_secs: DurationSecs,
    pub keep_secs: DurationSecs,
}

impl Default for NotifyInputs {
    fn default() -> Self {
        Self {
            events: vec![
                NotificationKind::Published,
                NotificationKind::Refused,
                NotificationKind::Unavailable,
                NotificationKind::AtRisk,
            ],
            webhook: OptionalValue::OFF,
            secret_file: OptionalValue::OFF,
            command: Vec::new(),
            timeout_secs: DurationSecs(10.0),
            keep_secs: DurationSecs(604_800.0),
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
    pub keep_out: Vec<KeepOutZone>,
    pub clearance_mm: f64,
    pub clearance_z_extra_mm: f64,
    pub layer_mm: f64,
    pub layer_area_cap: OptionalValue<f64>,
    pub print_hours_per_mm: f64,
    pub unit: build_file::LengthUnit,
    pub orientation: nester::OrientationRule,
    pub keep_up: Vec<nester::TiltLimit>,
    pub not_down: Vec<nester::FaceNotDown>,
    pub settle_secs: DurationSecs,
    pub unfinished_secs: DurationSecs,
    pub incomplete_secs: DurationSecs,
    pub unlisted: intake::UnlistedPolicy,
    pub duplicates: DuplicatePolicy,
    pub mesh_errors: MeshErrorPolicy,
    pub final_secs: DurationSecs,
    pub arrival_secs: DurationSecs,
    pub max_attempts: u32,
    pub instances: build_file::InstanceSharing,
    pub arrangement: build_file::Arrangement,
    pub stl_output: bool,
    pub archive_days: u32,
    pub folders: ProfileFolders,
    pub trigger: TriggerInputs,
    pub nest: nester::NestingConfig,
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
            layer_area_cap: OptionalValue::OFF,
            print_hours_per_mm: 0.1,
            unit: build_file::LengthUnit::default(),
            orientation: nester::OrientationRule::default(),
            keep_up: Vec::new(),
            not_down: Vec::new(),
            settle_secs: DurationSecs(5.0),
            unfinished_secs: DurationSecs(120.0),
            incomplete_secs: DurationSecs(600.0),
            unlisted: intake::UnlistedPolicy::default(),
            duplicates: DuplicatePolicy::default(),
            mesh_errors: MeshErrorPolicy::default(),
            final_secs: DurationSecs(60.0),
            arrival_secs: DurationSecs(20.0),
            max_attempts: 3,
            instances: build_file::InstanceSharing::default(),
            arrangement: build_file::Arrangement::default(),
            stl_output: false,
            archive_days: 90,
            folders: ProfileFolders::default(),
            trigger: TriggerInputs::default(),
            nest: nester::NestingConfig::default(),
        }
    }
}

/// `[folders]` of a profile's file: exact folders that replace those below the farm's folders.
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
    pub fill_height: OptionalValue<f64>,
    pub fill_density: OptionalValue<f64>,
    pub copies: OptionalValue<u32>,
    pub max_wait_secs: DurationSecs,
    pub due_margin_secs: OptionalValue<DurationSecs>,
    pub at: Vec<String>,
}

impl Default for TriggerInputs {
    fn default() -> Self {
        Self {
            fill_height: OptionalValue::OFF,
            fill_density: OptionalValue::OFF,
            copies: OptionalValue::OFF,
            max_wait_secs: DurationSecs(86_400.0),
            due_margin_secs: OptionalValue(Some(DurationSecs(3600.0))),
            at: Vec::new(),
        }
    }
}
