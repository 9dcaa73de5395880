//! Starts the log: to the journal under systemd, else to standard error.

use std::{
    env,
    io::{self, Write},
    os::unix::fs::MetadataExt,
};

use anyhow::{Context, Error, Result};
use build_file::is_invisible;
use settings::{LogFormat, LogSettings, parse_log_filter};
use tracing_subscriber::{Layer, Registry, layer::SubscriberExt, util::SubscriberInitExt};

/// The environment variable that overrides the configured filter.
const FILTER_VARIABLE: &str = "NESTD_LOG";
/// Set by systemd for a service whose output goes to the journal; holds device and inode of that output.
const JOURNAL_VARIABLE: &str = "JOURNAL_STREAM";

/// Starts the log. `NESTD_LOG` overrides the configured filter. To be called once, by the commands that run the farm.
///
/// # Errors
/// When the filter is invalid, when the log was started before, or when the journal cannot be reached.
pub fn start_logging(logging: &LogSettings) -> Result<()> {
    let (place, filter) = match env::var(FILTER_VARIABLE) {
        Ok(filter) if !filter.is_empty() => (FILTER_VARIABLE, filter),
        _ => ("log.filter", logging.filter.clone()),
    };
    let filter = parse_log_filter(&with_quiet_watcher(&filter)).map_err(Error::msg).context(place)?;
    tracing_subscriber::registry()
        .with(log_layer(logging.format)?.with_filter(filter))
        .try_init()
        .context("starting the log")
}

/// Adds `notify=warn` to a filter, unless the filter names that crate itself. The crate that watches folders otherwise
/// logs every removed folder.
fn with_quiet_watcher(filter: &str) -> String {
    format!("notify=warn,{filter}")
}

/// The layer that formats events as lines.
fn log_layer(format: LogFormat) -> Result<Box<dyn Layer<Registry> + Send + Sync>> {
    let text = tracing_subscriber::fmt::layer().with_writer(|| OneLineStderr);
    Ok(match format {
        LogFormat::Auto if goes_to_journal() => {
            tracing_journald::layer().context("reaching the journal")?.with_syslog_identifier("nestd".into()).boxed()
        }
        LogFormat::Auto | LogFormat::Text => text.with_ansi(false).with_target(false).compact().boxed(),
        LogFormat::Json => text.json().flatten_event(true).boxed(),
    })
}

/// Writes each event as one line to standard error. Text that an event quotes from outside, such as a file name, cannot
/// start a new line or move the cursor.
struct OneLineStderr;

impl Write for OneLineStderr {
    /// `event` is one whole event: the subscriber writes each event with one call.
    fn write(&mut self, event: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(event);
        let line = text.strip_suffix('\n').unwrap_or(&text);
        io::stderr().write_all(format!("{}\n", escape_invisible(line)).as_bytes())?;
        Ok(event.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}

/// Escapes invisible characters as `\u001b`, which is valid in JSON as well. JSON has escaped the ASCII controls
/// already.
fn escape_invisible(line: &str) -> String {
    let escaped = |c: char| c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")).collect::<String>();
    line.chars().map(|c| if is_invisible(c) { escaped(c) } else { c.to_string() }).collect()
}

/// Whether standard error is the journal. The variable alone does not prove it, because child processes inherit it even
/// when their output is redirected.
fn goes_to_journal() -> bool {
    let Ok(output) = std::fs::metadata("/proc/self/fd/2") else { return false };
    env::var(JOURNAL_VARIABLE).is_ok_and(|stream| stream == format!("{}:{}", output.dev(), output.ino()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_is_one_line_of_what_can_be_seen() {
        assert_eq!(escape_invisible("INFO a\n ERROR \u{1b}[2Jb\u{202e}"), r"INFO a\u000a ERROR \u001b[2Jb\u202e");
    }
}
