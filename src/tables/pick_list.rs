//! The copies of a build in the order in which they come out of the cake.

use schemars::JsonSchema;
use serde::Serialize;

use super::{cell_value::CellValue, fields, table_column::TableColumn as Column};
use crate::ledger::PartId;

/// A removal direction is a unit vector; components smaller than this are not put into words.
const SLIGHT: f64 = 0.2;

/// The copies of a build in the order in which they come out of the cake.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PickList {
    /// The build.
    pub build: i64,
    /// Whether it is proved on the triangles that each copy comes out on a straight line past all that are listed after it; else
    /// they are listed from the top down.
    pub is_proved: bool,
    /// The copies.
    pub copies: Vec<PickedCopy>,
}

/// A copy to take out of the cake.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "Picked")]
pub struct PickedCopy {
    /// Its place in the list, from 1, as on the printed map.
    pub number: usize,
    /// The part.
    pub part: i64,
    /// Its file name as dropped, with the name of its solid.
    pub name: String,
    /// Order or kit, empty = none.
    pub order: String,
    /// Its copy, from 1.
    pub copy: u32,
    /// Its highest point above the floor, mm; null when its original is no longer kept.
    pub top_mm: Option<f64>,
    /// Its lowest point above the floor, mm.
    pub bottom_mm: Option<f64>,
    /// Middle of its bounds from the left, mm.
    pub center_x_mm: Option<f64>,
    /// Middle of its bounds from the front, mm.
    pub center_y_mm: Option<f64>,
    /// Whereto it is drawn: a unit vector in the machine's frame; null where the order is not proved.
    pub way: Option<[f64; 3]>,
}

/// The list of a build; without a proved order nobody knows the way.
pub const PICK_COLUMNS: &[Column<PickedCopy>] = &[
    Column::new("number", fields::PICK_NUMBER, |copy| copy.number.into()),
    Column::new("top_mm", fields::TOP, |copy| copy.top_mm.into()),
    Column::new("bottom_mm", fields::BOTTOM, |copy| copy.bottom_mm.into()),
    Column::new("center_x_mm", fields::CENTER_X, |copy| copy.center_x_mm.into()),
    Column::new("center_y_mm", fields::CENTER_Y, |copy| copy.center_y_mm.into()),
    Column::new("way", fields::WAY, |copy| copy.way.map(way_in_words).into()),
    Column::new("name", fields::PART_NAME, |copy| CellValue::NamedPart(PartId(copy.part), copy.name.clone())),
    Column::new("order", fields::ORDER, |copy| (&copy.order).into()),
    Column::new("copy", fields::COPY, |copy| copy.copy.into()),
];

/// Whether a way goes down, through the floor of the cake.
pub fn goes_down(way: [f64; 3]) -> bool {
    way[2] < -SLIGHT
}

/// A direction in words, such as `up, left`.
fn way_in_words([x, y, z]: [f64; 3]) -> String {
    let side = |value: f64, towards: &'static str, away: &'static str| match value {
        value if value > SLIGHT => Some(towards),
        value if value < -SLIGHT => Some(away),
        _ => None,
    };
    let sides = [side(z, "up", "down"), side(x, "right", "left"), side(y, "back", "front")];
    sides.into_iter().flatten().collect::<Vec<_>>().join(", ")
}
