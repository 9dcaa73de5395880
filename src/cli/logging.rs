//! Where the log goes: the journal under systemd, else standard error.

use std::{
    env,
    io::{self, Write},
    os::unix::fs::MetadataExt,
};

use anyhow::{Context, Error, Result};
use build_file::is_invisible;
use tracing_subscriber::{Layer, Registry, layer::SubscriberExt, util::SubscriberInitExt};

use crate::settings::{LogFormat, Logging, parse_log_filter};

/// Beats the configured filter.
const FILTER_VARIABLE: &str = "NESTD_LOG";
/// Set by systemd for a service whose output goes to the journal: device and inode of that output.
const JOURNAL_VARIABLE: &str = "JOURNAL_STREAM";

/// Starts the log. `NESTD_LOG` beats the configured filter. To be called once, by the commands that run the farm.
///
/// # Errors
/// When the filter is none, the log was started before, or the journal cannot be reached.
pub fn start(logging: &Logging) -> Result<()> {
    let (place, filter) = match env::var(FILTER_VARIABLE) {
        Ok(filter) if !filter.is_empty() => (FILTER_VARIABLE, filter),
        _ => ("log.filter", logging.filter.clone()),
    };
    let filter = parse_log_filter(&quiet(&filter)).map_err(Error::msg).context(place)?;
    tracing_subscriber::registry()
        .with(lines(logging.format)?.with_filter(filter))
        .try_init()
        .context("starting the log")
}

/// A filter in which the crate that watches folders says only what is wrong, unless the filter names it: that a folder which
/// is gone has no watch any more is no news.
fn quiet(filter: &str) -> String {
    format!("notify=warn,{filter}")
}

/// What turns events into lines.
fn lines(format: LogFormat) -> Result<Box<dyn Layer<Registry> + Send + Sync>> {
    let text = tracing_subscriber::fmt::layer().with_writer(|| OneLine);
    Ok(match format {
        LogFormat::Auto if goes_to_journal() => {
            tracing_journald::layer().context("reaching the journal")?.with_syslog_identifier("nestd".into()).boxed()
        }
        LogFormat::Auto | LogFormat::Text => text.with_ansi(false).with_target(false).compact().boxed(),
        LogFormat::Json => text.json().flatten_event(true).boxed(),
    })
}

/// Standard error, an event a line: what an event quotes from outside (a name, a file's words) makes no line of its own and
/// moves no cursor.
struct OneLine;

impl Write for OneLine {
    /// `event` is a whole event: the subscriber writes each at once.
    fn write(&mut self, event: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(event);
        let line = text.strip_suffix('\n').unwrap_or(&text);
        io::stderr().write_all(format!("{}\n", quoted(line)).as_bytes())?;
        Ok(event.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}

/// `\u001b` is understood in JSON too, where nothing is left to escape but the newer controls.
fn quoted(line: &str) -> String {
    let escaped = |c: char| c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")).collect::<String>();
    line.chars().map(|c| if is_invisible(c) { escaped(c) } else { c.to_string() }).collect()
}

/// Whether standard error is the journal. The variable alone does not say so: it is inherited by shells and redirections.
fn goes_to_journal() -> bool {
    let Ok(output) = std::fs::metadata("/proc/self/fd/2") else { return false };
    env::var(JOURNAL_VARIABLE).is_ok_and(|stream| stream == format!("{}:{}", output.dev(), output.ino()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_is_one_line_of_what_can_be_seen() {
        assert_eq!(quoted("INFO a\n ERROR \u{1b}[2Jb\u{202e}"), r"INFO a\u000a ERROR \u001b[2Jb\u202e");
    }
}
