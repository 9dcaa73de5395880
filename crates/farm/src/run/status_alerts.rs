//! The alerts that follow from the ledger, so that they are known after a restart too: failed builds and prints, parts
//! and builds that wait for a yes, and parts of machines that are not configured.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;
use build_file::format_count;
use jiff::Timestamp;
use ledger::{BuildState, Ledger, MachineRow, MachineStatus, PauseCause};
use tracing::debug;

use crate::{
    alerts::{alert::AlertKind, alert_registry::AlertRegistry},
    core::{desks::Shared, machine_state::MachineStates},
    leases::own_machines,
    planning::awaits_release,
    printers::release_preview::preview_release,
};

/// Maximum number of parts or builds that an alert names.
const MAX_NAMED: usize = 3;

/// Whether the ledger cannot be reached or changed, until that is over by itself.
pub(super) fn is_cut_off(shared: &Shared<'_>) -> bool {
    AlertKind::ALL.iter().any(|&kind| kind.cuts_ledger_off() && shared.alerts.is_active(kind, "", ""))
}

/// Writes the event of each alert that was raised. One that cannot be written now is written by a later tick.
pub(super) async fn record_alerts(shared: &mut Shared<'_>) {
    if shared.lifecycle.is_halted || is_cut_off(shared) {
        return;
    }
    while let Some(alert) = shared.alerts.unrecorded().first() {
        let line = |text: &str| text.lines().collect::<Vec<_>>().join(" ");
        let detail =
            [alert.kind.headline(), alert.detail.clone(), alert.kind.remedy()].map(|text| line(&text)).join("\n");
        match shared.ledger.record_alert(&alert.machine, &alert.kind.word(), &detail).await {
            Ok(()) => shared.alerts.mark_recorded(),
            Err(failure) => return debug!("An alert could not be recorded in the ledger: {failure}."),
        }
    }
}

/// Raises the alerts that follow from the ledger: so they are known after a restart too.
pub(super) async fn update_ledger_alerts(
    shared: &mut Shared<'_>,
    machines: &MachineStates,
    rows: &[MachineStatus],
    observed: &[MachineRow],
) -> Result<()> {
    if shared.ledger.file().is_none() {
        let others = own_machines::profiles_of_others(shared.settings, observed);
        shared.lifecycle.services.adopt_machines_of_others(shared.settings, others);
    }
    let (ledger, alerts) = (shared.ledger, &mut *shared.alerts);
    let names: Vec<String> = machines.keys().cloned().collect();
    for name in &names {
        let paused = rows.iter().find(|row| row.machine == *name).and_then(|row| row.paused.as_ref());
        match paused.filter(|paused| paused.cause == PauseCause::BuildFailed) {
            Some(paused) => {
                let failed = ledger.failures_since(name, paused.paused_at).await?;
                let failed: Vec<String> = failed.iter().map(|(build, why)| format!("build {build} {why}")).collect();
                alerts.raise(AlertKind::BuildFailed, name, "", &text_of_first(&failed, MAX_NAMED));
            }
            None => alerts.clear(AlertKind::BuildFailed, name, ""),
        }
    }
    update_order_alerts(ledger, &names, alerts).await?;
    update_release_alerts(ledger, machines, alerts).await?;
    let mut gone = Vec::new();
    // Another node serves them, or this one takes them as soon as it can.
    let has_node =
        |name: &str| ledger.file().is_none() && observed.iter().any(|row| row.machine == name && !row.node.is_empty());
    let arriving: BTreeMap<String, u32> = ledger.count_arriving_lines().await?.into_iter().collect();
    let known: BTreeSet<&String> = rows.iter().map(|row| &row.machine).chain(arriving.keys()).collect();
    for name in known.into_iter().filter(|name| !machines.contains_key(*name) && !has_node(name)) {
        let row = rows.iter().find(|row| row.machine == *name);
        let parts = row.map_or(0, |row| row.waiting_parts + row.claimed_parts);
        let builds = row.map_or(0, |row| row.nesting.len());
        let lines = arriving.get(name).copied().unwrap_or(0);
        if parts > 0 || builds > 0 || lines > 0 {
            let (parts, builds) = (format_count(parts, "part", "parts"), format_count(builds, "build", "builds"));
            let ordered = match lines {
                0 => String::new(),
                lines => format!(", and {} ordered by request", format_count(lines, "line", "lines")),
            };
            alerts.raise(AlertKind::MachineGone, name, "", &format!("{parts} and {builds} in work{ordered}"));
            gone.push(name.clone());
        }
    }
    alerts.retain_machines(AlertKind::MachineGone, &gone);
    Ok(())
}

/// Raises the alerts on failed prints, on words that were dropped and on parts that wait for a yes, one of each kind for each machine.
async fn update_order_alerts(ledger: &Ledger, names: &[String], alerts: &mut AlertRegistry) -> Result<()> {
    let failed = ledger.unseen_failures().await?;
    let failed = failed.iter().map(|build| (build.machine.as_str(), format!("build {}", build.id)));
    let failed: Vec<(&str, String)> = failed.collect();
    let parts = ledger.parts_in_question().await?;
    let asked = parts.iter().map(|part| {
        (part.machine.as_str(), format!("part {} ({}): {}", part.id, part.full_name(), part.owed.question))
    });
    let asked: Vec<(&str, String)> = asked.collect();
    let dropped = ledger.dropped_words().await?;
    let dropped: Vec<(&str, String)> = dropped.iter().map(|(of, why)| (of.as_str(), why.clone())).collect();
    let kinds = [(AlertKind::PrintFailed, &failed), (AlertKind::NotTakenBack, &dropped), (AlertKind::Question, &asked)];
    for name in names {
        for (kind, all) in kinds {
            let own: Vec<String> = all.iter().filter(|(of, _)| of == name).map(|(_, text)| text.clone()).collect();
            match own.is_empty() {
                true => alerts.clear(kind, name, ""),
                false => alerts.raise(kind, name, "", &text_of_first(&own, MAX_NAMED)),
            }
        }
    }
    Ok(())
}

/// Raises an alert for each machine with proved builds that wait for a yes.
async fn update_release_alerts(ledger: &Ledger, machines: &MachineStates, alerts: &mut AlertRegistry) -> Result<()> {
    let verified = ledger.builds_in_state(BuildState::Verified).await?;
    for (name, machine) in machines {
        let mut texts = Vec::new();
        for build in verified.iter().filter(|build| build.machine == *name && awaits_release(&machine.profile, build)) {
            let preview = preview_release(ledger, &machine.profile, build, Timestamp::now()).await?;
            texts.push(format!("build {}: {}", build.id, preview.brief_text()));
        }
        match texts.is_empty() {
            true => alerts.clear(AlertKind::ReleaseDue, name, ""),
            false => alerts.raise(AlertKind::ReleaseDue, name, "", &text_of_first(&texts, MAX_NAMED)),
        }
    }
    Ok(())
}

/// The first texts, and how many more there are.
fn text_of_first(texts: &[String], most: usize) -> String {
    let more = texts.len().saturating_sub(most);
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    texts[..texts.len().min(most)].join("; ") + &more
}
