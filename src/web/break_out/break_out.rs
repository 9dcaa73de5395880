//! Breaking a build out step by step, on a tablet beside the cake: a card for each copy, in the order of the pick map, with large
//! buttons. What is said of a copy is in the ledger, so that several people work on one build and see what the others did.

use std::sync::Arc;

use axum::{
    Form,
    extract::{Path, State},
};
use ledger::{BuildId, OperatorWord, PartId, PickMark};
use maud::{Markup, html};
use serde::Deserialize;

use super::{
    break_out_card::{bins_table, current_card, mark_form, open_list, progress_line, summary_section},
    break_out_state::{BreakOutState, CopyState, mark_word},
};
use crate::{
    tables::TimeView,
    web::{
        base::{error::HandlerResult, page::html_page, query::Query},
        core::{
            command::answer_form,
            device_name::device_user,
            form_answer::FormAnswer,
            request_user::{RequestUser, name_of_user},
            state::DashboardState,
        },
        forms::operate_form::say_word,
    },
};

/// Which copy is shown: its number in the list; the first that is in the cake unless given.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct StepQuery {
    at: Option<usize>,
}

/// The page.
pub(crate) async fn show_step(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    Query(query): Query<StepQuery>,
    RequestUser(user): RequestUser,
) -> HandlerResult<Markup> {
    let state = BreakOutState::read(&web, number).await?;
    let asked = query.at.and_then(|at| at.checked_sub(1)).filter(|&at| at < state.states.len());
    let shown = asked.or_else(|| state.first_open());
    let (counts, view) = (state.counts(), web.time_view());
    let title = format!("Break out build {}", state.build.id);
    let content = html! {
        h1 { (title) }
        (progress_line(&counts))
        (device_user(&web, &user, &state.address()))
        @if let Some(at) = shown { (current_card(&web, &state, at, &view)) }
        @if state.first_open().is_none() { (summary_section(&web, &state, &counts)) }
        (last_line(&web, &state, &user, &view))
        (bins_table(&counts))
        (open_list(&web, &state))
        p.links { a href=(format!("/builds/{}/pick", state.build.id)) { "The whole pick map, to print" }
            a href=(format!("/builds/{}", state.build.id)) { "Build " (state.build.id) } }
    };
    Ok(html_page(&title, "", None, &content))
}

/// What was said last, with the button that takes it back.
fn last_line(web: &DashboardState, state: &BreakOutState, user: &str, view: &TimeView) -> Markup {
    let Some((copy, row)) = state.last_mark(user) else { return html! {} };
    html! {
        div.undo {
            p { "Last: " (copy.number) " " (copy.name) ", copy " (copy.copy) ", " (mark_word(row.mark)) ", by "
                (name_of_user(&row.told_by)) ", " (view.time_text(row.told_at)) "." }
            @if web.orders { (mark_form(web, state, (copy, Some(row)), PickMark::Open, "Undo", "undo")) }
        }
    }
}

/// What a button says of a copy.
#[derive(Debug, Deserialize)]
pub(crate) struct MarkForm {
    part: i64,
    /// From 1.
    copy: u32,
    /// Number of the copy that was shown.
    at: usize,
    /// Number of the mark of it that was shown; 0 = none.
    #[serde(default)]
    seen: i64,
    mark: PickMark,
}

/// Records what a button says, then shows the next copy.
pub(crate) async fn post_mark(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    RequestUser(by): RequestUser,
    Form(form): Form<MarkForm>,
) -> HandlerResult<FormAnswer> {
    let copy = (PartId(form.part), form.copy.saturating_sub(1));
    let address = format!("/builds/{number}/break-out");
    let told = match web.ledger.mark_pick(BuildId(number), copy, form.mark, form.seen, &by).await {
        Ok(told) => told,
        Err(error) => return answer_form(Err(error), &address),
    };
    let state = BreakOutState::read(&web, number).await?;
    let next = match form.mark {
        PickMark::Open => Some(form.at),
        _ => state.next_open(form.at.saturating_sub(1)).map(|at| at + 1),
    };
    let back = next.map_or_else(|| address.clone(), |at| format!("{address}?at={at}"));
    let Some(first) = told else { return Ok(FormAnswer::back_to(&back)) };
    let (who, when) = (name_of_user(&first.told_by), web.time_view().time_text(first.told_at));
    let (title, sentence) = match first.mark == form.mark {
        true => (
            "Said already",
            format!(
                "{who} said so before, {when}: {}. Is it another copy that you have in hand?",
                mark_word(first.mark)
            ),
        ),
        false => (
            "Not recorded",
            format!(
                "{who} said since, {when}, that this copy is {}. That stays. Look at the copy again to say otherwise.",
                mark_word(first.mark)
            ),
        ),
    };
    // Whoever says otherwise looks at the same copy first.
    let back = if first.mark == form.mark { back } else { format!("{address}?at={}", form.at) };
    Ok(FormAnswer::told(title, vec![sentence], &back))
}

/// A button that concerns all copies.
#[derive(Debug, Deserialize)]
pub(crate) struct AllForm {
    /// What is said of all copies of which nobody said anything yet.
    mark: Option<PickMark>,
    /// Sent if the outcome is meant although the file of the build lies in the queue.
    anyway: Option<String>,
}

/// Says the same of all copies that are left, or tells the outcome of the build once something is said of each.
pub(crate) async fn post_all(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    RequestUser(by): RequestUser,
    Form(form): Form<AllForm>,
) -> HandlerResult<FormAnswer> {
    let (build, address) = (BuildId(number), format!("/builds/{number}/break-out"));
    let Some(mark) = form.mark else {
        let back = format!("/builds/{number}");
        return say_word(&web, &OperatorWord::BreakOut(build), &by, form.anyway.is_some(), &back).await;
    };
    let state = BreakOutState::read(&web, number).await?;
    let open = state.map.list.copies.iter().zip(&state.states).filter(|(_, state)| matches!(state, CopyState::Open));
    let open: Vec<_> = open.map(|(copy, _)| (PartId(copy.part), copy.copy.saturating_sub(1))).collect();
    web.ledger.mark_picks(build, &open, mark, &by).await?;
    Ok(FormAnswer::back_to(&address))
}
