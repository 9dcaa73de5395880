//! Reads from the ledger what the facts are made from. Nothing is changed.

use anyhow::Result;
use jiff::Timestamp;
use ledger::{Ledger, MachineStatus};
use settings::MachineProfile;

use super::{
    machine_fact::{MachineFact, machine_fact},
    printer_fact::printer_fact,
};
use crate::{
    decisions::printer_choice::build_spans,
    planning::{DateRisk, FarmRows, MachinePlan, Occupation, plan_machine, read_occupation, risks_of_machine},
};

/// What is known of machines at a time, read once: whoever looks at facts and plans of them sees the same.
#[derive(Debug)]
pub struct FarmReading<'p> {
    /// What the ledger says of all machines.
    pub rows: FarmRows,
    /// The machines that are looked at, with what their printers have to do.
    machines: Vec<(&'p MachineProfile, Occupation)>,
    now: Timestamp,
}

impl<'p> FarmReading<'p> {
    /// Reads what is known of these machines now.
    ///
    /// # Errors
    /// The ledger cannot be read.
    pub async fn read(
        ledger: &Ledger,
        profiles: impl IntoIterator<Item = &'p MachineProfile>,
        now: Timestamp,
    ) -> Result<Self> {
        let rows = FarmRows::read(ledger).await?;
        let mut machines = Vec::new();
        for profile in profiles {
            machines.push((profile, read_occupation(ledger, profile, now).await?));
        }
        Ok(Self { rows, machines, now })
    }

    /// What is so of the machines, in their order.
    pub fn facts(&self) -> Vec<MachineFact> {
        self.machines.iter().map(|(profile, occupation)| self.fact_of(profile, occupation)).collect()
    }

    fn fact_of(&self, profile: &MachineProfile, Occupation { builds, times, .. }: &Occupation) -> MachineFact {
        let is_down = |printer: &str| self.rows.down(&profile.name, printer).is_some();
        let spans = build_spans(profile, builds, times, is_down, self.now);
        let printers = profile.printers.iter().map(|rules| {
            let down = self.rows.down(&profile.name, &rules.name);
            let spans = spans.get(&rules.name).map_or(&[][..], Vec::as_slice);
            printer_fact(profile, rules, spans, down.cloned(), times, self.now)
        });
        let status = MachineStatus::of_machine(&self.rows.statuses, &profile.name);
        machine_fact(
            &status,
            self.rows.observed(&profile.name),
            printers.collect(),
            &self.rows.awaiting_release(profile),
        )
    }

    /// The plans of the machines, in their order.
    ///
    /// # Errors
    /// The ledger cannot be read.
    pub async fn plans(&self, ledger: &Ledger) -> Result<Vec<MachinePlan>> {
        let mut plans = Vec::with_capacity(self.machines.len());
        for (profile, occupation) in &self.machines {
            plans.push(plan_machine(ledger, profile, (&self.rows, occupation), self.now).await?);
        }
        Ok(plans)
    }

    /// What is late in the farm, or at risk to be, by due date.
    ///
    /// # Errors
    /// The ledger cannot be read.
    pub async fn dates_at_risk(&self, ledger: &Ledger) -> Result<Vec<DateRisk>> {
        let mut risks = Vec::new();
        for (profile, occupation) in &self.machines {
            risks.extend(risks_of_machine(ledger, profile, (&self.rows, occupation), self.now).await?);
        }
        Ok(sorted_by_date(risks))
    }
}

/// The plans of these machines, in their order, where nothing else is asked.
///
/// # Errors
/// The ledger cannot be read.
pub async fn read_plans<'p>(
    ledger: &Ledger,
    profiles: impl IntoIterator<Item = &'p MachineProfile>,
    now: Timestamp,
) -> Result<Vec<MachinePlan>> {
    FarmReading::read(ledger, profiles, now).await?.plans(ledger).await
}

/// What is late in the farm, or at risk to be, by due date.
pub fn dates_at_risk(plans: Vec<MachinePlan>) -> Vec<DateRisk> {
    sorted_by_date(plans.into_iter().flat_map(|plan| plan.risks).collect())
}

fn sorted_by_date(mut risks: Vec<DateRisk>) -> Vec<DateRisk> {
    risks.sort_by(|one, other| (one.due_at, &one.order).cmp(&(other.due_at, &other.order)));
    risks
}
