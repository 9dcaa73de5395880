//! Orders with the sums over their lines, the lines of an order, and the builds that hold their copies.

use std::collections::BTreeMap;

use farm::{BuildFact, DatedOrder, MachinePlan, build_of_copy, counted_words};
use language::say;
use ledger::{BuildId, BuildState, LineCopies, OrderLine, OrderRow, OrderSummary, PartId, PlacementRow, UtcTimestamp};
use schemars::JsonSchema;
use serde::Serialize;

use crate::tables::{
    columns::{
        cell_value::CellValue,
        table_column::TableColumn,
        time_view::{GivenDate, PromisedDate, TimeView},
    },
    fields,
};

/// Orders, with what became of their copies.
pub const ORDER_COLUMNS: &[TableColumn<DatedOrder>] = &[
    TableColumn::new("name", fields::ORDER, |order| CellValue::Order(order.order.order.name.clone())),
    TableColumn::new("customer", fields::CUSTOMER, |order| (&order.order.order.customer).into()),
    TableColumn::for_people("standing", fields::STATE, |order| CellValue::State(order.fact.word.word().to_owned())),
    TableColumn::for_programs("state", fields::LEDGER_STATE, |order| order.order.order.state.into()),
    TableColumn::for_programs("lines", fields::LINES, |order| order.order.lines.into()),
    TableColumn::for_programs("lines_without_number", fields::LINES, |order| order.order.lines_without_number.into()),
    TableColumn::for_programs("wanted", fields::COPIES_WANTED, |order| order.order.copies.wanted.into()),
    TableColumn::for_programs("waiting", fields::COPIES_WAITING, |order| order.order.copies.waiting.into()),
    TableColumn::for_programs("in_builds", fields::COPIES_IN_BUILDS, |order| order.order.copies.in_builds.into()),
    TableColumn::for_programs("queued", fields::COPIES_QUEUED, |order| order.order.copies.queued.into()),
    TableColumn::for_programs("printing", fields::COPIES_PRINTING, |order| order.order.copies.printing.into()),
    TableColumn::for_programs("printed", fields::COPIES_PRINTED, |order| order.order.copies.printed.into()),
    TableColumn::for_programs("good", fields::COPIES_GOOD, |order| order.order.copies.good.into()),
    TableColumn::for_programs("refused", fields::COPIES_REFUSED, |order| order.order.copies.refused.into()),
    TableColumn::for_programs("bad", fields::COPIES_BAD, |order| order.order.copies.bad.into()),
    TableColumn::for_programs("cancelled", fields::COPIES_CANCELLED, |order| order.order.copies.cancelled.into()),
    TableColumn::for_people("copies", fields::COPIES_NOW, |order| order_copies_text(&order.order).into()),
    TableColumn::new("due_at", fields::DUE, |order| GivenDate::new(order.order.due_at, &order.order.due_text).into()),
    TableColumn::for_people("done", fields::DONE, |order| PromisedDate::of_order(&order.fact).into()),
    TableColumn::for_programs("done_at", fields::UNPACKED, |order| order.fact.done_at.into()),
    TableColumn::for_programs("opened_at", fields::OPENED, |order| order.order.order.opened_at.into()),
];

/// Columns of orders that are left out on a narrow terminal, the first of them first.
pub const LEAST_ORDER_COLUMNS: &[&str] = &["due_at", "customer", "copies"];

/// Lines of an order, with what became of their copies.
pub const ORDER_LINE_COLUMNS: &[TableColumn<OrderLine>] = &[
    TableColumn::for_programs("part", fields::PART, |line| line.part.into()),
    TableColumn::new("name", fields::NAME, |line| CellValue::NamedPart(line.part, line.full_name())),
    TableColumn::new("machine", fields::MACHINE, |line| (&line.machine).into()),
    TableColumn::for_programs("state", fields::STATE, |line| line.state.into()),
    TableColumn::for_programs("wanted", fields::COPIES_WANTED, |line| line.copies.wanted.into()),
    TableColumn::for_programs("waiting", fields::COPIES_WAITING, |line| line.copies.waiting.into()),
    TableColumn::for_programs("in_builds", fields::COPIES_IN_BUILDS, |line| line.copies.in_builds.into()),
    TableColumn::for_programs("queued", fields::COPIES_QUEUED, |line| line.copies.queued.into()),
    TableColumn::for_programs("printing", fields::COPIES_PRINTING, |line| line.copies.printing.into()),
    TableColumn::for_programs("printed", fields::COPIES_PRINTED, |line| line.copies.printed.into()),
    TableColumn::for_programs("good", fields::COPIES_GOOD, |line| line.copies.good.into()),
    TableColumn::for_programs("bad", fields::COPIES_BAD, |line| line.copies.bad.into()),
    TableColumn::for_programs("cancelled", fields::COPIES_CANCELLED, |line| line.copies.cancelled.into()),
    TableColumn::for_programs("refused", fields::COPIES_REFUSED, |line| line.copies.refused.into()),
    TableColumn::for_people("copies", fields::COPIES_NOW, |line| {
        line_copies_text(line.is_number_known, &line.copies).into()
    }),
    TableColumn::new("due_at", fields::DUE, |line| GivenDate::new(line.due_at, &line.due_text).into()),
];

/// Copies of a part in one build.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct BuiltCopies {
    /// Number of the build.
    pub build: BuildId,
    /// State of the build.
    pub build_state: BuildState,
    /// How far it is.
    #[serde(flatten)]
    pub fact: BuildFact,
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
    TableColumn::for_programs("build_state", fields::LEDGER_STATE, |row| row.build_state.into()),
    TableColumn::new("state_word", fields::STATE, |row| CellValue::State(row.fact.word.clone())),
    TableColumn::new("ends_at", fields::UNPACKED, |row| CellValue::estimate(row.fact.ends_at)),
    TableColumn::for_programs("published_at", fields::PUBLISHED, |row| row.published_at.into()),
    TableColumn::for_programs("part", fields::PART, |row| row.part.into()),
    TableColumn::new("name", fields::NAME, |row| CellValue::NamedPart(row.part, row.name.clone())),
    TableColumn::new("copies", fields::COPIES, |row| row.copies.into()),
    TableColumn::new("bad", fields::COPIES_BAD, |row| row.bad.into()),
];

/// The columns of pages on which a row is a build, by their keys.
pub const BUILD_PAGE_KEYS: [&str; 5] = ["build", "state_word", "copies", "bad", "ends_at"];

impl BuiltCopies {
    /// A row for each build, with all its copies, oldest first. A row leads to its first part.
    pub fn by_build(rows: Vec<Self>) -> Vec<Self> {
        let mut builds: BTreeMap<i64, Self> = BTreeMap::new();
        for row in rows {
            let (copies, bad) = (row.copies, row.bad);
            let counted = builds.entry(row.build.0).or_insert(Self { copies: 0, bad: 0, ..row });
            counted.copies += copies;
            counted.bad += bad;
        }
        builds.into_values().collect()
    }

    /// The builds that hold copies of a line and were not taken back out of the queue, oldest first.
    pub fn of_line(line: &OrderLine, placements: &[PlacementRow], plans: &[MachinePlan]) -> Vec<Self> {
        let mut builds: BTreeMap<i64, Self> = BTreeMap::new();
        for placed in placements.iter().filter(|placed| !placed.is_withdrawn) {
            let counted = builds.entry(placed.build_id.0).or_insert_with(|| Self {
                build: placed.build_id,
                build_state: placed.build_state,
                fact: build_of_copy(placed, plans),
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

/// `2026-11-28 10:00 CET by ann@farm, with 44 of 48 copies`; `None` = nobody closed it.
pub fn closing_text(order: &OrderRow, view: &TimeView) -> Option<String> {
    let closing = &order.closing;
    let (at, by) = (closing.closed_at?, closing.closed_by.as_deref()?);
    let (accepted, all) = (closing.accepted_copies?, closing.closed_of?);
    Some(say!("closed-by", time = view.near_text(at), by = by, accepted = accepted, copies = all))
}

/// `40 of 48 good, 5 in the queue, 3 waiting`; of what there is nothing, nothing is said.
pub fn copies_text(copies: &LineCopies) -> String {
    let mut texts: Vec<String> = counted_words(copies).map(|(copies, word)| word.counted(copies)).collect();
    if let Some((first, word)) = counted_words(copies).next().filter(|(first, _)| *first < copies.wanted) {
        texts[0] = word.counted(say!("number-of", number = first, all = copies.wanted));
    }
    if texts.is_empty() { say!("no-copies") } else { language::join_names(texts) }
}

/// What became of the copies of a line; `not known (1 waiting)` where nobody said how many are wanted.
pub fn line_copies_text(is_number_known: bool, copies: &LineCopies) -> String {
    match is_number_known {
        true => copies_text(copies),
        false => say!("copies-not-known", copies = copies_text(copies)),
    }
}

/// What became of the copies of an order, and of how many lines nobody said how many are wanted.
pub fn order_copies_text(order: &OrderSummary) -> String {
    let unknown =
        (order.lines_without_number > 0).then(|| say!("lines-without-number", lines = order.lines_without_number));
    language::join_names([Some(copies_text(&order.copies)), unknown].into_iter().flatten())
}
