//! Reads from the ledger what the facts are made from. Nothing is changed.

use anyhow::Result;
use jiff::Timestamp;
use ledger::{Ledger, MachineStatus};

use super::{
    machine_fact::{MachineFact, machine_fact},
    printer_fact::printer_fact,
};
use crate::{
    farm::{
        decisions::printer_choice::build_spans,
        planning::{DateRisk, MachinePlan, plan_machine, read_occupation},
    },
    settings::MachineProfile,
};

/// What is so of these machines now, in their order. `statuses` are those of the ledger.
///
/// # Errors
/// The ledger cannot be read.
pub async fn read_machine_facts<'p>(
    ledger: &Ledger,
    profiles: impl IntoIterator<Item = &'p MachineProfile>,
    statuses: &[MachineStatus],
    now: Timestamp,
) -> Result<Vec<MachineFact>> {
    let (observed, down) = (ledger.list_machines().await?, ledger.down_printers().await?);
    let mut facts = Vec::new();
    for profile in profiles {
        let (builds, times) = read_occupation(ledger, profile, now).await?;
        let spans = build_spans(profile, &builds, &times, now);
        let printers = profile.printers.iter().map(|rules| {
            let down = down.iter().find(|down| down.machine == profile.name && down.printer == rules.name);
            let spans = spans.get(&rules.name).map_or(&[][..], Vec::as_slice);
            printer_fact(profile, rules, spans, down.cloned(), &times, now)
        });
        let printers = printers.collect();
        let status = MachineStatus::of_machine(statuses, &profile.name);
        let observed = observed.iter().find(|observed| observed.machine == profile.name);
        facts.push(machine_fact(&status, observed, printers, now));
    }
    Ok(facts)
}

/// The plans of these machines, in their order.
///
/// # Errors
/// The ledger cannot be read.
pub async fn read_plans<'p>(
    ledger: &Ledger,
    profiles: impl IntoIterator<Item = &'p MachineProfile>,
    now: Timestamp,
) -> Result<Vec<MachinePlan>> {
    let mut plans = Vec::new();
    for profile in profiles {
        plans.push(plan_machine(ledger, profile, now).await?);
    }
    Ok(plans)
}

/// What is late in the farm, or at risk to be, by due date.
pub fn dates_at_risk(plans: Vec<MachinePlan>) -> Vec<DateRisk> {
    let mut risks: Vec<DateRisk> = plans.into_iter().flat_map(|plan| plan.risks).collect();
    risks.sort_by(|one, other| (one.due_at, &one.order).cmp(&(other.due_at, &other.order)));
    risks
}
