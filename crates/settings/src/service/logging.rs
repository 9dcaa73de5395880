//! Settings for the content and format of the log.

use serde::{Deserialize, Serialize};
use tracing_subscriber::filter::Targets;

/// Format of a log line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LogFormat {
    /// The systemd journal if systemd started the daemon, otherwise text.
    #[default]
    Auto,
    /// One line of text per event, on standard error.
    Text,
    /// One JSON object per line, on standard error.
    Json,
}

/// Settings of the log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LogSettings {
    /// Levels by module, in the syntax of `tracing`: "info", "info,intake=debug".
    pub filter: String,
    /// Format of a line.
    pub format: LogFormat,
}

/// Levels that hold unless the text says others. A folder that goes away while it is watched is no trouble: the scan sees it.
const UNASKED: &str = "notify=error";

/// Parses levels by module, such as "info,intake=debug". A module without a level is logged at all levels.
///
/// # Errors
/// A sentence for people, if the text is not a valid filter.
pub fn parse_log_filter(text: &str) -> Result<Targets, String> {
    let is_of_name = |c: char| c.is_alphanumeric() || "_-:=".contains(c);
    let levels: Vec<&str> = text.split(',').map(str::trim).filter(|level| !level.is_empty()).collect();
    match levels.iter().find(|level| !level.chars().all(is_of_name)) {
        Some(level) => Err(format!("\"{}\" is neither a level nor MODULE=LEVEL", level.escape_debug())),
        None if levels.is_empty() => Ok(Targets::new()),
        None if levels == ["off"] => Ok(Targets::new()),
        None => format!("{UNASKED},{}", levels.join(",")).parse::<Targets>().map_err(|error| error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use tracing::Level;

    use super::*;

    #[test]
    fn a_filter_is_levels_by_module() {
        let filter = parse_log_filter("info, intake=DEBUG,notify=error,").unwrap();
        let holds = |module, level: Level| filter.would_enable(module, &level);
        assert!(holds("nestd::farm", Level::INFO) && !holds("nestd::farm", Level::DEBUG));
        assert!(holds("intake::scan", Level::DEBUG) && !holds("intake::scan", Level::TRACE));
        assert!(holds("notify", Level::ERROR) && !holds("notify", Level::WARN));
        let usual = parse_log_filter("info").unwrap();
        assert!(usual.would_enable("nestd::web", &Level::INFO) && !usual.would_enable("notify::inotify", &Level::WARN));
        assert!(parse_log_filter("notify=warn").unwrap().would_enable("notify::inotify", &Level::WARN));
        assert!(parse_log_filter("nestd").unwrap().would_enable("nestd::web", &Level::TRACE));
        assert!(!parse_log_filter("off").unwrap().would_enable("nestd::web", &Level::ERROR));
        assert!(!parse_log_filter("").unwrap().would_enable("nestd::web", &Level::ERROR));
        assert!(
            parse_log_filter("notify=warn,info,notify=error").unwrap()
                == parse_log_filter("info,notify=error").unwrap()
        );
    }

    #[test]
    fn what_is_no_filter_is_refused() {
        for wrong in ["nestd=loud", "nestd=info=debug", "[span]=info", "nestd[{part=7}]=debug", "info;debug", "=="] {
            assert!(parse_log_filter(wrong).is_err(), "{wrong}");
        }
    }
}
