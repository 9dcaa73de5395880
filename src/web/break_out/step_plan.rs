//! Where a copy stands, drawn from above: what is around it, and from where it is measured. The machine's front is at the bottom.

use build_file::kind_colour_code;
use glam::DVec2;
use language::say;
use maud::{Markup, html};

use super::break_out_state::{BreakOutState, CopyState, copy_title};
use crate::{tables::PickedCopy, web::figures::outline::OUTLINE_SCALE};

/// Copies around the one that is looked for that a plan shows.
const SHOWN_NEIGHBOURS: usize = 30;

/// The copy at a position of the list in the colour of its bin, and copies that are still in the cake, each of which may be chosen.
pub(super) fn step_plan(state: &BreakOutState, at: usize, kind: usize) -> Markup {
    let shapes = &state.map.shapes;
    let (DVec2 { x, y }, unit) = (shapes.floor_mm, shapes.floor_mm.max_element() / 100.0);
    let copies = &state.map.list.copies;
    let around = (at + 1..copies.len()).chain(0..at).filter(|&other| matches!(state.states[other], CopyState::Open));
    html! {
        svg.plan viewBox=(format!("{:.1} {:.1} {:.1} {:.1}", -unit, -unit, x + 2.0 * unit, y + 10.0 * unit)) role="group"
            aria-label=(say!("step-plan")) {
            rect.grid x="0" y="0" width=(x) height=(y) {}
            g transform=(OUTLINE_SCALE) {
                @for other in around.take(SHOWN_NEIGHBOURS) {
                    @let copy = &copies[other];
                    // The list below has them for the keyboard.
                    a.covers href=(state.address_of(other)) tabindex="-1"
                        aria-label=(copy_title(copy)) { path d=(shapes.outlines[other]) {} }
                }
                path.sought fill=(kind_colour_code(kind)) d=(shapes.outlines[at]) {}
            }
            (measures(&copies[at], shapes.floor_mm, unit))
            text.number x=(x / 2.0) y=(y + 8.0 * unit) font-size=(format!("{:.1}", 7.0 * unit)) { (say!("front")) }
        }
    }
}

/// The lines along which the place of a copy is measured, from the left side and from the front, with their lengths.
fn measures(copy: &PickedCopy, floor_mm: DVec2, unit: f64) -> Markup {
    let (Some(x), Some(y)) = (copy.center_x_mm, copy.center_y_mm) else { return html! {} };
    let (size, top, end) = (7.0 * unit, floor_mm.y - y, 2.0 * unit);
    let line = |from: DVec2, to: DVec2| {
        html! { line x1=(format!("{:.1}", from.x)) y1=(format!("{:.1}", from.y)) x2=(format!("{:.1}", to.x)) y2=(format!("{:.1}", to.y)) {} }
    };
    let text = |at: DVec2, anchor: &str, mm: f64| {
        html! { text.number x=(format!("{:.1}", at.x)) y=(format!("{:.1}", at.y)) text-anchor=(anchor) font-size=(format!("{size:.1}"))
        stroke-width=(format!("{:.2}", 1.5 * unit)) { (format!("{mm:.0}")) } }
    };
    // The length from the front stands on the side with more room.
    let (beside, anchor) = if x > 0.6 * floor_mm.x { (-1.5 * unit, "end") } else { (1.5 * unit, "start") };
    let above = if top < 2.0 * size { size + unit } else { -1.5 * unit };
    html! {
        g.measure stroke-width=(format!("{:.2}", 0.8 * unit)) {
            (line(DVec2::new(0.0, top), DVec2::new(x, top)))
            (line(DVec2::new(0.0, top - end), DVec2::new(0.0, top + end)))
            (line(DVec2::new(x, floor_mm.y), DVec2::new(x, top)))
            (line(DVec2::new(x - end, floor_mm.y), DVec2::new(x + end, floor_mm.y)))
        }
        (text(DVec2::new(0.5 * x.max(size), top + above), "middle", x))
        (text(DVec2::new(x + beside, 0.5 * (floor_mm.y + top) + 0.35 * size), anchor, y))
    }
}
