//! Where the log goes: the journal under systemd, else standard error.

use std::{
    env,
    io::{self, IsTerminal},
    os::unix::fs::MetadataExt,
};

use anyhow::{Context, Result};
use tracing_subscriber::{EnvFilter, Layer, Registry, layer::SubscriberExt, util::SubscriberInitExt};

use crate::settings::{LogFormat, Logging};

/// Beats the configured filter.
const FILTER_VARIABLE: &str = "NESTD_LOG";
/// Set by systemd for a service whose output goes to the journal: device and inode of that output.
const JOURNAL_VARIABLE: &str = "JOURNAL_STREAM";

/// Starts the log. `NESTD_LOG` beats the configured filter. To be called once, by the commands that run the farm.
///
/// # Errors
/// When the filter is none, the log was started before, or the journal cannot be reached.
pub fn start(logging: &Logging) -> Result<()> {
    let filter = match env::var(FILTER_VARIABLE) {
        Ok(filter) if !filter.is_empty() => EnvFilter::try_new(filter).context(FILTER_VARIABLE)?,
        _ => EnvFilter::try_new(&logging.filter).context("log.filter")?,
    };
    tracing_subscriber::registry()
        .with(lines(logging.format)?.with_filter(filter))
        .try_init()
        .context("starting the log")
}

/// What turns events into lines.
fn lines(format: LogFormat) -> Result<Box<dyn Layer<Registry> + Send + Sync>> {
    let text = tracing_subscriber::fmt::layer().with_writer(io::stderr);
    Ok(match format {
        LogFormat::Auto if goes_to_journal() => {
            tracing_journald::layer().context("reaching the journal")?.with_syslog_identifier("nestd".into()).boxed()
        }
        LogFormat::Auto | LogFormat::Text => {
            let colours = io::stderr().is_terminal() && env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
            text.with_ansi(colours).with_target(false).compact().boxed()
        }
        LogFormat::Json => text.json().flatten_event(true).boxed(),
    })
}

/// Whether standard error is the journal. The variable alone does not say so: it is inherited by shells and redirections.
fn goes_to_journal() -> bool {
    let Ok(output) = std::fs::metadata("/proc/self/fd/2") else { return false };
    env::var(JOURNAL_VARIABLE).is_ok_and(|stream| stream == format!("{}:{}", output.dev(), output.ino()))
}
