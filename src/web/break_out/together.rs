//! What is said of several copies at once: of all copies of a part, or of an order, that are in reach.

use access::Role;
use std::collections::{BTreeMap, BTreeSet};

use language::say;
use ledger::PickMark;
use maud::{Markup, html};

use super::break_out_state::BreakOutState;
use crate::web::core::{form_answer::key_field, state::DashboardState};

/// How far below the top of the shown copy the top of another may lie that is in reach with it, mm: about the length of a finger.
const REACH_MM: f64 = 40.0;

/// Buttons that say of all copies of the shown part, and of all of its order, that are in reach that they are out. `elsewhere` are
/// positions of copies on other screens: whoever has them in hand says so.
pub(super) fn together_buttons(
    web: &DashboardState,
    state: &BreakOutState,
    at: usize,
    elsewhere: &BTreeMap<usize, String>,
) -> Markup {
    let copies = &state.map.list.copies;
    let shown = &copies[at];
    let reach: Vec<usize> = (state.open_positions().into_iter())
        .filter(|other| !elsewhere.contains_key(other))
        .filter(|&other| other == at || is_in_reach(shown.top_mm, copies[other].top_mm))
        .collect();
    let alike: Vec<usize> = reach.iter().copied().filter(|&other| copies[other].part == shown.part).collect();
    let order: Vec<usize> = reach.into_iter().filter(|&other| copies[other].order == shown.order).collect();
    let has_order = !shown.order.is_empty();
    html! {
        @if web.offers(Role::Operate) && order.len() > 1 {
            div.step-more {
                @if alike.len() > 1 { (together_form(web, state, &alike, &say!("all-of-part-out", count = alike.len()))) }
                @if order.len() > alike.len() && has_order { (together_form(web, state, &order, &say!("all-of-order-out", count = order.len()))) }
                @if order.len() > alike.len() && !has_order { (together_form(web, state, &order, &say!("all-without-order-out", count = order.len()))) }
            }
        }
    }
}

fn is_in_reach(shown_top_mm: Option<f64>, top_mm: Option<f64>) -> bool {
    shown_top_mm.zip(top_mm).is_some_and(|(shown, top)| top >= shown - REACH_MM)
}

fn together_form(web: &DashboardState, state: &BreakOutState, positions: &[usize], label: &str) -> Markup {
    html! {
        form.order method="post" action=(format!("{}/all", state.address())) {
            (key_field(web))
            input type="hidden" name="numbers" value=(number_ranges(positions));
            input type="hidden" name="after" value=(positions.first().map_or(0, |at| at + 1));
            button.good type="submit" name="mark" value=(PickMark::Out) { (label) }
        }
    }
}

/// Positions as numbers of the list, which begin with 1, in ranges: `3-17,19`.
fn number_ranges(positions: &[usize]) -> String {
    let ranges = positions.chunk_by(|a, b| a + 1 == *b).filter_map(|range| range.first().zip(range.last()));
    let text = |(first, last): (&usize, &usize)| match first == last {
        true => format!("{}", first + 1),
        false => format!("{}-{}", first + 1, last + 1),
    };
    ranges.map(text).collect::<Vec<_>>().join(",")
}

/// The positions that a text of ranges names, of a list of `length` copies. `None` if it is not such a text.
pub(super) fn positions_in(ranges: &str, length: usize) -> Option<BTreeSet<usize>> {
    let mut positions = BTreeSet::new();
    for range in ranges.split(',') {
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        let (first, last): (usize, usize) = (first.parse().ok()?, last.parse().ok()?);
        if first == 0 || last > length {
            return None;
        }
        positions.extend(first - 1..last);
    }
    Some(positions)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_survive_as_ranges_of_numbers_and_nothing_else_is_taken() {
        for positions in [vec![0], vec![2, 3, 4, 8], (0..300).collect(), vec![1, 3, 5]] {
            let read = positions_in(&number_ranges(&positions), 300).unwrap();
            assert!(read.iter().eq(&positions), "{positions:?}");
        }
        assert_eq!(number_ranges(&[2, 3, 4, 8]), "3-5,9");
        for wrong in ["", "0", "1-301", "a", "1,,2", "-1", "1-2-3", "99999999999999999999"] {
            assert_eq!(positions_in(wrong, 300), None, "{wrong}");
        }
    }

    #[test]
    fn what_stands_higher_is_in_reach_and_what_stands_far_below_is_not() {
        assert!(is_in_reach(Some(100.0), Some(180.0)) && is_in_reach(Some(100.0), Some(60.0)));
        assert!(!is_in_reach(Some(100.0), Some(59.0)) && !is_in_reach(None, Some(60.0)));
    }
}
