//! The alert about what lies in the queue folders of a machine and must not be printed as it is.

use crate::alerts::{alert::AlertKind, alert_registry::AlertRegistry};

/// Maximum number of files named.
const MAX_NAMED: usize = 8;

/// What a look into the queue folders of a machine found; the alert ends when nothing is wrong any more.
pub(crate) fn report_wrong_files(alerts: &mut AlertRegistry, machine: &str, wrong: &[String]) {
    match wrong {
        [] => alerts.clear(AlertKind::QueueAltered, machine, "queue files"),
        clauses => {
            let named = clauses.iter().take(MAX_NAMED).map(String::as_str).collect::<Vec<_>>().join("; ");
            let more = match clauses.len().saturating_sub(MAX_NAMED) {
                0 => String::new(),
                more => format!("; and {more} more"),
            };
            alerts.raise(AlertKind::QueueAltered, machine, "queue files", &format!("{named}{more}"));
        }
    }
}
