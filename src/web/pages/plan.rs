//! The plan: the builds to come of each machine, and the due dates at risk. It is made anew at each look.

use std::sync::Arc;

use axum::{
    Json,
    extract::{Query, State},
};
use jiff::Timestamp;
use maud::{Markup, html};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    farm::{MachinePlan, read_plans},
    settings::MachineProfile,
    tables::{PLAN_COLUMNS, RISK_COLUMNS, TimeView, plan_notes},
    web::{
        base::{
            error::{HandlerError, HandlerResult},
            listing::table_of,
            page::html_page,
        },
        core::state::DashboardState,
    },
};

/// Whose plan is asked for.
#[derive(Debug, Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(default)]
#[schemars(inline)]
pub(crate) struct PlanQuestion {
    /// Only this machine; all if empty.
    machine: String,
}

/// The plans as JSON.
pub(crate) async fn get_plans(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<PlanQuestion>,
) -> HandlerResult<Json<Vec<MachinePlan>>> {
    Ok(Json(make_plans(&web, &asked).await?))
}

/// The page of the plans.
pub(crate) async fn show_plans(
    State(web): State<Arc<DashboardState>>,
    Query(asked): Query<PlanQuestion>,
) -> HandlerResult<Markup> {
    let (plans, view) = (make_plans(&web, &asked).await?, web.time_view());
    let content = html! {
        h1 { "Plan" }
        p { "The builds to come, if nothing more arrives." }
        @for plan in &plans { (plan_section(plan, &view)) }
    };
    Ok(html_page("Plan", "/plan", None, &content))
}

async fn make_plans(web: &DashboardState, asked: &PlanQuestion) -> HandlerResult<Vec<MachinePlan>> {
    let (settings, now) = (web.current_settings(), Timestamp::now());
    if !asked.machine.is_empty() && !settings.profiles.contains_key(&asked.machine) {
        return Err(HandlerError::NotFound(format!("machine {}", asked.machine)));
    }
    let is_asked = |profile: &&MachineProfile| asked.machine.is_empty() || asked.machine == profile.name;
    Ok(read_plans(&web.ledger, settings.profiles.values().filter(is_asked), now).await?)
}

fn plan_section(plan: &MachinePlan, view: &TimeView) -> Markup {
    html! {
        h2 { (plan.machine) }
        @if !plan.risks.is_empty() {
            (table_of(&format!("Due dates at risk on {}", plan.machine), Some("Due dates at risk".to_owned()), RISK_COLUMNS, &plan.risks, view))
        }
        @if !plan.builds.is_empty() {
            (table_of(&format!("Builds of {}", plan.machine), None, PLAN_COLUMNS, &plan.builds, view))
        }
        @for note in plan_notes(plan, view) { p { (note) } }
    }
}
