//! A column of a table: its key in JSON and CSV, its field, and the value that it takes from a row.

use std::fmt;

use build_file::csv_cell;

use super::{cell_value::CellValue, field_definition::FieldDefinition};

/// A column of a table whose rows are of type `Row`.
pub struct TableColumn<Row> {
    /// Its name in JSON and CSV.
    pub key: &'static str,
    /// Label, unit and how its values print.
    pub field: FieldDefinition,
    /// What it shows of a row.
    pub value: fn(&Row) -> CellValue,
    /// Who sees it.
    pub audience: ColumnAudience,
}

/// Who sees a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnAudience {
    /// People and programs.
    Everyone,
    /// People, in terminals and on pages; programs see the fields that it is made of.
    People,
    /// Programs, in JSON and CSV.
    Programs,
}

impl<Row> TableColumn<Row> {
    /// A column that everyone sees.
    pub const fn new(key: &'static str, field: FieldDefinition, value: fn(&Row) -> CellValue) -> Self {
        Self { key, field, value, audience: ColumnAudience::Everyone }
    }

    /// A column that people see; programs see the fields that it is made of.
    pub const fn for_people(key: &'static str, field: FieldDefinition, value: fn(&Row) -> CellValue) -> Self {
        Self { key, field, value, audience: ColumnAudience::People }
    }

    /// A column that stands in JSON and CSV alone.
    pub const fn for_programs(key: &'static str, field: FieldDefinition, value: fn(&Row) -> CellValue) -> Self {
        Self { key, field, value, audience: ColumnAudience::Programs }
    }
}

impl<Row> fmt::Debug for TableColumn<Row> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TableColumn").field("key", &self.key).field("field", &self.field).finish_non_exhaustive()
    }
}

/// The columns that people see.
pub fn for_people<Row>(columns: &[TableColumn<Row>]) -> impl Iterator<Item = &TableColumn<Row>> + Clone {
    columns.iter().filter(|column| column.audience != ColumnAudience::Programs)
}

/// Rows as CSV for spreadsheets, every column that programs see, with a heading. Texts are no formulas; numbers stay numbers.
///
/// # Errors
/// When a value cannot be written as a cell, which none of them is.
pub fn csv_of<Row>(columns: &[TableColumn<Row>], rows: &[Row]) -> Result<String, csv::Error> {
    let columns: Vec<_> = columns.iter().filter(|column| column.audience != ColumnAudience::People).collect();
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.write_record(columns.iter().map(|column| column.key))?;
    for row in rows {
        let cells: Vec<CellValue> = columns.iter().map(|column| harmless((column.value)(row))).collect();
        writer.serialize(cells)?;
    }
    let bytes = writer.into_inner().map_err(|error| error.into_error())?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// A value that no spreadsheet takes for a formula.
fn harmless(value: CellValue) -> CellValue {
    match value {
        CellValue::Text(text) => CellValue::Text(csv_cell(&text)),
        CellValue::Prose(text) => CellValue::Prose(csv_cell(&text)),
        CellValue::NamedPart(part, name) => CellValue::NamedPart(part, csv_cell(&name)),
        other => other,
    }
}
