//! Lists of parts and of their copies: by state or name, by build, by order, and waiting parts.

use std::collections::BTreeMap;

use ledger::{BuildId, LineCopies, PartRow, PlacementRow};
use serde::Serialize;

use crate::{
    farm::CakePart,
    tables::{
        columns::{cell_value::CellValue, table_column::TableColumn, time_view::GivenDate},
        fields,
    },
};

/// A part in a list that counts some of its copies.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CountedPart {
    /// The part.
    pub part: PartRow,
    /// The number of its copies that the list counts.
    pub copies: u32,
}

/// A part with the builds that hold its copies.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderedPart {
    /// The part.
    pub part: PartRow,
    /// The placements of its copies in builds.
    pub placements: Vec<PlacementRow>,
    /// What became of its copies.
    pub copies: LineCopies,
}

/// Parts with a given state or name.
pub const PART_COLUMNS: &[TableColumn<PartRow>] = &[
    TableColumn::new("part", fields::PART, |part| part.id.into()),
    TableColumn::new("machine", fields::MACHINE, |part| (&part.machine).into()),
    TableColumn::new("state", fields::STATE, |part| part.state.into()),
    TableColumn::new("copies", fields::COPIES, |part| part.owed.copies.into()),
    TableColumn::new("priority", fields::PRIORITY, |part| part.terms.priority.into()),
    TableColumn::new("due_at", fields::DUE, |part| GivenDate::of_terms(&part.terms).into()),
    TableColumn::new("order", fields::ORDER, |part| CellValue::Order(part.terms.order_name.clone())),
    TableColumn::new("name", fields::NAME, |part| part.full_name().into()),
    TableColumn::for_people("reason_or_warning", fields::REASON_OR_WARNING, reason_or_warning),
];

/// Parts of a build.
pub const BUILD_PART_COLUMNS: &[TableColumn<CountedPart>] = &[
    TableColumn::new("part", fields::PART, |row| row.part.id.into()),
    TableColumn::new("name", fields::NAME, |row| row.part.full_name().into()),
    TableColumn::new("order", fields::ORDER, |row| CellValue::Order(row.part.terms.order_name.clone())),
    TableColumn::new("state", fields::STATE, |row| row.part.state.into()),
    TableColumn::for_people("copies_here", fields::COPIES_HERE, |row| row.copies.into()),
    TableColumn::new("copies", fields::COPIES_OF, |row| row.part.owed.copies.into()),
    TableColumn::new("due_at", fields::DUE, |row| GivenDate::of_terms(&row.part.terms).into()),
    TableColumn::for_people("reason_or_warning", fields::REASON_OR_WARNING, |row| reason_or_warning(&row.part)),
];

/// Parts that an open build is made for, in waiting order.
pub const WAITING_PART_COLUMNS: &[TableColumn<CountedPart>] = &[
    TableColumn::new("part", fields::PART, |row| row.part.id.into()),
    TableColumn::new("name", fields::NAME, |row| row.part.full_name().into()),
    TableColumn::new("order", fields::ORDER, |row| CellValue::Order(row.part.terms.order_name.clone())),
    TableColumn::for_people("copies_waiting", fields::COPIES_WAITING, |row| row.copies.into()),
    TableColumn::new("copies", fields::COPIES_OF, |row| row.part.owed.copies.into()),
];

/// Parts of an order or a file name, with the builds that contain them.
pub const ORDERED_PART_COLUMNS: &[TableColumn<OrderedPart>] = &[
    TableColumn::new("part", fields::PART, |row| row.part.id.into()),
    TableColumn::new("name", fields::NAME, |row| row.part.full_name().into()),
    TableColumn::new("machine", fields::MACHINE, |row| (&row.part.machine).into()),
    TableColumn::new("state", fields::STATE, |row| row.part.state.into()),
    TableColumn::new("wanted", fields::COPIES_WANTED, |row| row.copies.wanted.into()),
    TableColumn::new("waiting", fields::COPIES_WAITING, |row| row.copies.waiting.into()),
    TableColumn::new("in_builds", fields::COPIES_IN_BUILDS, |row| row.copies.in_builds.into()),
    TableColumn::new("printed", fields::COPIES_PRINTED, |row| row.copies.printed.into()),
    TableColumn::new("good", fields::COPIES_GOOD, |row| row.copies.good.into()),
    TableColumn::new("refused", fields::COPIES_REFUSED, |row| row.copies.refused.into()),
    TableColumn::new("bad", fields::COPIES_BAD, |row| row.copies.bad.into()),
    TableColumn::new("cancelled", fields::COPIES_CANCELLED, |row| row.copies.cancelled.into()),
    TableColumn::new("due_at", fields::DUE, |row| GivenDate::of_terms(&row.part.terms).into()),
    TableColumn::for_people("where", fields::WHERE, where_or_why),
];

/// Parts of a build that may be known only from its file.
pub const CAKE_PART_COLUMNS: &[TableColumn<CakePart>] = &[
    TableColumn::new("name", fields::NAME, |part| (&part.name).into()),
    TableColumn::new("order", fields::ORDER, |part| (&part.order).into()),
    TableColumn::for_people("copies_here", fields::COPIES_HERE, |part| part.copies.len().into()),
    TableColumn::new("due", fields::DUE, |part| (&part.due).into()),
    TableColumn::new("note", fields::NOTE, |part| (&part.note).into()),
    TableColumn::new("reference", fields::REFERENCE, |part| (&part.reference).into()),
];

/// Copies of a part that are in builds.
pub const PLACEMENT_COLUMNS: &[TableColumn<PlacementRow>] = &[
    TableColumn::new("copy", fields::COPY, |placed| (placed.copy + 1).into()),
    TableColumn::new("build", fields::BUILD, |placed| CellValue::BuildWithPart(placed.build_id, placed.part_id)),
    TableColumn::new("build_state", fields::STATE, |placed| placed.build_state.into()),
    TableColumn::new("published_at", fields::PUBLISHED, |placed| placed.published_at.into()),
    TableColumn::for_people("origin_mm", fields::ORIGIN, origin),
];

/// Why a part was refused; otherwise what it waits for and its warnings.
fn reason_or_warning(part: &PartRow) -> CellValue {
    if !part.refused.reason.is_empty() {
        return CellValue::Prose(part.refused.reason.replace('\n', "; "));
    }
    let asked = Some(part.owed.question.trim_end_matches('.')).filter(|asked| !asked.is_empty());
    // What is asked was a warning before.
    let warnings = part.told_warnings().filter(|line| asked.is_none() || intake::read_print_question(line).is_none());
    let texts = asked.map(|asked| format!("Waits for a yes: {asked}")).into_iter().chain(warnings.map(str::to_owned));
    CellValue::Prose(texts.collect::<Vec<_>>().join("; "))
}

fn where_or_why(row: &OrderedPart) -> CellValue {
    match row.part.refused.reason.as_str() {
        "" => whereabouts(&row.placements).into(),
        reason => CellValue::Prose(reason.to_owned()),
    }
}

/// `2 in build 3 (published), 1 in build 4 (nesting)`.
pub fn whereabouts(placements: &[PlacementRow]) -> String {
    let mut builds: BTreeMap<(BuildId, String), u32> = BTreeMap::new();
    for placement in placements {
        let state = match placement {
            placement if placement.is_withdrawn => "withdrawn".to_owned(),
            placement if placement.is_bad => "bad".to_owned(),
            placement => placement.build_state.to_string(),
        };
        *builds.entry((placement.build_id, state)).or_default() += 1;
    }
    let texts: Vec<String> = builds.iter().map(|((id, state), n)| format!("{n} in build {id} ({state})")).collect();
    if texts.is_empty() { "none in a build".to_owned() } else { texts.join(", ") }
}

fn origin(placed: &PlacementRow) -> CellValue {
    let Some(pose) = placed.pose() else { return CellValue::Text("not placed yet".to_owned()) };
    let number = |mm: f64| fields::ORIGIN.plain_text(&mm.into()).unwrap_or_default();
    let [x, y, z] = pose.translation.to_array().map(number);
    format!("{x}, {y}, {z}").into()
}
