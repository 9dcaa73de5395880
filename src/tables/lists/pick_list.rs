//! The copies of a build in the order in which they are removed from the cake.

use language::say;
use ledger::PartId;
use schemars::JsonSchema;
use serde::Serialize;

use crate::tables::{
    columns::{cell_value::CellValue, table_column::TableColumn},
    fields,
};

/// A removal direction is a unit vector. Components smaller than this are not mentioned in its text.
const SLIGHT: f64 = 0.2;

/// The copies of a build in the order in which they are removed from the cake.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PickList {
    /// Number of the build.
    pub build: i64,
    /// Whether the order is proved on the triangles: each copy can be removed along a straight line without touching
    /// the copies after it in the list. If not, the copies are listed from top to bottom.
    pub is_proved: bool,
    /// The copies, in the order of removal.
    pub copies: Vec<PickedCopy>,
}

/// A copy to remove from the cake.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "Picked")]
pub struct PickedCopy {
    /// Its position in the list, from 1, as on the printed map.
    pub number: usize,
    /// Number of the part.
    pub part: i64,
    /// Its file name as dropped, with the name of its solid.
    pub name: String,
    /// Name of the order or kit; empty = none.
    pub order: String,
    /// When it is due, as people read it: the day that was given, or the time in the farm's zone; empty = no date.
    pub due: String,
    /// Finishing steps after the print; empty = none.
    pub finish: String,
    /// The customer's note; empty = none.
    pub note: String,
    /// What the customer's own system calls the line; empty = not said.
    pub reference: String,
    /// Number of the copy, from 1.
    pub copy: u32,
    /// Its highest point above the floor, mm; null if its original file is no longer kept.
    pub top_mm: Option<f64>,
    /// Its lowest point above the floor, mm.
    pub bottom_mm: Option<f64>,
    /// Distance of the center of its bounds from the left side, mm.
    pub center_x_mm: Option<f64>,
    /// Distance of the center of its bounds from the front, mm.
    pub center_y_mm: Option<f64>,
    /// Direction in which it is removed: a unit vector in the machine's frame; null if the order is not proved.
    #[serde(rename = "way")]
    pub direction: Option<[f64; 3]>,
}

/// The columns of a pick list. Without a proved order the removal direction is empty.
pub const PICK_COLUMNS: &[TableColumn<PickedCopy>] = &[
    TableColumn::new("number", fields::PICK_NUMBER, |copy| copy.number.into()),
    TableColumn::new("top_mm", fields::TOP, |copy| copy.top_mm.into()),
    TableColumn::new("bottom_mm", fields::BOTTOM, |copy| copy.bottom_mm.into()),
    TableColumn::new("center_x_mm", fields::CENTER_X, |copy| copy.center_x_mm.into()),
    TableColumn::new("center_y_mm", fields::CENTER_Y, |copy| copy.center_y_mm.into()),
    TableColumn::new("way", fields::REMOVAL_DIRECTION, |copy| copy.direction.map(removal_in_words).into()),
    TableColumn::new("name", fields::PART_NAME, |copy| CellValue::NamedPart(PartId(copy.part), copy.name.clone())),
    TableColumn::new("order", fields::ORDER, |copy| (&copy.order).into()),
    TableColumn::new("copy", fields::COPY, |copy| copy.copy.into()),
    TableColumn::new("due", fields::DUE, |copy| (&copy.due).into()),
    TableColumn::new("finish", fields::FINISH, |copy| (&copy.finish).into()),
    TableColumn::new("note", fields::NOTE, |copy| (&copy.note).into()),
    TableColumn::new("reference", fields::REFERENCE, |copy| (&copy.reference).into()),
];

/// Whether a removal direction points down, through the floor of the cake.
pub fn points_down(direction: [f64; 3]) -> bool {
    direction[2] < -SLIGHT
}

/// A removal direction in words, such as `up, left`.
pub fn removal_in_words([x, y, z]: [f64; 3]) -> String {
    let side = |value: f64, towards: String, away: String| match value {
        value if value > SLIGHT => Some(towards),
        value if value < -SLIGHT => Some(away),
        _ => None,
    };
    let sides = [
        side(z, say!("way-up"), say!("way-down")),
        side(x, say!("way-right"), say!("way-left")),
        side(y, say!("way-back"), say!("way-front")),
    ];
    language::join_names(sides.into_iter().flatten())
}
