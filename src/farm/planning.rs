//! Plans the builds to come of a machine, tells which due dates are at risk, and quotes dates for parts that nobody has ordered yet.
//! Reading (`plan_reading`), planning (`build_plan`, `date_outlook`, `earliest_date`: pure functions) and what people see of it
//! (`machine_plan`, `order_quote`) are apart. Nothing here changes anything.

mod build_plan;
mod date_outlook;
mod earliest_date;
mod machine_plan;
mod occupation;
mod order_quote;
mod packing_experience;
mod plan_facts;
mod plan_reading;
#[cfg(test)]
mod plan_tests;
mod quote_insertion;
mod quoted_part;
mod reprint_odds;
#[cfg(test)]
mod simulated_months;

use anyhow::Result;
use jiff::Timestamp;

pub use date_outlook::RiskCause;
use ledger::Ledger;
pub use machine_plan::{DateRisk, MachinePlan, PlanStage, PlannedBuild, PlannedPart};
pub use occupation::{awaits_release, read_occupation};
pub use order_quote::{DueAnswer, OrderQuote, QUOTE_SEARCH_TIME, QuoteQuestion, quote_order};
pub use plan_reading::read_plan;
pub use quote_insertion::QuoteMeshes;
pub use quoted_part::{QuoteError, QuotedFile, read_quoted_files};

use crate::settings::MachineProfile;

/// The plan of a machine: its builds under way and to come, if nothing more arrives.
///
/// # Errors
/// The ledger cannot be read.
pub async fn plan_machine(ledger: &Ledger, profile: &MachineProfile, now: Timestamp) -> Result<MachinePlan> {
    Ok(machine_plan::make_plan(profile, &plan_reading::read_plan(ledger, profile, now).await?, now))
}
