//! The printers of the machines.

use crate::{
    farm::PrinterView,
    tables::{
        columns::{cell_value::CellValue, table_column::TableColumn},
        fields,
    },
};

/// The printers of a farm.
pub const PRINTER_COLUMNS: &[TableColumn<PrinterView>] = &[
    TableColumn::new("printer", fields::PRINTER, |row| (&row.printer).into()),
    TableColumn::new("machine", fields::MACHINE, |row| (&row.machine).into()),
    TableColumn::for_people("state", fields::STATE, |row| (if row.down.is_some() { "down" } else { "up" }).into()),
    TableColumn::new("builds", fields::BUILDS, |row| row.builds.into()),
    TableColumn::new("free_at", fields::FREE, |row| row.free_at.into()),
    TableColumn::for_people("down_at", fields::SINCE, |row| row.down.as_ref().map(|down| down.down_at).into()),
    TableColumn::for_people("told_by", fields::TOLD_BY, |row| row.down.as_ref().map(|down| &down.told_by).into()),
    TableColumn::for_people("reason", fields::REASON, |row| {
        row.down.as_ref().map_or(CellValue::Missing, |down| (&down.reason).into())
    }),
    TableColumn::for_people("times", fields::PRINT_TIMES, |row| row.times_text().into()),
];
