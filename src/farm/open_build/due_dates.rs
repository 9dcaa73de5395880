//! Due dates at risk: warns that a part will not be printed in time while somebody can still act.

use std::collections::BTreeMap;

use anyhow::Result;
use jiff::{SignedDuration, Timestamp};
use ledger::{DuePartRow, PartId, UtcTimestamp};
use tracing::warn;

use crate::farm::{
    core::{
        desks::Shared,
        machine_state::{MachineState, MachineStates},
    },
    decisions::trigger::secs_between,
    nodes::machine_availability,
};

/// Maximum number of part names in a warning.
const MAX_NAMES: usize = 3;

/// What decides whether a due date is at risk.
#[derive(Debug, Clone, Copy, PartialEq)]
struct DueDateOutlook {
    /// Printing time, seconds; 0 = not known.
    print_secs: f64,
    /// How long before the start of printing a batch fires for a due date, seconds.
    margin_secs: f64,
    /// Why nothing is fired or published now; `None` = nothing prevents it.
    hindered: Option<&'static str>,
}

impl DueDateOutlook {
    /// Why a due date is at risk, if it is.
    fn risk_reason(&self, due: Timestamp, now: Timestamp) -> Option<String> {
        let left_secs = secs_between(now, due);
        let hours = self.print_secs / 3600.0;
        match self.hindered {
            _ if left_secs <= 0.0 => Some("that date has passed".to_owned()),
            _ if left_secs < self.print_secs => Some(format!("printing takes {hours:.1} h and has not begun")),
            Some(why) if left_secs <= self.print_secs + self.margin_secs => Some(format!("{why}, and it is near")),
            _ => None,
        }
    }
}

/// Warns of due dates that are at risk, each once.
pub(crate) async fn check_due_dates(shared: &Shared<'_>, machines: &MachineStates) -> Result<()> {
    if !shared.schedule.clock.is_date_trusted() {
        return Ok(());
    }
    let now = shared.date();
    let longest = machines.values().map(|machine| {
        let profile = &machine.profile;
        profile.space.volume_mm.z * profile.space.print_hours_per_mm * 3600.0
            + profile.trigger.due_margin_secs.unwrap_or(0.0)
    });
    let ahead = SignedDuration::try_from_secs_f64(longest.fold(0.0, f64::max)).unwrap_or_default();
    let parts = shared.ledger.due_parts(now.checked_add(ahead).unwrap_or(now)).await?;
    let mut orders: BTreeMap<(String, String, UtcTimestamp), Vec<DuePartRow>> = BTreeMap::new();
    // Another node looks after the dates of its machines.
    for part in parts.into_iter().filter(|part| shared.looks_after(machines, &part.machine)) {
        orders.entry((part.machine.clone(), part.order_name.clone(), part.due_at)).or_default().push(part);
    }
    for ((machine, order, due), parts) in orders {
        let height_mm = parts.iter().filter_map(|part| part.height_mm).fold(0.0, f64::max);
        let Some(why) = due_date_outlook(shared, machines.get(&machine), &machine, height_mm).risk_reason(due.0, now)
        else {
            continue;
        };
        let text = parts.first().map_or("", |part| part.due_text.as_str());
        let date = shared.settings.time_zone.format_due(due.0, text);
        let detail = format!("{} due {date}: {why}.", describe_parts(&order, &parts));
        warn!(machine, "A due date is at risk: {detail}");
        let ids: Vec<PartId> = parts.iter().map(|part| part.id).collect();
        shared.ledger.record_at_risk(&machine, &ids, &detail).await?;
    }
    Ok(())
}

/// The outlook for the next build of a machine, or for a build of this height that has started.
fn due_date_outlook(shared: &Shared<'_>, machine: Option<&MachineState>, name: &str, height_mm: f64) -> DueDateOutlook {
    let Some(machine) = machine else {
        let hindered = Some("its machine is not configured");
        return DueDateOutlook { print_secs: 0.0, margin_secs: f64::INFINITY, hindered };
    };
    let height_mm = if height_mm > 0.0 { height_mm } else { machine.open.layout.height_mm };
    let is_away = machine_availability::is_unavailable(shared.alerts, name, machine);
    DueDateOutlook {
        print_secs: height_mm * machine.profile.space.print_hours_per_mm * 3600.0,
        margin_secs: machine.profile.trigger.due_margin_secs.unwrap_or(0.0),
        hindered: match (machine.paused, is_away) {
            (true, _) => Some("its machine is paused"),
            (false, true) => Some("its machine is unavailable"),
            (false, false) if machine.printers.are_all_down() => Some("no printer of its machine is in use"),
            (false, false) if machine.pacing.is_held => Some("the queues of its printers are full"),
            (false, false) => None,
        },
    }
}

/// Describes due parts with some of their names.
fn describe_parts(order: &str, parts: &[DuePartRow]) -> String {
    let names: Vec<&str> = parts.iter().take(MAX_NAMES).map(|part| part.name.as_str()).collect();
    let more = if parts.len() > MAX_NAMES { format!(" and {} more", parts.len() - MAX_NAMES) } else { String::new() };
    let of = if order.is_empty() { String::new() } else { format!(" of {order}") };
    let verb = if parts.len() == 1 { "is" } else { "are" };
    format!("{}{more}{of} {verb}", names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_due_date_is_at_risk_when_printing_would_end_after_it_or_when_it_is_near_and_nothing_fires() {
        let (now, hour) = (Timestamp::UNIX_EPOCH, 3600.0);
        let due = |hours: i64| now.checked_add(SignedDuration::from_hours(hours)).unwrap();
        let free = DueDateOutlook { print_secs: 5.0 * hour, margin_secs: 2.0 * hour, hindered: None };
        assert_eq!(free.risk_reason(due(8), now), None);
        assert_eq!(free.risk_reason(due(6), now), None, "it fires by itself");
        assert!(free.risk_reason(due(4), now).unwrap().contains("takes 5.0 h"));
        assert!(free.risk_reason(due(-1), now).unwrap().contains("has passed"));
        let paused = DueDateOutlook { hindered: Some("its machine is paused"), ..free };
        assert_eq!(paused.risk_reason(due(8), now), None);
        assert!(paused.risk_reason(due(6), now).unwrap().contains("paused"));
    }
}
