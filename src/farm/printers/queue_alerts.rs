//! The alerts about what lies in the queue folders of a machine and must not be printed as it is, and about what was taken
//! out of them although its copies were to be printed again.

use anyhow::Result;

use crate::{
    farm::{alerts::alert::AlertKind, core::farm::Farm},
    ledger::BuildRow,
};

/// Maximum number of files named.
const MAX_NAMED: usize = 8;

/// What a look into the queue folders of a machine found; the alert ends when nothing is wrong any more.
pub(crate) fn report_wrong_files(farm: &mut Farm, profile: &str, wrong: &[String]) {
    match wrong {
        [] => farm.alerts.clear(AlertKind::QueueAltered, profile, "queue files"),
        clauses => {
            let named = clauses.iter().take(MAX_NAMED).map(String::as_str).collect::<Vec<_>>().join("; ");
            let more = match clauses.len().saturating_sub(MAX_NAMED) {
                0 => String::new(),
                more => format!("; and {more} more"),
            };
            farm.alerts.raise(AlertKind::QueueAltered, profile, "queue files", &format!("{named}{more}"));
        }
    }
}

/// A printer took a build whose copies were to be printed again: only a person can tell what became of it.
pub(crate) async fn report_taken_first(farm: &mut Farm, build: &BuildRow, text: &str) -> Result<()> {
    let outcomes = farm.ledger.outcomes_of_build(build.id).await?.len();
    let Some(machine) = farm.machines.get_mut(&build.profile) else { return Ok(()) };
    machine.taken_first.insert(build.id, outcomes);
    farm.alerts.raise(AlertKind::TakenFirst, &build.profile, &format!("build {}", build.id), text);
    Ok(())
}

/// The alerts of [`report_taken_first`] end when somebody has told an outcome since.
pub(crate) async fn end_told_alerts(farm: &mut Farm) -> Result<()> {
    for (name, machine) in &mut farm.machines {
        for (build, outcomes) in machine.taken_first.clone() {
            if farm.ledger.outcomes_of_build(build).await?.len() > outcomes {
                machine.taken_first.remove(&build);
                farm.alerts.clear(AlertKind::TakenFirst, name, &format!("build {build}"));
            }
        }
    }
    Ok(())
}
