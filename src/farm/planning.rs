//! Plans the builds to come of a machine, and tells which due dates are at risk. Reading (`plan_reading`), planning (`build_plan`, a pure
//! function) and what people see of it (`machine_plan`) are apart. Nothing here changes anything.

mod build_plan;
mod date_outlook;
mod machine_plan;
mod packing_experience;
mod plan_facts;
mod plan_reading;
#[cfg(test)]
mod plan_tests;

use anyhow::Result;
use jiff::Timestamp;

pub use date_outlook::RiskCause;
pub use machine_plan::{DateRisk, MachinePlan, PlanStage, PlannedBuild, PlannedPart};

use crate::{ledger::Ledger, settings::MachineProfile};

/// The plan of a machine: its builds under way and to come, if nothing more arrives.
///
/// # Errors
/// The ledger cannot be read.
pub async fn plan_machine(ledger: &Ledger, profile: &MachineProfile, now: Timestamp) -> Result<MachinePlan> {
    Ok(machine_plan::make_plan(profile, &plan_reading::read_plan(ledger, profile, now).await?, now))
}
