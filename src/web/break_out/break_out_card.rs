//! What the page for breaking a build out shows: the card of a copy, the bins, and what is left.

use build_file::kind_colour_code;
use glam::DVec2;
use ledger::{BuildState, PickMark, PickMarkRow};
use maud::{Markup, html};

use super::break_out_state::{BinCount, BreakOutState, CopyState, mark_word, sum_of};
use crate::{
    tables::{PickedCopy, TimeView, fields, points_down, removal_in_words},
    web::{
        base::format::count,
        core::{form_answer::key_field, picture::themed_picture, request_user::name_of_user, state::DashboardState},
    },
};

/// Copies around the one that is looked for that a plan shows.
const SHOWN_NEIGHBOURS: usize = 30;

/// How far it is.
pub(crate) fn progress_line(counts: &[BinCount]) -> Markup {
    let sum = sum_of(counts);
    html! {
        p role="status" { b { (sum.all - sum.open()) " of " (count(sum.all, "copy", "copies")) }
            ": " (sum.good) " good, " (sum.bad) " bad, " (sum.missing) " not found, " (sum.open()) " in the cake." }
        progress max=(sum.all) value=(sum.all - sum.open()) aria-label="Copies of which something is said" {}
    }
}

/// A patch in the colour of a bin.
fn swatch(bin: usize) -> Markup {
    html! { svg.swatch viewBox="0 0 10 10" aria-hidden="true" { rect width="10" height="10" fill=(kind_colour_code(bin)) {} } }
}

/// The card of the copy at a position of the list.
pub(super) fn current_card(web: &DashboardState, state: &BreakOutState, at: usize, view: &TimeView) -> Markup {
    let copy = &state.map.list.copies[at];
    let bin = state.bins.iter().position(|order| *order == copy.order).unwrap_or(0);
    let source = format!("/builds/{}/parts/{}/picture?kind={bin}", state.build.id, copy.part);
    html! {
        section.card.step aria-label=(format!("Copy {} of {}", copy.number, state.states.len())) {
            h2 { (copy.number) ": " (copy.name) }
            div.step-sights {
                (themed_picture(&source, &html! { img width="400" height="300" alt=(format!("The part {}", copy.name)) src=(source); }))
                (step_plan(state, at))
            }
            p.bin { (swatch(bin)) " " b { "Bin " (bin + 1) } ": " @if copy.order.is_empty() { "no order" } @else { "order " (copy.order) } }
            p { (place_text(copy)) }
            @if copy.direction.is_some_and(points_down) { p.warn { "It comes out when the cake is lifted or turned." } }
            @if !copy.note.is_empty() { p { b { (fields::NOTE.label) ": " } (copy.note) } }
            @if let Some(others) = state.map.shapes.look_alikes.get(&copy.part) {
                p.warn { "Looks like " (others.join(", ")) "." }
            }
            @match &state.states[at] {
                CopyState::Open => { (step_buttons(web, state, at)) }
                CopyState::ToldBad => { p.warn { "It was told bad, and waits to be printed again." } (next_link(state, at)) }
                CopyState::Marked(row) => {
                    p.warn { "It is " (mark_word(row.mark)) ", as " (name_of_user(&row.told_by)) " said, " (view.time_text(row.told_at)) "." }
                    @if web.orders { div.step-buttons { (mark_form(web, state, (copy, Some(row)), PickMark::Open, "It is still in the cake", "")) } }
                    (next_link(state, at))
                }
            }
        }
    }
}

/// Where a copy is, and which way it comes out.
fn place_text(copy: &PickedCopy) -> String {
    let place = match (copy.top_mm, copy.center_x_mm, copy.center_y_mm) {
        (Some(top), Some(x), Some(y)) => {
            format!("Top at {top:.0} mm, {x:.0} mm from the left, {y:.0} mm from the front.")
        }
        _ => "Its original is no longer kept: its place is not known.".to_owned(),
    };
    let way = copy.direction.map(|direction| format!(" Out: {}.", removal_in_words(direction)));
    let due = if copy.due.is_empty() { String::new() } else { format!(" Due {}.", copy.due) };
    format!("Copy {}. {place}{}{due}", copy.copy, way.unwrap_or_default())
}

fn step_buttons(web: &DashboardState, state: &BreakOutState, at: usize) -> Markup {
    let copy = &state.map.list.copies[at];
    html! {
        @if web.orders {
            div.step-buttons {
                (mark_form(web, state, (copy, None), PickMark::Out, "Out", "good"))
                (mark_form(web, state, (copy, None), PickMark::Bad, "Bad", "spoilt"))
                (mark_form(web, state, (copy, None), PickMark::Missing, "Not found", ""))
            }
        }
        (next_link(state, at))
    }
}

/// To the next copy that is in the cake.
fn next_link(state: &BreakOutState, at: usize) -> Markup {
    let next = state.next_open(at).filter(|&next| next != at);
    html! { @if let Some(next) = next { p.links { a href=(format!("{}?at={}", state.address(), next + 1)) { "Later: show the next one" } } } }
}

/// The copy and those that come after it, from above. The machine's front is at the bottom.
fn step_plan(state: &BreakOutState, at: usize) -> Markup {
    let shapes = &state.map.shapes;
    let (DVec2 { x, y }, unit) = (shapes.floor_mm, shapes.floor_mm.max_element() / 100.0);
    let corner = |p: &DVec2| format!("{:.1},{:.1}", p.x, y - p.y);
    let corners = |at: usize| shapes.footprints[at].iter().map(corner).collect::<Vec<_>>().join(" ");
    let others = (at + 1..state.states.len()).filter(|&other| matches!(state.states[other], CopyState::Open));
    html! {
        svg.plan viewBox=(format!("{:.1} {:.1} {:.1} {:.1}", -unit, -unit, x + 2.0 * unit, y + 8.0 * unit)) role="img" aria-label="Where it stands, from above" {
            rect.grid x="0" y="0" width=(x) height=(y) {}
            @for other in others.take(SHOWN_NEIGHBOURS) { polygon.covers points=(corners(other)) {} }
            @if !shapes.footprints[at].is_empty() { polygon.sought points=(corners(at)) {} }
            text.number x=(x / 2.0) y=(y + 6.0 * unit) font-size=(format!("{:.1}", 5.0 * unit)) { "front" }
        }
    }
}

/// The bins with their counts.
pub(super) fn bins_table(counts: &[BinCount]) -> Markup {
    html! {
        h2 { "Bins" }
        div.wide tabindex="0" role="region" aria-label="Bins" { table.bins {
            thead { tr { th scope="col" { "Bin" } th scope="col" { "Order" } th.n scope="col" { "Copies" } th.n scope="col" { "Good" }
                th.n scope="col" { "Bad" } th.n scope="col" { "Not found" } th.n scope="col" { "In the cake" } } }
            tbody { @for (bin, counted) in counts.iter().enumerate() { tr {
                td { (swatch(bin)) " " (bin + 1) } td { (counted.name()) } td.n { (counted.all) } td.n { (counted.good) }
                td.n { (counted.bad) } td.n { (counted.missing) } td.n { (counted.open()) @if counted.open() == 0 { " \u{2713}" } }
            } } }
        } }
    }
}

/// What is still in the cake, with a link to each copy, and buttons for all of it.
pub(super) fn open_list(web: &DashboardState, state: &BreakOutState) -> Markup {
    let open: Vec<&PickedCopy> = (state.map.list.copies.iter().zip(&state.states))
        .filter_map(|(copy, state)| matches!(state, CopyState::Open).then_some(copy))
        .collect();
    let all = |mark: PickMark, label: &str| {
        html! { form.order method="post" action=(format!("{}/all", state.address())) {
            (key_field(web))
            button type="submit" name="mark" value=(mark) { (label) }
        } }
    };
    html! {
        @if !open.is_empty() {
            details { summary { "Still in the cake: " (count(open.len() as u32, "copy", "copies")) }
                ul.still { @for copy in &open { li {
                    a href=(format!("{}?at={}", state.address(), copy.number)) { (copy.number) ": " (copy.name) ", copy " (copy.copy) }
                    @if !copy.order.is_empty() { ", order " (copy.order) }
                } } }
                @if web.orders {
                    div.buttons { (all(PickMark::Out, "All of these are out and good")) (all(PickMark::Missing, "None of these was found")) }
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
        CopyState::ToldBad => Some((copy, "told bad")),
        _ => None,
    });
    let is_lost = |state: &CopyState| matches!(state, CopyState::Marked(row) if row.mark.is_lost());
    let is_told = matches!(state.build.state, BuildState::Complete | BuildState::Interrupted)
        && !state.states.iter().any(is_lost);
    html! {
        section.card.step aria-label="The end" {
            h2 { "The cake is empty" }
            p { (sum.good) " of " (count(sum.all, "copy is", "copies are")) " good." }
            @if sum.bad + sum.missing > 0 {
                ul { @for (copy, what) in lost { li { (copy.number) ": " (copy.name) ", copy " (copy.copy) @if !copy.order.is_empty() { ", order " (copy.order) } ": " (what) } } }
            }
            @if is_told { p.ok { "The outcome is told." } }
            @else if web.orders {
                form.order method="post" action=(format!("{}/all", state.address())) {
                    (key_field(web))
                    div.step-buttons { button.good type="submit" {
                        @if sum.bad + sum.missing > 0 { "Tell it: printed, and those copies again" } @else { "Tell it: printed, all good" }
                    } }
                }
                p { "Copies that are bad or were not found wait again, first in line, with all that was asked." }
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
            button class=(class) type="submit" name="mark" value=(mark) { (label) span.unseen { ": " (copy.name) ", copy " (copy.copy) } }
        }
    }
}
