//! Configuration in three stages: fragments (one file each, all optional, every value with its place) -> inputs (merged,
//! defaults) -> [`Settings`] (validated, the only one that the daemon sees).

mod clash;
mod duration;
mod folders;
mod fragment;
mod inputs;
mod judge;
mod keep_out;
mod load;
mod logging;
mod metrics;
mod notify;
mod off;
mod problem;
mod profile;
mod settings;
mod then;
mod told;
mod validate;
mod web;
mod wording;

pub use duration::parse_secs;
pub use keep_out::KeepOut;
pub use load::{SettingsError, load, load_to_look};
pub use logging::{LogFormat, Logging, parse_log_filter};
pub use metrics::MetricsFile;
pub use notify::{Notify, Webhook};
pub use problem::Problem;
pub use profile::{
    BuildSpace, Duplicates, Folders, IntakeRules, MeshErrors, OutputRules, Profile, SearchRules, Trigger, TurningRules,
};
pub use settings::{Settings, Shared};
pub use told::Told;
pub use web::{Listen, Web};

#[cfg(test)]
mod tests;
