//! The finishing steps of parts, each with a button that says whether it is done.

use std::sync::Arc;

use access::Role;
use axum::{
    Form,
    extract::{Path, State},
};
use language::say;
use ledger::{FinishingStep, PartFinishing, PartId};
use maud::{Markup, html};
use serde::Deserialize;

use crate::{
    tables::{TimeView, fields},
    web::{
        base::error::HandlerResult,
        core::{
            command::answer_form,
            form_answer::{FormAnswer, address_here, key_field},
            request_user::{RequestUser, name_of_user},
            state::DashboardState,
        },
        forms::part_forms::require_part,
    },
};

/// What a button says of a finishing step.
#[derive(Debug, Deserialize)]
pub(crate) struct FinishForm {
    step: String,
    /// Sent if it is done.
    done: Option<String>,
    /// The page with the button.
    back: String,
}

/// The finishing steps of parts; nothing where none is wanted. `back` = the address of the page.
pub(crate) fn finishing_section(web: &DashboardState, parts: &[PartFinishing], back: &str) -> Markup {
    let view = web.time_view();
    let wanted: Vec<&PartFinishing> = parts.iter().filter(|part| !part.steps.is_empty()).collect();
    let steps = || wanted.iter().flat_map(|part| &part.steps);
    let done = steps().filter(|step| step.done_by.is_some()).count();
    html! {
        @if !wanted.is_empty() {
            h2 #finishing { (fields::FINISH.said()) }
            p { (say!("finishing-done", done = done, steps = steps().count())) }
            @for part in wanted {
                section.card aria-label=(part.name) {
                    h3 { a href=(format!("/parts/{}", part.part)) { (part.name) } }
                    @for step in &part.steps { div.buttons { (finishing_step(web, part.part, step, (back, &view))) } }
                }
            }
        }
    }
}

/// A step: whether it is done, and the button that says so.
fn finishing_step(web: &DashboardState, part: PartId, step: &FinishingStep, (back, view): (&str, &TimeView)) -> Markup {
    let done = step.done_by.as_ref().zip(step.done_at);
    let label = if done.is_some() { say!("finishing-not-yet") } else { say!("finishing-is-done") };
    html! {
        span {
            b { (step.step) } " "
            @match done {
                Some((by, at)) => (say!("finishing-by", who = name_of_user(by), when = view.near_text(at))),
                None => span.soft { (say!("finishing-open")) },
            }
        }
        @if web.offers(Role::Operate) {
            form.order method="post" action=(format!("/parts/{part}/finish")) {
                (key_field(web))
                input type="hidden" name="step" value=(step.step);
                input type="hidden" name="back" value=(back);
                @if done.is_none() { input type="hidden" name="done" value="yes"; }
                button type="submit" aria-label=(format!("{}: {label}", step.step)) { (label) }
            }
        }
    }
}

/// Records what a button says of a finishing step.
pub(crate) async fn post_finish(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    RequestUser(by): RequestUser,
    Form(form): Form<FinishForm>,
) -> HandlerResult<FormAnswer> {
    let part = require_part(&web, number).await?;
    let back = address_here(&form.back);
    match web.ledger.tell_finished(part, &form.step, form.done.is_some(), &by).await {
        Ok(_) => Ok(FormAnswer::back_to(&format!("{back}#finishing"))),
        Err(error) => answer_form(Err(error), back),
    }
}
