//! The second stage: the values of the farm file, with defaults for missing ones. Only types are checked here. All
//! defaults are defined here and in `profile_inputs`, and documented in `config/nestd.toml`; a test compares both.

use std::{collections::BTreeMap, path::PathBuf};

use serde::{Deserialize, Deserializer, Serialize};

use super::email::EmailInputs;
use crate::{
    LogFormat, NotificationKind,
    machine::profile_inputs::ProfileInputs,
    reading::{
        duration::DurationSecs,
        option_group::{option_group, read_option_table, read_options},
        optional::OptionalValue,
    },
};

/// The farm file, `nestd.toml`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct FarmInputs {
    pub root: PathBuf,
    pub time_zone: String,
    pub language: String,
    pub scan_secs: DurationSecs,
    pub orphan_ticket_secs: DurationSecs,
    #[serde(flatten)]
    pub resources: ResourceInputs,
    pub node: NodeInputs,
    pub folders: FarmFolders,
    pub files: FileInputs,
    pub log: LogInputs,
    pub web: WebInputs,
    pub metrics: MetricsInputs,
    pub notify: NotifyInputs,
    pub limits: build_file::ReadLimits,
    pub materials: BTreeMap<String, Vec<String>>,
    pub defaults: ProfileInputs,
}

impl Default for FarmInputs {
    fn default() -> Self {
        Self {
            root: "./farm".into(),
            time_zone: "system".to_owned(),
            language: language::Language::English.tag().to_owned(),
            scan_secs: DurationSecs(10.0),
            orphan_ticket_secs: DurationSecs(3600.0),
            resources: ResourceInputs::default(),
            node: NodeInputs::default(),
            folders: FarmFolders::default(),
            files: FileInputs::default(),
            log: LogInputs::default(),
            web: WebInputs::default(),
            metrics: MetricsInputs::default(),
            notify: NotifyInputs::default(),
            limits: build_file::ReadLimits::default(),
            materials: BTreeMap::new(),
            defaults: ProfileInputs::default(),
        }
    }
}

read_options!(
    FarmInputs: root time_zone language scan_secs orphan_ticket_secs node folders files log web metrics notify limits
    materials defaults,
    groups resources: ResourceInputs
);

impl<'de> Deserialize<'de> for FarmInputs {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read_option_table(deserializer)
    }
}

option_group! {
    /// What nesting may use of the computer.
    ResourceInputs {
        threads: usize = 0,
        cache_bytes: u64 = 1 << 30,
    }
}

/// The value of `node.name` that stands for the name of the server.
pub(crate) const HOST: &str = "host";

/// `[node]` of the farm file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct NodeInputs {
    pub name: String,
    pub address: OptionalValue<String>,
    pub connections: u32,
}

impl Default for NodeInputs {
    fn default() -> Self {
        Self { name: HOST.to_owned(), address: OptionalValue::OFF, connections: ledger::DAEMON_CONNECTIONS }
    }
}

/// `[folders]` of the farm file: the folders that hold one folder per machine, and the state directory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct FarmFolders {
    pub inbox: PathBuf,
    pub queue: PathBuf,
    pub error: PathBuf,
    pub archive: PathBuf,
    pub state: PathBuf,
    pub ledger: PathBuf,
    pub ledger_password_file: OptionalValue<PathBuf>,
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
            ledger_password_file: OptionalValue::OFF,
        }
    }
}

/// `[files]` of the farm file: mode and group of the files that the daemon creates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct FileInputs {
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
pub(crate) struct LogInputs {
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
pub(crate) struct WebInputs {
    pub listen: String,
    pub token_file: OptionalValue<PathBuf>,
    pub tokens_file: OptionalValue<PathBuf>,
    pub sign_in: bool,
    pub without_token: String,
    pub client_requests_per_sec: f64,
    pub client_burst: u32,
    pub client_bytes: u64,
    pub hosts: Vec<String>,
    pub orders: bool,
    pub user_header: OptionalValue<String>,
    pub user_header_from: Vec<String>,
}

impl Default for WebInputs {
    fn default() -> Self {
        let (listen, hosts) = ("off".to_owned(), Vec::new());
        Self {
            listen,
            token_file: OptionalValue::OFF,
            tokens_file: OptionalValue::OFF,
            sign_in: false,
            without_token: "nothing".to_owned(),
            client_requests_per_sec: 50.0,
            client_burst: 200,
            client_bytes: 8 << 30,
            hosts,
            orders: true,
            user_header: OptionalValue::OFF,
            user_header_from: Vec::new(),
        }
    }
}

/// `[metrics]` of the farm file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct MetricsInputs {
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
pub(crate) struct NotifyInputs {
    pub events: Vec<NotificationKind>,
    pub webhook: OptionalValue<String>,
    pub secret_file: OptionalValue<PathBuf>,
    pub command: Vec<String>,
    pub timeout_secs: DurationSecs,
    pub keep_secs: DurationSecs,
    pub email: EmailInputs,
}

impl Default for NotifyInputs {
    fn default() -> Self {
        Self {
            events: vec![
                NotificationKind::Published,
                NotificationKind::Refused,
                NotificationKind::Unavailable,
                NotificationKind::AtRisk,
                NotificationKind::OrderComplete,
                NotificationKind::OrderShort,
            ],
            webhook: OptionalValue::OFF,
            secret_file: OptionalValue::OFF,
            command: Vec::new(),
            timeout_secs: DurationSecs(10.0),
            keep_secs: DurationSecs(604_800.0),
            email: EmailInputs::default(),
        }
    }
}
