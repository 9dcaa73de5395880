//! The pick map of a cake: which copies come out, in which order. It is designed for paper; the pick page serves it.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use farm::{CakeContents, CakeCopy, CakePart};
use glam::DVec2;
use language::say;
use ledger::RemovalStep;
use maud::{Markup, html};
use settings::FarmZone;
use solids::Bounds;

use super::{
    labels::{PlanLabel, separate_labels},
    look_alike::look_alikes,
    outline::{OUTLINE_SCALE, outline_path},
};
use crate::{
    tables::{PICK_COLUMNS, PickList, PickedCopy, TableColumn, TimeView, for_people, points_down},
    web::base::listing::{cell, heading},
};

/// Thickness of a band of the map, mm.
const BAND_MM: f64 = 10.0;

/// Copies per sheet of a map in proved order: with names and orders of 60 letters, plan and list fit on a page of A4.
const COPIES_PER_SHEET: usize = 22;

/// A pick map as the cache holds it.
#[derive(Clone)]
pub(crate) struct CachedPickMap {
    pub(crate) copies: usize,
    pub(crate) sheets: Markup,
    pub(crate) list: Arc<PickList>,
    pub(crate) shapes: Arc<PickShapes>,
}

/// The orders of the bins of a build, one bin each, in the order of their numbers; "" = parts without an order.
pub(crate) fn bin_orders<'c>(orders: impl Iterator<Item = &'c str>) -> Vec<&'c str> {
    orders.collect::<BTreeSet<_>>().into_iter().collect()
}

/// What an eye needs to find a copy.
#[derive(Debug, Default)]
pub(crate) struct PickShapes {
    /// Width and depth of the machine, mm.
    pub(crate) floor_mm: DVec2,
    /// The outline of each copy from above, in the order of the list, as a path in steps (`figures/outline`).
    pub(crate) outlines: Vec<String>,
    /// Parts by number, with the names of those that an eye confuses with them.
    pub(crate) look_alikes: BTreeMap<i64, Vec<String>>,
}

impl CachedPickMap {
    /// The map of a build's cake, with links to the pages of its parts.
    pub(crate) fn from_cake(cake: &CakeContents, number_of_build: i64) -> Self {
        let (picks, is_proved) = picks_in_order(cake);
        let copies = (1..).zip(&picks).map(|(number, pick)| pick_list_row(number, pick)).collect();
        let list = Arc::new(PickList { build: number_of_build, is_proved, copies });
        let sheets = map_sheets(cake, (&picks, is_proved), true);
        let shapes = Arc::new(PickShapes {
            floor_mm: cake.volume_mm.truncate(),
            outlines: picks.iter().map(|pick| pick.outline.clone()).collect(),
            look_alikes: look_alikes(&cake.parts),
        });
        Self { copies: cake.copy_count(), sheets, list, shapes }
    }
}

/// A copy to take out of the cake.
struct PickEntry<'c> {
    part: &'c CakePart,
    copy: u32,
    /// `None` when the original file of its part no longer exists.
    bounds: Option<Bounds>,
    /// Its outline seen from above, a path.
    outline: String,
    removal: Option<RemovalStep>,
}

impl PickEntry<'_> {
    fn top_mm(&self) -> Option<f64> {
        self.bounds.map(|bounds| bounds.max.z)
    }

    fn bottom_mm(&self) -> Option<f64> {
        self.bounds.map(|bounds| bounds.min.z)
    }

    fn center_mm(&self) -> Option<DVec2> {
        self.bounds.map(|bounds| 0.5 * (bounds.min + bounds.max).truncate())
    }
}

fn pick_list_row(number: usize, pick: &PickEntry<'_>) -> PickedCopy {
    let center_mm = pick.center_mm();
    PickedCopy {
        number,
        part: pick.part.part,
        name: pick.part.name.clone(),
        order: pick.part.order.clone(),
        due: pick.part.due.clone(),
        finish: pick.part.finish.clone(),
        note: pick.part.note.clone(),
        reference: pick.part.reference.clone(),
        copy: pick.copy,
        top_mm: pick.top_mm(),
        bottom_mm: pick.bottom_mm(),
        center_x_mm: center_mm.map(|c| c.x),
        center_y_mm: center_mm.map(|c| c.y),
        direction: pick.removal.map(|removal| removal.direction),
    }
}

/// Alternative text of the picture next to a map.
pub(crate) fn picture_text() -> String {
    say!("picture-of-cake")
}

/// The map of a cake without links.
pub(crate) fn map_without_links(cake: &CakeContents) -> Markup {
    let (picks, is_proved) = picks_in_order(cake);
    map_sheets(cake, (&picks, is_proved), false)
}

/// Sheet by sheet; parts are links where there are pages.
fn map_sheets(cake: &CakeContents, (picks, is_proved): (&[PickEntry<'_>], bool), has_pages: bool) -> Markup {
    let columns = shown_columns(cake, is_proved);
    let sheets = if is_proved { sheets_by_number(picks) } else { sheets_by_height(picks) };
    let mut first = 1;
    html! {
        p { (order_note(is_proved)) " " (say!("pick-axes")) }
        @if picks.iter().any(|pick| pick.removal.is_some_and(|removal| points_down(removal.direction))) {
            p { (say!("pick-downwards")) }
        }
        @if cake.missing_mesh_count() > 0 {
            p.bad { (say!("listed-without-place", parts = cake.missing_mesh_count())) }
        }
        @for (title, band) in sheets {
            section.band.page[is_proved] {
                h2 { (title) }
                div.sheet {
                    (sheet_plan(first, band, cake.volume_mm.x, cake.volume_mm.y))
                    div.wide.listed tabindex="0" role="region" aria-label=(say!("pick-sheet", title = &title)) { table {
                        colgroup { col.pick-done; @for column in &columns { col class=(format!("pick-{}", column.key)); } }
                        thead { tr { th scope="col" { (say!("pick-done")) } @for column in &columns { (heading(&column.field)) } } }
                        tbody { @for (number, pick) in (first..).zip(band) { (table_row(&pick_list_row(number, pick), &columns, has_pages)) } }
                    } }
                }
            }
            @let () = first += band.len();
        }
    }
}

/// How to read a map in the proved order, or without one.
fn order_note(is_proved: bool) -> String {
    match is_proved {
        true => say!("pick-proved-order"),
        false => say!("pick-height-order"),
    }
}

/// The copies in the proved order, or from the top down when the order of any copy is unknown; and whether it is
/// proved.
fn picks_in_order(cake: &CakeContents) -> (Vec<PickEntry<'_>>, bool) {
    let mut picks = picks_from_top(cake);
    let is_proved = !picks.is_empty() && picks.iter().all(|pick| pick.removal.is_some());
    match is_proved {
        true => picks.sort_by_key(|pick| pick.removal.map(|removal| removal.position)),
        // An incomplete order is not used.
        false => picks.iter_mut().for_each(|pick| pick.removal = None),
    }
    (picks, is_proved)
}

fn sheets_by_number<'p, 'c>(picks: &'p [PickEntry<'c>]) -> Vec<(String, &'p [PickEntry<'c>])> {
    let title = |number: usize, sheet: &[PickEntry<'_>]| {
        let first = number * COPIES_PER_SHEET;
        say!("pick-from-to", first = first + 1, last = first + sheet.len())
    };
    picks.chunks(COPIES_PER_SHEET).enumerate().map(|(number, sheet)| (title(number, sheet), sheet)).collect()
}

fn sheets_by_height<'p, 'c>(picks: &'p [PickEntry<'c>]) -> Vec<(String, &'p [PickEntry<'c>])> {
    let layer = |pick: &PickEntry<'_>| pick.top_mm().map(|top_mm| (top_mm / BAND_MM).floor() as i64);
    let title = |band: &[PickEntry<'_>]| match layer(&band[0]) {
        Some(layer) => say!("pick-from-down", height = BAND_MM as i64 * (layer + 1)),
        None => say!("pick-no-originals"),
    };
    picks.chunk_by(|a, b| layer(a) == layer(b)).map(|band| (title(band), band)).collect()
}

/// A row of the list, with a box to tick.
fn table_row(copy: &PickedCopy, columns: &[&TableColumn<PickedCopy>], has_pages: bool) -> Markup {
    // The due date of a copy is a text here.
    let view = TimeView::kept(&FarmZone::default());
    html! { tr {
        td data-of=(say!("pick-done")) { "\u{2610}" }
        @for column in columns { (cell(&column.field, &(column.value)(copy), has_pages, &view)) }
    } }
}

/// The columns of the list; without a proved order nobody knows the way, and where no copy has a due date or a note, their
/// columns are left out.
fn shown_columns(cake: &CakeContents, is_proved: bool) -> Vec<&'static TableColumn<PickedCopy>> {
    let is_shown = |column: &&'static TableColumn<PickedCopy>| match column.key {
        "way" => is_proved,
        "due" => cake.parts.iter().any(|part| !part.due.is_empty()),
        "finish" => cake.parts.iter().any(|part| !part.finish.is_empty()),
        "note" => cake.parts.iter().any(|part| !part.note.is_empty()),
        "reference" => cake.parts.iter().any(|part| !part.reference.is_empty()),
        _ => true,
    };
    for_people(PICK_COLUMNS).filter(is_shown).collect()
}

/// The outlines of a sheet's copies from above with their numbers, starting at `first`. The machine's front is at the
/// bottom.
fn sheet_plan(first: usize, band: &[PickEntry<'_>], x_mm: f64, y_mm: f64) -> Markup {
    let unit = x_mm.max(y_mm) / 100.0;
    let label = |(number, pick): (usize, &PickEntry<'_>)| {
        let center = pick.center_mm()?;
        Some(PlanLabel::new(number.to_string(), DVec2::new(center.x, y_mm - center.y), 4.5 * unit))
    };
    let labels = separate_labels((first..).zip(band).filter_map(label).collect(), DVec2::new(x_mm, y_mm));
    let rim = 3.0 * unit;
    html! {
        svg.plan viewBox=(format!("{:.1} {:.1} {:.1} {:.1}", -rim, -rim, x_mm + 2.0 * rim, y_mm + 2.0 * rim + 5.0 * unit)) preserveAspectRatio="xMinYMin" role="img"
            aria-label=(say!("pick-plan")) {
            rect.grid x="0" y="0" width=(x_mm) height=(y_mm) {}
            g.covers transform=(OUTLINE_SCALE) { @for pick in band { path d=(pick.outline) {} } }
            @for label in &labels { @if label.is_shifted() {
                line.leader x1=(format!("{:.1}", label.target.x)) y1=(format!("{:.1}", label.target.y))
                    x2=(format!("{:.1}", label.center.x)) y2=(format!("{:.1}", label.center.y)) stroke-width=(format!("{:.2}", 0.3 * unit)) {}
            } }
            @for label in &labels {
                text.number x=(format!("{:.1}", label.center.x)) y=(format!("{:.1}", label.center.y + 1.6 * unit))
                    font-size=(format!("{:.1}", 4.5 * unit)) stroke-width=(format!("{:.2}", 0.9 * unit)) { (label.text) }
            }
            text.number x=(x_mm / 2.0) y=(y_mm + 6.0 * unit) font-size=(format!("{:.1}", 4.0 * unit)) { (say!("front")) }
        }
    }
}

fn copy_outline(part: &CakePart, standing: &CakeCopy, depth_mm: f64) -> String {
    let placed =
        part.mesh.iter().flat_map(|mesh| mesh.vertices().iter().map(|&vertex| standing.pose.transform_point(vertex)));
    outline_path(placed, depth_mm)
}

/// The copies from the top down; copies without a known place come last.
fn picks_from_top(cake: &CakeContents) -> Vec<PickEntry<'_>> {
    let mut picks = Vec::with_capacity(cake.copy_count());
    for part in &cake.parts {
        picks.extend(part.copies.iter().map(|standing| PickEntry {
            part,
            copy: standing.copy,
            bounds: part.copy_bounds(standing),
            outline: copy_outline(part, standing, cake.volume_mm.y),
            removal: standing.drawn,
        }));
    }
    let top = |pick: &PickEntry<'_>| pick.top_mm().unwrap_or(f64::NEG_INFINITY);
    picks.sort_by(|a, b| top(b).total_cmp(&top(a)));
    picks
}

#[cfg(test)]
#[path = "tests/pick_map_tests.rs"]
mod tests;
