//! The plan of a machine: its builds under way and to come, and the due dates at risk.

use farm::{DateRisk, MachinePlan, PlanStage, PlannedBuild};
use language::say;

use crate::tables::{
    columns::{
        cell_value::CellValue,
        table_column::TableColumn,
        time_view::{GivenDate, TimeView},
    },
    fields,
};

/// The builds of a plan.
pub const PLAN_COLUMNS: &[TableColumn<PlannedBuild>] = &[
    TableColumn::new("build", fields::BUILD, |row| row.build.into()),
    TableColumn::for_people("stage", fields::STATE, |row| {
        CellValue::State(row.stage.word(row.awaits_release).to_owned())
    }),
    TableColumn::new("copies", fields::COPIES, |row| row.copies.into()),
    TableColumn::for_people("height", fields::ABOUT_HEIGHT, |row| height_text(row).into()),
    TableColumn::new("fires_at", fields::FIRES_AT, |row| row.fires_at.into()),
    TableColumn::for_people("fires_by", fields::FIRED_BY, |row| row.fires_by.map(|by| by.to_string()).into()),
    TableColumn::new("printer", fields::PRINTER, |row| row.printer.as_ref().into()),
    TableColumn::new("begins_at", fields::BEGINS, |row| match row.stage.has_begun() {
        true => row.begins_at.into(),
        false => CellValue::estimate(row.begins_at),
    }),
    TableColumn::new("ends_at", fields::UNPACKED, |row| CellValue::estimate(row.ends_at)),
    TableColumn::for_people("due", fields::DUE, |row| {
        GivenDate::new(row.parts.iter().filter_map(|part| part.due_at).min(), "").into()
    }),
];

/// The due dates at risk of a plan.
pub const RISK_COLUMNS: &[TableColumn<DateRisk>] = &[
    TableColumn::for_people("of", fields::ORDER_OR_PART, |row| row.subject_text().into()),
    TableColumn::for_people("due", fields::DUE, |row| GivenDate::new(Some(row.due_at), &row.due_text).into()),
    TableColumn::new("done_at", fields::UNPACKED, |row| CellValue::estimate(row.done_at)),
    TableColumn::for_people("risk", fields::RISK, |row| CellValue::State(row.word().to_owned())),
    TableColumn::new("reason", fields::REASON, |row| (&row.reason).into()),
];

/// The height of a layout, or `about` an estimate.
fn height_text(build: &PlannedBuild) -> String {
    match build.is_nested {
        true => language::decimal(format!("{:.1}", build.height_mm)),
        false => say!("about-height", height = format!("{:.0}", build.height_mm)),
    }
}

/// What is to be said of a plan beside its tables, in sentences.
pub fn plan_notes(plan: &MachinePlan, view: &TimeView) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some(hindered) = plan.hindered {
        let machine = &plan.machine;
        notes.push(match hindered {
            farm::RiskCause::Paused => say!("plan-paused", machine = machine),
            farm::RiskCause::Unavailable => say!("plan-unavailable", machine = machine),
            _ => say!("plan-no-printer", machine = machine),
        });
    }
    // Where the end of one is not known, that of all is not.
    let to_come = plan.builds.iter().filter(|build| build.stage != PlanStage::Ended);
    let ends: Option<Vec<_>> = to_come.map(|build| build.ends_at).collect();
    notes.push(match (plan.builds.len(), ends.and_then(|ends| ends.into_iter().max())) {
        (0, _) => say!("plan-nothing", machine = &plan.machine),
        (_, Some(last)) => {
            say!("plan-done", machine = &plan.machine, time = view.estimate_text(last))
        }
        (_, None) => say!("plan-unknown", machine = &plan.machine),
    });
    if plan.unplanned_parts > 0 {
        notes.push(say!("plan-unplanned", parts = plan.unplanned_parts));
    }
    if plan.builds.iter().any(|build| !build.is_nested) {
        notes.push(match plan.heights_learned_from {
            0 => say!("plan-heights-usual"),
            builds => say!("plan-heights-learned", builds = builds),
        });
    }
    notes
}
