//! Breaking a build out step by step, on a tablet beside the cake: a card for each copy, in the order of the pick map, with large
//! buttons. What is said of a copy is in the ledger, so that several people work on one build and see what the others did. Each of them is
//! shown another copy.

use std::{collections::BTreeMap, sync::Arc, time::Instant};

use axum::{
    Form,
    extract::{Path, State},
    http::HeaderMap,
    response::{IntoResponse, Redirect, Response},
};
use language::{comma, say};
use ledger::{BuildId, OperatorWord, PartId, PickMark, PickMarkRow};
use maud::{Markup, html};
use serde::Deserialize;

use super::{
    bins::bins_table,
    break_out_card::{ShownStep, current_card, last_line, open_list, progress_line, summary_section},
    break_out_state::{BreakOutState, CopyState, copy_title},
    together::positions_in,
};
use crate::{
    tables::mark_word,
    web::{
        base::{error::HandlerResult, page::html_page, query::Query},
        core::{
            command::answer_form,
            device_name::device_user,
            form_answer::FormAnswer,
            request_user::{RequestUser, name_of_user},
            shown_copies::{RequestDevice, ScreenLook},
            state::DashboardState,
        },
        forms::operate_form::say_word,
        paper::label_form::build_labels,
    },
};

/// Which copy is shown, by its number in the list; without any, the next that is in the cake and on no other screen.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct StepQuery {
    /// A copy that a person chose.
    at: Option<usize>,
    /// The copy after this one.
    after: Option<usize>,
    /// A copy that a person has in hand, though another screen shows it.
    take: Option<usize>,
}

/// The page.
pub(crate) async fn show_step(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    Query(query): Query<StepQuery>,
    RequestUser(user): RequestUser,
    device: RequestDevice,
) -> HandlerResult<(HeaderMap, Response)> {
    let state = BreakOutState::read(&web, number).await?;
    let look = ScreenLook { build: number, device: &device, user: &user, now: Instant::now() };
    let position = |number: Option<usize>| number.and_then(|n| n.checked_sub(1)).filter(|&at| at < state.states.len());
    if let Some(at) = position(query.take) {
        web.shown.choose(&look, at, true);
        web.said.notify_one();
        return Ok((device.headers(), Redirect::to(&state.address_of(at)).into_response()));
    }
    let step = match position(query.at) {
        Some(at) => Some(ShownStep { at, is_chosen: true, other: choose_open(&web, &state, &look, at) }),
        None => {
            let at = web.shown.offer(&look, &state.open_positions(), position(query.after));
            at.map(|at| ShownStep { at, is_chosen: false, other: None })
        }
    };
    let content = step_content(&web, &state, step.as_ref(), &look);
    let page = html_page(&say!("break-out-title", build = state.build.id.to_string()), "", None, &content);
    Ok((device.headers(), page.into_response()))
}

/// Puts a chosen copy on the screen, if it is in the cake; returns whose screen shows it already.
fn choose_open(web: &DashboardState, state: &BreakOutState, look: &ScreenLook<'_>, at: usize) -> Option<String> {
    matches!(state.states[at], CopyState::Open).then(|| web.shown.choose(look, at, false)).flatten()
}

fn step_content(
    web: &Arc<DashboardState>,
    state: &BreakOutState,
    step: Option<&ShownStep>,
    look: &ScreenLook<'_>,
) -> Markup {
    let (counts, view, elsewhere) = (state.counts(), web.time_view(), web.shown.elsewhere(look));
    html! {
        h1 { (say!("break-out-title", build = state.build.id.to_string())) }
        (progress_line(&counts))
        @match step {
            Some(step) => (current_card(web, state, step, &elsewhere, &view)),
            None if !state.open_positions().is_empty() => (all_elsewhere(state, &elsewhere)),
            None => {}
        }
        @if state.open_positions().is_empty() { (summary_section(web, state, &counts)) }
        (last_line(web, state, look.user, &view))
        (device_user(web, look.user, &state.address()))
        (bins_table(&counts))
        (open_list(web, state, &elsewhere))
        (build_labels(state.build.id.0))
        p.links { a href=(format!("/builds/{}/pick", state.build.id)) { (say!("whole-pick-map")) }
            a href=(format!("/builds/{}", state.build.id)) { (say!("build-number", build = state.build.id.to_string())) } }
    }
}

/// Instead of a card: the last copies are on other screens.
fn all_elsewhere(state: &BreakOutState, elsewhere: &BTreeMap<usize, String>) -> Markup {
    html! {
        section.card.step aria-label=(say!("on-other-screens")) {
            h2 { (say!("last-elsewhere", count = elsewhere.len())) }
            ul { @for (&at, user) in elsewhere {
                @let copy = &state.map.list.copies[at];
                li { a href=(state.address_of(at)) { (copy_title(copy)) } (comma()) (name_of_user(user)) }
            } }
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
    web.said.notify_one();
    let step = if form.mark == PickMark::Open { "at" } else { "after" };
    let back = format!("{address}?{step}={}", form.at);
    let Some(first) = told else { return Ok(FormAnswer::back_to(&back)) };
    let (who, when) = (name_of_user(&first.told_by), web.time_view().near_text(first.told_at));
    let word = mark_word(first.mark);
    if first.mark == form.mark {
        let sentence = say!("said-before", who = who, when = when, word = word);
        return Ok(FormAnswer::told(&say!("said-already"), vec![sentence], &back));
    }
    let sentence = say!("said-since", who = who, when = when, word = word);
    // Whoever says otherwise looks at the same copy first.
    Ok(FormAnswer::told(&say!("not-recorded"), vec![sentence], &format!("{address}?at={}", form.at)))
}

/// A button that concerns several copies, or all.
#[derive(Debug, Deserialize)]
pub(crate) struct AllForm {
    /// What is said of the copies of which nobody said anything yet. Without it, the outcome is told.
    mark: Option<PickMark>,
    /// The numbers of the copies, as ranges; all unless given.
    numbers: Option<String>,
    /// Number of the copy after which the next is shown.
    after: Option<usize>,
    /// Sent if the outcome is meant although the file of the build lies in the queue.
    anyway: Option<String>,
}

/// Says the same of several copies, or tells the outcome of the build once something is said of each.
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
    let meant = match &form.numbers {
        None => state.open_positions(),
        Some(numbers) => match positions_in(numbers, state.states.len()) {
            Some(positions) => positions.into_iter().collect(),
            None => return Ok(FormAnswer::refused(vec![say!("no-copies-of-build")], &address)),
        },
    };
    let copies = &state.map.list.copies;
    let meant: Vec<_> = meant.iter().map(|&at| (PartId(copies[at].part), copies[at].copy.saturating_sub(1))).collect();
    let known = match web.ledger.mark_picks(build, &meant, mark, &by).await {
        Ok(known) => known,
        Err(error) => return answer_form(Err(error), &address),
    };
    web.said.notify_one();
    let back = form.after.map_or_else(|| address.clone(), |after| format!("{address}?after={after}"));
    if known.is_empty() {
        return Ok(FormAnswer::back_to(&back));
    }
    let recorded = meant.len() - known.len();
    let mut sentences = vec![say!("recorded-as", copies = recorded, word = mark_word(mark))];
    sentences.extend(known.iter().map(|row| said_before(&state, row)));
    Ok(FormAnswer::told(&say!("recorded-in-part"), sentences, &back))
}

/// What somebody said of a copy before.
fn said_before(state: &BreakOutState, row: &PickMarkRow) -> String {
    let copies = &state.map.list.copies;
    let copy = copies.iter().find(|copy| (copy.part, copy.copy) == (row.part_id.0, row.copy + 1));
    let name = copy.map(copy_title).unwrap_or_default();
    say!("copy-is-said-before", copy = name, word = mark_word(row.mark), who = name_of_user(&row.told_by))
}

/// A press that is taken back, by the numbers of its marks.
#[derive(Debug, Deserialize)]
pub(crate) struct UndoForm {
    first: i64,
    last: i64,
    /// Number of its first copy.
    at: usize,
}

/// Takes back what was said at once, then shows the copy.
pub(crate) async fn post_undo(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    RequestUser(by): RequestUser,
    Form(form): Form<UndoForm>,
) -> HandlerResult<FormAnswer> {
    let address = format!("/builds/{number}/break-out");
    let back = format!("{address}?at={}", form.at);
    match web.ledger.undo_picks(BuildId(number), form.first..=form.last, &by).await {
        Ok(0) => {
            let sentence = say!("nothing-to-undo-text");
            Ok(FormAnswer::told(&say!("nothing-to-undo"), vec![sentence], &back))
        }
        Ok(_) => {
            web.said.notify_one();
            Ok(FormAnswer::back_to(&back))
        }
        Err(error) => answer_form(Err(error), &address),
    }
}
