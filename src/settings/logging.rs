//! What the log holds and what it looks like.

use serde::{Deserialize, Serialize};

/// What a log line looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LogFormat {
    /// The journal when systemd started the daemon, else text.
    #[default]
    Auto,
    /// One line for people, on standard error.
    Text,
    /// One JSON object a line, on standard error.
    Json,
}

/// What the log holds and what it looks like.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Logging {
    /// Levels by module, as `tracing` spells them: "info", "info,nestd::intake=debug".
    pub filter: String,
    /// What a line looks like.
    pub format: LogFormat,
}
