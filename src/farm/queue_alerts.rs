//! Alerts about what lies in queue folders and must not be printed as it is.

use super::{alert::AlertKind, farm::Farm};
use crate::ledger::BuildRow;

/// What lies in the queue under the name of a build is not the file that was proved: nobody can say what was printed.
pub(super) fn report_altered(farm: &mut Farm, build: &BuildRow) {
    let id = build.id;
    let text = format!(
        "what lies in the queue as build {id} ({}) is not the file that was proved, so it was not taken back: take it out of the \
         folder, look whether it was printed, and tell the outcome of build {id}",
        build.staged.file_name.as_deref().unwrap_or_default()
    );
    farm.alerts.raise(AlertKind::QueueAltered, &build.profile, &format!("build {id}"), &text);
}

/// What a look into the queue folders of a machine found altered; the alert ends when nothing is.
pub(super) fn report_altered_files(farm: &mut Farm, profile: &str, altered: &[String]) {
    match altered {
        [] => farm.alerts.clear(AlertKind::QueueAltered, profile, "queue files"),
        clauses => farm.alerts.raise(AlertKind::QueueAltered, profile, "queue files", &clauses.join("; ")),
    }
}
