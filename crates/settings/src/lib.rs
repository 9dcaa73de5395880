//! Configuration in three stages: fragments (one per file, all values optional and with their positions) -> inputs
//! (merged, with defaults) -> [`Settings`] (validated, the only type that the daemon uses).

pub use machine::cost_rules::{CostRules, Money, PriceSum};
pub use machine::farm_zone::FarmZone;
pub use machine::keep_out::KeepOutZone;
pub use machine::materials::Materials;
pub use machine::printer::{ApprovalPolicy, PrinterRules, PrintingRules, WithdrawalPolicy};
pub use machine::profile::{
    BuildSpace, DuplicatePolicy, IntakeRules, MachineFolders, MachineProfile, MeshErrorPolicy, OutputRules,
    SearchRules, TriggerRules, TurningRules, is_machine_name,
};
pub use machine::work_calendar::WorkCalendar;
pub use reading::duration::parse_secs;
pub use reading::notification_kind::NotificationKind;
pub use reading::problem::ConfigProblem;
pub use service::email::{EmailSettings, MailEncryption};
pub use service::logging::{LogFormat, LogSettings, parse_log_filter};
pub use service::metrics::MetricsFile;
pub use service::node::NodeSettings;
pub use service::notify::{NotifySettings, WebhookSettings};
pub use service::settings::{InterfaceSettings, ResourceSettings, Settings, SharedSettings};
pub use service::web::{ListenAddress, WebSettings};
pub use validation::load::{OtherMachine, SettingsError, find_config_file, load_for_viewing, load_settings};
pub use validation::profile_snapshot::given_or_null;

mod machine;
mod reading;
mod service;
#[cfg(test)]
mod tests;
mod validation;
