//! What the page for breaking a build out shows: the card of a copy, what is left, and what was said last.

use access::Role;
use std::collections::BTreeMap;

use language::{colon, comma, join_names, say};
use ledger::{BuildState, PickMark, PickMarkRow};
use maud::{Markup, html};

use super::{
    bins::{bin_badge, bin_kind},
    break_out_state::{BinCount, BreakOutState, CopyState, copy_title, sum_of},
    step_plan::step_plan,
    together::together_buttons,
};
use crate::{
    tables::{PickedCopy, TimeView, fields, mark_word, points_down, removal_in_words},
    web::core::{form_answer::key_field, picture::themed_picture, request_user::name_of_user, state::DashboardState},
};

/// How far it is.
pub(crate) fn progress_line(counts: &[BinCount]) -> Markup {
    let sum = sum_of(counts);
    html! {
        @let told = html! { b { (say!("told-of", told = sum.all - sum.open(), copies = sum.all)) } };
        p role="status" { (phrase!("break-out-counts", told = told, good = sum.good, bad = sum.bad, missing = sum.missing, open = sum.open())) }
        progress max=(sum.all) value=(sum.all - sum.open()) aria-label=(say!("copies-told")) {}
    }
}

/// A copy that is shown.
pub(super) struct ShownStep {
    /// Its position in the list.
    pub(super) at: usize,
    /// Whether a person chose it.
    pub(super) is_chosen: bool,
    /// Whose screen shows it already.
    pub(super) other: Option<String>,
}

/// The card of a copy. What a person presses comes before texts of any length, so that it is always in the same place. `elsewhere` are the
/// copies on other screens.
pub(super) fn current_card(
    web: &DashboardState,
    state: &BreakOutState,
    step: &ShownStep,
    elsewhere: &BTreeMap<usize, String>,
    view: &TimeView,
) -> Markup {
    let at = step.at;
    let copy = &state.map.list.copies[at];
    let bin = state.bin_of(copy);
    let source = format!("/builds/{}/parts/{}/picture?kind={}", state.build.id, copy.part, bin_kind(bin));
    html! {
        section.card.step aria-label=(say!("copy-of-all", number = copy.number, all = state.states.len())) {
            h2 { (copy.number) (colon()) (copy.name) }
            p.bin { (bin_badge(bin)) span { b { (say!("bin-number", number = bin + 1)) } (colon()) @if copy.order.is_empty() { (say!("bin-no-order")) } @else { (say!("order-of", order = &copy.order)) } } }
            div.step-sights {
                (themed_picture(&source, &html! { img width="400" height="300" alt=(say!("the-part", name = &copy.name)) src=(source); }))
                (step_plan(state, at, bin_kind(bin)))
            }
            (what_is_said(web, state, step, view))
            @if step.is_chosen { p.note role="status" { (say!("chosen-copy", number = copy.number, name = &copy.name, copy = copy.copy)) } }
            p { (place_text(copy, view)) }
            @if copy.direction.is_some_and(points_down) { p.warn { (say!("comes-out-downwards")) } }
            @if !copy.finish.is_empty() { p { b { (fields::FINISH.said()) (colon()) } (copy.finish) } }
            @if !copy.note.is_empty() { p { b { (fields::NOTE.said()) (colon()) } (copy.note) } }
            @if let Some(others) = state.map.shapes.look_alikes.get(&copy.part) {
                p.warn { (say!("looks-like", names = join_names(others))) }
            }
            @if matches!(state.states[at], CopyState::Open) && step.other.is_none() { (together_buttons(web, state, at, elsewhere)) }
            @let after = format!("{}?after={}", state.address(), copy.number);
            p.links { a href=(after) { @if step.is_chosen { (say!("go-on-next")) } @else { (say!("later-next")) } } }
        }
    }
}

/// What is known of the shown copy, and the buttons that say something of it.
fn what_is_said(web: &DashboardState, state: &BreakOutState, step: &ShownStep, view: &TimeView) -> Markup {
    let copy = &state.map.list.copies[step.at];
    match (&state.states[step.at], &step.other) {
        (CopyState::Open, None) => step_buttons(web, state, copy),
        (CopyState::Open, Some(user)) => html! {
            p.warn role="status" { (say!("on-screen-of", name = name_of_user(user))) }
            @if web.offers(Role::Operate) { div.step-buttons { a.button href=(format!("{}?take={}", state.address(), copy.number)) { (say!("have-in-hand")) } } }
        },
        (CopyState::ToldBad, _) => html! { p.warn { (say!("was-told-bad")) } },
        (CopyState::Marked(row), _) => html! {
            p.warn role="status" { (say!("copy-is-said", word = mark_word(row.mark), who = name_of_user(&row.told_by), when = view.near_text(row.told_at))) }
            @if web.offers(Role::Operate) { div.step-buttons { (mark_form(web, state, (copy, Some(row)), PickMark::Open, &say!("still-in-cake"), "")) } }
        },
    }
}

fn step_buttons(web: &DashboardState, state: &BreakOutState, copy: &PickedCopy) -> Markup {
    html! {
        @if web.offers(Role::Operate) {
            div.step-buttons {
                (mark_form(web, state, (copy, None), PickMark::Out, &say!("press-out"), "good"))
                (mark_form(web, state, (copy, None), PickMark::Bad, &say!("press-bad"), "spoilt"))
                (mark_form(web, state, (copy, None), PickMark::Missing, &say!("press-missing"), ""))
            }
        }
    }
}

/// Where a copy is, and which way it comes out.
fn place_text(copy: &PickedCopy, view: &TimeView) -> String {
    let place = match (copy.top_mm, copy.center_x_mm, copy.center_y_mm) {
        (Some(top), Some(x), Some(y)) => {
            let [top, x, y] = [top, x, y].map(|mm| format!("{mm:.0}"));
            say!("place-of-copy", top = top, x = x, y = y)
        }
        _ => say!("place-not-known"),
    };
    let way = copy.direction.map(|direction| say!("way-out", way = removal_in_words(direction)));
    let due = (!copy.due.is_empty()).then(|| say!("order-due", due = view.near_date(&copy.due)));
    let number = say!("copy-number", copy = copy.copy);
    [Some(number), Some(place), way, due].into_iter().flatten().collect::<Vec<_>>().join(" ")
}

/// What is still in the cake, with a link to each copy, and buttons for all of it.
pub(super) fn open_list(web: &DashboardState, state: &BreakOutState, elsewhere: &BTreeMap<usize, String>) -> Markup {
    let open = state.open_positions();
    let all = |mark: PickMark, label: &str| {
        html! { form.order method="post" action=(format!("{}/all", state.address())) {
            (key_field(web))
            button type="submit" name="mark" value=(mark) { (label) }
        } }
    };
    html! {
        @if !open.is_empty() {
            details { summary { (say!("still-in-cake-count", copies = open.len())) }
                ul.still { @for &at in &open { li {
                    @let copy = &state.map.list.copies[at];
                    a href=(state.address_of(at)) { (copy_title(copy)) }
                    @if !copy.order.is_empty() { (comma()) (say!("order-of", order = &copy.order)) }
                    @if let Some(user) = elsewhere.get(&at) { (comma()) (say!("screen-of", name = name_of_user(user))) }
                } } }
                @if web.offers(Role::Operate) {
                    div.buttons { (all(PickMark::Out, &say!("all-out-good"))) (all(PickMark::Missing, &say!("none-found"))) }
                }
            }
        }
    }
}

/// What is told when something is said of every copy.
pub(super) fn summary_section(web: &DashboardState, state: &BreakOutState, counts: &[BinCount]) -> Markup {
    let sum = sum_of(counts);
    let lost = state.map.list.copies.iter().zip(&state.states).filter_map(|(copy, state)| match state {
        CopyState::Marked(row) if row.mark.is_lost() => Some((copy, mark_word(row.mark))),
        CopyState::ToldBad => Some((copy, say!("told-bad"))),
        _ => None,
    });
    let is_lost = |state: &CopyState| matches!(state, CopyState::Marked(row) if row.mark.is_lost());
    let is_told = matches!(state.build.state, BuildState::Complete | BuildState::Interrupted)
        && !state.states.iter().any(is_lost);
    html! {
        section.card.step aria-label=(say!("the-end")) {
            h2 { (say!("cake-is-empty")) }
            p { (say!("good-of-all", good = sum.good, copies = sum.all)) }
            @if sum.bad + sum.missing > 0 {
                ul { @for (copy, what) in lost { li { (copy_title(copy)) @if !copy.order.is_empty() { (comma()) (say!("order-of", order = &copy.order)) } ": " (what) } } }
            }
            @if is_told { p.ok { (say!("outcome-is-told")) } }
            @else if web.offers(Role::Operate) {
                form.order method="post" action=(format!("{}/all", state.address())) {
                    (key_field(web))
                    div.step-buttons { button.good type="submit" {
                        @if sum.bad + sum.missing > 0 { (say!("tell-some-again")) } @else { (say!("tell-all-good")) }
                    } }
                }
                p { (say!("bad-wait-again")) }
            }
        }
    }
}

/// A button that says something of a copy, of which this mark is shown. The page shows what follows it afterwards.
pub(super) fn mark_form(
    web: &DashboardState,
    state: &BreakOutState,
    (copy, shown): (&PickedCopy, Option<&PickMarkRow>),
    mark: PickMark,
    label: &str,
    class: &str,
) -> Markup {
    html! {
        form.order method="post" action=(state.address()) {
            (key_field(web))
            input type="hidden" name="part" value=(copy.part);
            input type="hidden" name="copy" value=(copy.copy);
            input type="hidden" name="at" value=(copy.number);
            input type="hidden" name="seen" value=(shown.map_or(0, |row| row.id));
            button class=(class) type="submit" name="mark" value=(mark) { (label) span.unseen { (colon()) (say!("name-and-copy", name = &copy.name, copy = copy.copy)) } }
        }
    }
}

/// What was said last, with the button that takes it back.
pub(super) fn last_line(web: &DashboardState, state: &BreakOutState, user: &str, view: &TimeView) -> Markup {
    let press = state.last_press(user);
    let ids = || press.iter().map(|(_, row)| row.id);
    let (Some((copy, row)), Some(first), Some(last)) = (press.first(), ids().min(), ids().max()) else {
        return html! {};
    };
    html! {
        div.undo {
            @let (word, who, when) = (mark_word(row.mark), name_of_user(&row.told_by), view.near_text(row.told_at));
            p { @if press.len() > 1 { (say!("last-press-all", copies = press.len(), word = word, who = who, when = when)) }
                @else { (say!("last-press", number = copy.number, name = &copy.name, copy = copy.copy, word = word, who = who, when = when)) } }
            @if web.offers(Role::Operate) {
                form.order method="post" action=(format!("{}/undo", state.address())) {
                    (key_field(web))
                    @for (name, value) in [("first", first), ("last", last), ("at", copy.number as i64)] {
                        input type="hidden" name=(name) value=(value);
                    }
                    button type="submit" { @if press.len() > 1 { (say!("undo-all", count = press.len())) } @else { (say!("undo")) } }
                }
            }
        }
    }
}
