//! `nestd plan`: the builds to come of the machines, and which due dates are at risk.

use anyhow::Result;
use farm::{MachinePlan, read_plans};
use jiff::Timestamp;

use crate::{
    cli::{
        CommandExit, CommonArgs,
        terminal::{
            candidates,
            farm_context::{require_machine, with_ledger_to_read},
            table::{TextTable, print_fitted, print_json},
            terminal::output_columns,
        },
    },
    tables::{PLAN_COLUMNS, RISK_COLUMNS, TimeView, plan_notes},
};

/// Columns of builds that are left out on a narrow terminal, the first of them first.
const LEAST_COLUMNS: &[&str] = &["fires_by", "due", "begins_at", "printer"];

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct PlanArgs {
    /// Machine; without it, all machines
    #[arg(value_name = "MACHINE", add = candidates::of_machines())]
    machine: Option<String>,
    /// Print all columns, however wide the terminal is
    #[arg(long)]
    wide: bool,
    /// Print JSON, with what is in each build
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &PlanArgs) -> Result<CommandExit> {
    let (plans, view) = with_ledger_to_read(common, async |settings, ledger| {
        if let Some(name) = &args.machine {
            require_machine(settings, name)?;
        }
        let asked =
            settings.profiles.values().filter(|profile| args.machine.as_ref().is_none_or(|name| *name == profile.name));
        let plans = read_plans(ledger, asked, Timestamp::now()).await?;
        Ok((plans, TimeView::current(&settings.time_zone)))
    })?;
    match args.json {
        true => print_json(&plans)?,
        false => print_fitted(
            plans.iter().map(|plan| plan_text(plan, &view, args.wide)).collect::<Vec<_>>().join("\n").trim_end(),
            args.wide,
        )?,
    }
    Ok(CommandExit::Success)
}

/// The plan of a machine as text.
fn plan_text(plan: &MachinePlan, view: &TimeView, is_wide: bool) -> String {
    let columns = output_columns(is_wide);
    let mut text = format!("{}\n", plan.machine);
    let builds = TextTable::of(PLAN_COLUMNS, &plan.builds, view);
    if !builds.is_empty() {
        text += &builds.fit_essentials(columns, LEAST_COLUMNS);
    }
    for note in plan_notes(plan, view) {
        text += &format!("{note}\n");
    }
    if !plan.risks.is_empty() {
        text += "Due dates at risk:\n";
        text += &TextTable::of(RISK_COLUMNS, &plan.risks, view).fit_columns(columns);
    }
    text
}
