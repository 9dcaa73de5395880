//! Due dates at risk: warns of what the plan says will not be printed in time, while somebody can still act.

use anyhow::Result;
use ledger::{DuePartRow, PartId};
use tracing::warn;

use crate::{
    core::{desks::Shared, machine_state::MachineStates},
    planning::DateRisk,
};

/// Maximum number of part names in a warning.
const MAX_NAMES: usize = 3;

/// Warns of due dates that are at risk, each once.
pub(crate) async fn check_due_dates(shared: &Shared<'_>, machines: &MachineStates, risks: &[DateRisk]) -> Result<()> {
    if !shared.schedule.clock.is_date_trusted() {
        return Ok(());
    }
    let mut parts = shared.ledger.unwarned_due_parts().await?;
    // Another node looks after the dates of its machines.
    parts.retain(|part| shared.looks_after(machines, &part.machine));
    for risk in risks {
        let (of_risk, others) = parts.into_iter().partition(|part| risk.numbers.contains(&part.id));
        parts = others;
        warn_of(shared, of_risk, &risk.reason).await?;
    }
    while let Some(first) = parts.iter().find(|part| !machines.contains_key(&part.machine)) {
        let key = (first.machine.clone(), first.order_name.clone(), first.due_at);
        let is_of = |part: &DuePartRow| (part.machine.clone(), part.order_name.clone(), part.due_at) == key;
        let (gone, others) = parts.into_iter().partition(is_of);
        parts = others;
        warn_of(shared, gone, "its machine is not configured").await?;
    }
    Ok(())
}

/// Warns that parts of one machine and one order, which are due at the same time, may be late.
async fn warn_of(shared: &Shared<'_>, parts: Vec<DuePartRow>, why: &str) -> Result<()> {
    let Some(first) = parts.first() else { return Ok(()) };
    let date = shared.settings.time_zone.format_due(first.due_at.0, &first.due_text);
    let subject = describe_parts(&first.order_name, &parts);
    let detail = match parts.len() {
        1 => format!("{subject} is due {date}: {why}."),
        _ => format!("{subject} are due {date}: {why}."),
    };
    warn!(machine = first.machine, "A due date is at risk: {detail}");
    let ids: Vec<PartId> = parts.iter().map(|part| part.id).collect();
    Ok(shared.ledger.record_at_risk(&first.machine, &ids, &detail).await?)
}

/// Describes due parts with some of their names.
fn describe_parts(order: &str, parts: &[DuePartRow]) -> String {
    let names: Vec<&str> = parts.iter().take(MAX_NAMES).map(|part| part.name.as_str()).collect();
    let more = if parts.len() > MAX_NAMES { format!(" and {} more", parts.len() - MAX_NAMES) } else { String::new() };
    let of = if order.is_empty() { String::new() } else { format!(" of {order}") };
    format!("{}{more}{of}", names.join(", "))
}
