//! Orders with the sums over their lines.

use super::{fields, table_column::TableColumn};
use crate::ledger::OrderSummary;

/// Orders, with what became of their copies.
pub const ORDER_COLUMNS: &[TableColumn<OrderSummary>] = &[
    TableColumn::new("name", fields::ORDER, |order| (&order.order.name).into()),
    TableColumn::new("state", fields::STATE, |order| order.order.state.into()),
    TableColumn::new("lines", fields::LINES, |order| order.lines.into()),
    TableColumn::new("wanted", fields::COPIES_WANTED, |order| order.copies.wanted.into()),
    TableColumn::new("waiting", fields::COPIES_WAITING, |order| order.copies.waiting.into()),
    TableColumn::new("in_builds", fields::COPIES_IN_BUILDS, |order| order.copies.in_builds.into()),
    TableColumn::new("printed", fields::COPIES_PRINTED, |order| order.copies.printed.into()),
    TableColumn::new("good", fields::COPIES_GOOD, |order| order.copies.good.into()),
    TableColumn::new("refused", fields::COPIES_REFUSED, |order| order.copies.refused.into()),
    TableColumn::new("bad", fields::COPIES_BAD, |order| order.copies.bad.into()),
    TableColumn::new("cancelled", fields::COPIES_CANCELLED, |order| order.copies.cancelled.into()),
    TableColumn::new("due_at", fields::DUE, |order| order.due_at.into()),
    TableColumn::new("opened_at", fields::OPENED, |order| order.order.opened_at.into()),
];
