//! The options that all commands share, and how commands end.

use std::path::PathBuf;

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandExit {
    /// The work is done.
    Success,
    /// The work failed, and the reason has been printed.
    Failure,
}

/// Wrong use or configuration: exit code 2. Wrap it in `anyhow` and return it.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);

/// Options of every command.
#[derive(Debug, clap::Args)]
pub struct CommonArgs {
    /// Configuration file [default: config/nestd.toml, else /etc/nestd/nestd.toml]
    #[arg(short = 'c', long = "config", global = true, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Root of the farm's folders: DIR/inbox, DIR/queue, DIR/error, DIR/archive, DIR/state
    #[arg(long, global = true, value_name = "DIR", env = "NESTD_ROOT")]
    pub root: Option<PathBuf>,
}
