//! What orders bear of builds: the lines of an invoice, and the shares that they are made of.

use language::say;

use crate::{
    farm::{CostShare, OrderCost},
    tables::{CellValue, columns::table_column::TableColumn, fields},
};

/// The columns of what orders bear.
pub const ORDER_COST_COLUMNS: &[TableColumn<OrderCost>] = &[
    TableColumn::new("order_name", fields::ORDER, |row| CellValue::Order(row.order_name.clone())),
    TableColumn::new("customer", fields::CUSTOMER, |row| (&row.customer).into()),
    TableColumn::new("material", fields::MATERIAL, |row| (&row.material).into()),
    TableColumn::for_programs("is_bad", fields::NOTE, |row| row.is_bad.to_string().into()),
    TableColumn::new("builds", fields::BUILDS, |row| row.builds.into()),
    TableColumn::new("copies", fields::COPIES, |row| row.copies.into()),
    TableColumn::new("part_litres", fields::PART_LITRES, |row| row.part_litres.into()),
    TableColumn::new("print_hours", fields::PRINT_HOURS, |row| row.print_hours.into()),
    TableColumn::new("powder_kg", fields::POWDER, |row| row.powder_kg.into()),
    TableColumn::new("price", fields::PRICE, |row| row.price.amount().into()),
    TableColumn::new("currency", fields::CURRENCY, |row| (&row.currency).into()),
    TableColumn::for_people("note", fields::NOTE, |row| bad_note(row.is_bad).into()),
];

/// The columns of what orders bear of each build.
pub const COST_SHARE_COLUMNS: &[TableColumn<CostShare>] = &[
    TableColumn::new("build", fields::BUILD, |row| row.build.into()),
    TableColumn::new("published_at", fields::PUBLISHED, |row| row.published_at.into()),
    TableColumn::new("machine", fields::MACHINE, |row| (&row.machine).into()),
    TableColumn::new("material", fields::MATERIAL, |row| (&row.material).into()),
    TableColumn::new("order_name", fields::ORDER, |row| CellValue::Order(row.order_name.clone())),
    TableColumn::new("customer", fields::CUSTOMER, |row| (&row.customer).into()),
    TableColumn::for_programs("is_bad", fields::NOTE, |row| row.is_bad.to_string().into()),
    TableColumn::new("copies", fields::COPIES, |row| row.copies.into()),
    TableColumn::new("part_litres", fields::PART_LITRES, |row| row.part_litres.into()),
    TableColumn::new("print_hours", fields::PRINT_HOURS, |row| row.print_hours.into()),
    TableColumn::new("powder_kg", fields::POWDER, |row| row.powder_kg.into()),
    TableColumn::new("price", fields::PRICE, |row| row.price.amount().into()),
    TableColumn::new("currency", fields::CURRENCY, |row| (&row.currency).into()),
    TableColumn::for_people("note", fields::NOTE, |row| bad_note(row.is_bad).into()),
];

/// Why an order does not bear copies that are listed with it.
fn bad_note(is_bad: bool) -> String {
    if is_bad { say!("farm-bears-bad-copies") } else { String::new() }
}
