//! The printers of the machines.

use farm::PrinterFact;

use crate::tables::{
    columns::{cell_value::CellValue, table_column::TableColumn},
    fields,
};

/// The printers of a farm.
pub const PRINTER_COLUMNS: &[TableColumn<PrinterFact>] = &[
    TableColumn::new("printer", fields::PRINTER, |row| (&row.printer).into()),
    TableColumn::new("machine", fields::MACHINE, |row| (&row.machine).into()),
    TableColumn::new("state", fields::STATE, |row| CellValue::State(row.state.word().to_owned())),
    TableColumn::new("builds", fields::BUILDS, |row| row.builds.into()),
    TableColumn::new("free_at", fields::FREE, |row| match row.builds {
        0 => row.free_at.into(),
        _ => CellValue::estimate(row.free_at),
    }),
    TableColumn::for_people("doing", fields::NOW, |row| (&row.doing).into()),
    TableColumn::for_people("times", fields::PRINT_TIMES, |row| row.times_text().into()),
];
