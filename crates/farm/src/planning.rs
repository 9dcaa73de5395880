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

pub use date_outlook::{DatesKept, RiskCause};
use ledger::{Ledger, MachineStatus};
pub use machine_plan::{DateRisk, MachinePlan, PlanStage, PlannedBuild, PlannedPart};
pub use occupation::{FarmRows, Occupation, awaits_release, read_occupation};
pub use order_quote::{DueAnswer, OrderQuote, QUOTE_SEARCH_TIME, QuoteQuestion, quote_order};
pub use quote_insertion::QuoteMeshes;
pub use quoted_part::{QuoteError, QuotedFile, QuotedPart, read_quoted_files};

use settings::MachineProfile;

/// What is known of a machine whose printers have this to do: the ground of its plan, and of a quote.
///
/// # Errors
/// The ledger cannot be read.
pub async fn read_plan(ledger: &Ledger, profile: &MachineProfile, now: Timestamp) -> Result<plan_reading::PlanReading> {
    let (rows, occupation) = (FarmRows::read(ledger).await?, read_occupation(ledger, profile, now).await?);
    let waiting = ledger.waiting_copies(&profile.name).await?;
    plan_reading::read_plan(ledger, profile, (&rows, &occupation), waiting, now).await
}

/// The plan of a machine: its builds under way and to come, if nothing more arrives. `rows` and `occupation` were read just now.
///
/// # Errors
/// The ledger cannot be read.
pub async fn plan_machine(
    ledger: &Ledger,
    profile: &MachineProfile,
    (rows, occupation): (&FarmRows, &Occupation),
    now: Timestamp,
) -> Result<MachinePlan> {
    let waiting = ledger.waiting_copies(&profile.name).await?;
    let reading = plan_reading::read_plan(ledger, profile, (rows, occupation), waiting, now).await?;
    Ok(machine_plan::make_plan(profile, &reading, now))
}

/// The due dates of a machine that are at risk, as its plan has them, the earliest first. Where nothing that waits has a date, it is not
/// read: what waits follows what has fired, and moves no date of that.
///
/// # Errors
/// The ledger cannot be read.
pub async fn risks_of_machine(
    ledger: &Ledger,
    profile: &MachineProfile,
    (rows, occupation): (&FarmRows, &Occupation),
    now: Timestamp,
) -> Result<Vec<DateRisk>> {
    let waiting = match MachineStatus::of_machine(&rows.statuses, &profile.name).due_at {
        Some(_) => ledger.waiting_copies(&profile.name).await?,
        None => Vec::new(),
    };
    let reading = plan_reading::read_plan(ledger, profile, (rows, occupation), waiting, now).await?;
    let coming = build_plan::plan_builds(profile, &reading.facts, now);
    Ok(machine_plan::find_risks(profile, &reading, &coming, now))
}
