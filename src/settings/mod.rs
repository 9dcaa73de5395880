//! Configuration in three stages: fragments (one per file, all values optional and with their positions) -> inputs
//! (merged, with defaults) -> [`Settings`] (validated, the only type that the daemon uses).

mod duration;
mod farm_zone;
mod folder_conflicts;
mod folders;
mod fragment;
mod inputs;
mod keep_out;
mod load;
mod logging;
mod metrics;
mod node;
mod notification_kind;
mod notify;
mod option_group;
mod optional;
mod printer;
mod printer_validation;
mod problem;
mod problem_text;
mod profile;
mod profile_inputs;
mod profile_snapshot;
mod settings;
mod validation_rules;
mod validator;
mod web;
mod work_calendar;

pub use duration::parse_secs;
pub use farm_zone::FarmZone;
pub use keep_out::KeepOutZone;
pub use load::{SettingsError, find_config_file, load_for_viewing, load_settings};
pub use logging::{LogFormat, LogSettings, parse_log_filter};
pub use metrics::MetricsFile;
pub use node::NodeSettings;
pub use notification_kind::NotificationKind;
pub use notify::{NotifySettings, WebhookSettings};
pub use printer::{ApprovalPolicy, PrinterRules, PrintingRules, WithdrawalPolicy};
pub use problem::ConfigProblem;
pub use profile::{
    BuildSpace, DuplicatePolicy, IntakeRules, MachineFolders, MachineProfile, MeshErrorPolicy, OutputRules,
    SearchRules, TriggerRules, TurningRules, is_profile_name,
};
pub use settings::{InterfaceSettings, ResourceSettings, Settings, SharedSettings};
pub use web::{ListenAddress, WebSettings};
pub use work_calendar::WorkCalendar;

#[cfg(test)]
mod tests;
