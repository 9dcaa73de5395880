//! What orders bear of builds: the lines of an invoice, and the shares that they are made of.

use farm::{CostShare, OrderCost};
use language::say;

use crate::tables::{CellValue, columns::table_column::TableColumn, fields};

/// The columns of what orders bear.
pub const ORDER_COST_COLUMNS: &[TableColumn<OrderCost>] = &[
    TableColumn::new("order_name", fields::ORDER, |row| CellValue::Order(row.order_name.clone())),
    TableColumn::new("customer", fields::CUSTOMER.unless_zero(), |row| known(&row.customer)),
    TableColumn::new("material", fields::MATERIAL.unless_zero(), |row| known(&row.material)),
    TableColumn::for_programs("is_bad", fields::NOTE, |row| row.is_bad.to_string().into()),
    TableColumn::new("builds", fields::BUILDS, |row| row.builds.into()),
    TableColumn::new("copies", fields::COPIES, |row| row.copies.into()),
    TableColumn::new("part_litres", fields::PART_LITRES, |row| row.part_litres.into()),
    TableColumn::new("print_hours", fields::PRINT_HOURS, |row| row.print_hours.into()),
    TableColumn::new("powder_kg", fields::POWDER.unless_zero(), |row| row.powder_kg.into()),
    TableColumn::new("price", fields::PRICE, |row| row.price.amount().into()),
    TableColumn::new("currency", fields::CURRENCY, |row| (&row.currency).into()),
    TableColumn::for_people("note", fields::NOTE.unless_zero(), |row| bad_note(row.is_bad)),
];

/// Columns of costs that are left out on a narrow terminal, the first of them first.
pub const LEAST_COST_COLUMNS: &[&str] =
    &["powder_kg", "part_litres", "material", "published_at", "print_hours", "copies"];

/// The columns of what orders bear of each build.
pub const COST_SHARE_COLUMNS: &[TableColumn<CostShare>] = &[
    TableColumn::new("build", fields::BUILD, |row| row.build.into()),
    TableColumn::new("published_at", fields::PUBLISHED, |row| row.published_at.into()),
    TableColumn::new("machine", fields::MACHINE, |row| (&row.machine).into()),
    TableColumn::new("material", fields::MATERIAL.unless_zero(), |row| known(&row.material)),
    TableColumn::new("order_name", fields::ORDER, |row| CellValue::Order(row.order_name.clone())),
    TableColumn::new("customer", fields::CUSTOMER.unless_zero(), |row| known(&row.customer)),
    TableColumn::for_programs("is_bad", fields::NOTE, |row| row.is_bad.to_string().into()),
    TableColumn::new("copies", fields::COPIES, |row| row.copies.into()),
    TableColumn::new("part_litres", fields::PART_LITRES, |row| row.part_litres.into()),
    TableColumn::new("print_hours", fields::PRINT_HOURS, |row| row.print_hours.into()),
    TableColumn::new("powder_kg", fields::POWDER.unless_zero(), |row| row.powder_kg.into()),
    TableColumn::new("price", fields::PRICE, |row| row.price.amount().into()),
    TableColumn::new("currency", fields::CURRENCY, |row| (&row.currency).into()),
    TableColumn::for_people("note", fields::NOTE.unless_zero(), |row| bad_note(row.is_bad)),
];

/// Why an order does not bear copies that are listed with it.
fn bad_note(is_bad: bool) -> CellValue {
    is_bad.then(|| say!("farm-bears-bad-copies")).into()
}

/// A text; nothing if it is empty.
fn known(text: &str) -> CellValue {
    Some(text).filter(|text| !text.is_empty()).into()
}
