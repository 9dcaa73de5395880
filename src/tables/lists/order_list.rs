//! Orders with the sums over their lines, the lines of an order, and the builds that hold their copies.

use std::collections::BTreeMap;

use ledger::{BuildId, BuildState, OrderLine, PartId, PlacementRow, UtcTimestamp};
use schemars::JsonSchema;
use serde::Serialize;

use crate::{
    farm::DatedOrder,
    tables::{
        columns::{cell_value::CellValue, table_column::TableColumn, time_view::GivenDate},
        fields,
    },
};

/// Orders, with what became of their copies.
pub const ORDER_COLUMNS: &[TableColumn<DatedOrder>] = &[
    TableColumn::new("name", fields::ORDER, |order| CellValue::Order(order.order.order.name.clone())),
    TableColumn::new("state", fields::STATE, |order| order.order.order.state.into()),
    TableColumn::new("lines", fields::LINES, |order| order.order.lines.into()),
    TableColumn::new("wanted", fields::COPIES_WANTED, |order| order.order.copies.wanted.into()),
    TableColumn::new("waiting", fields::COPIES_WAITING, |order| order.order.copies.waiting.into()),
    TableColumn::new("in_builds", fields::COPIES_IN_BUILDS, |order| order.order.copies.in_builds.into()),
    TableColumn::new("printed", fields::COPIES_PRINTED, |order| order.order.copies.printed.into()),
    TableColumn::new("good", fields::COPIES_GOOD, |order| order.order.copies.good.into()),
    TableColumn::new("refused", fields::COPIES_REFUSED, |order| order.order.copies.refused.into()),
    TableColumn::new("bad", fields::COPIES_BAD, |order| order.order.copies.bad.into()),
    TableColumn::new("cancelled", fields::COPIES_CANCELLED, |order| order.order.copies.cancelled.into()),
    TableColumn::new("due_at", fields::DUE, |order| GivenDate::new(order.order.due_at, &order.order.due_text).into()),
    TableColumn::new("done_at", fields::UNPACKED, |order| order.fact.done_at.into()),
    TableColumn::for_people("risk", fields::RISK, |order| order.fact.risk_word().map(str::to_owned).into()),
    TableColumn::new("opened_at", fields::OPENED, |order| order.order.order.opened_at.into()),
];

/// Lines of an order, with what became of their copies.
pub const ORDER_LINE_COLUMNS: &[TableColumn<OrderLine>] = &[
    TableColumn::new("part", fields::PART, |line| line.part.into()),
    TableColumn::new("name", fields::NAME, |line| CellValue::NamedPart(line.part, line.full_name())),
    TableColumn::new("machine", fields::MACHINE, |line| (&line.machine).into()),
    TableColumn::new("state", fields::STATE, |line| line.state.into()),
    TableColumn::new("wanted", fields::COPIES_WANTED, |line| line.copies.wanted.into()),
    TableColumn::new("waiting", fields::COPIES_WAITING, |line| line.copies.waiting.into()),
    TableColumn::new("in_builds", fields::COPIES_IN_BUILDS, |line| line.copies.in_builds.into()),
    TableColumn::new("printed", fields::COPIES_PRINTED, |line| line.copies.printed.into()),
    TableColumn::new("good", fields::COPIES_GOOD, |line| line.copies.good.into()),
    TableColumn::new("bad", fields::COPIES_BAD, |line| line.copies.bad.into()),
    TableColumn::new("cancelled", fields::COPIES_CANCELLED, |line| line.copies.cancelled.into()),
    TableColumn::new("refused", fields::COPIES_REFUSED, |line| line.copies.refused.into()),
    TableColumn::new("due_at", fields::DUE, |line| GivenDate::new(line.due_at, &line.due_text).into()),
];

/// Copies of a part in one build.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct BuiltCopies {
    /// Number of the build.
    pub build: BuildId,
    /// State of the build.
    pub build_state: BuildState,
    /// When the build file was placed in the queue.
    pub published_at: Option<UtcTimestamp>,
    /// Number of the part.
    pub part: PartId,
    /// File name of the part, with the name of its solid.
    pub name: String,
    /// Copies in it that count.
    pub copies: u32,
    /// Copies in it that were printed badly.
    pub bad: u32,
}

/// Builds that hold copies of an order.
pub const ORDER_BUILD_COLUMNS: &[TableColumn<BuiltCopies>] = &[
    TableColumn::new("build", fields::BUILD, |row| CellValue::BuildWithPart(row.build, row.part)),
    TableColumn::new("build_state", fields::STATE, |row| row.build_state.into()),
    TableColumn::new("published_at", fields::PUBLISHED, |row| row.published_at.into()),
    TableColumn::new("part", fields::PART, |row| row.part.into()),
    TableColumn::new("name", fields::NAME, |row| CellValue::NamedPart(row.part, row.name.clone())),
    TableColumn::new("copies", fields::COPIES, |row| row.copies.into()),
    TableColumn::new("bad", fields::COPIES_BAD, |row| row.bad.into()),
];

impl BuiltCopies {
    /// The builds that hold copies of a line and were not taken back out of the queue, oldest first.
    pub fn of_line(line: &OrderLine, placements: &[PlacementRow]) -> Vec<Self> {
        let mut builds: BTreeMap<i64, Self> = BTreeMap::new();
        for placed in placements.iter().filter(|placed| !placed.is_withdrawn) {
            let counted = builds.entry(placed.build_id.0).or_insert_with(|| Self {
                build: placed.build_id,
                build_state: placed.build_state,
                published_at: placed.published_at,
                part: line.part,
                name: line.full_name(),
                copies: 0,
                bad: 0,
            });
            *(if placed.is_bad { &mut counted.bad } else { &mut counted.copies }) += 1;
        }
        builds.into_values().collect()
    }
}
