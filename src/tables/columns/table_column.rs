//! A column of a table: its key in JSON and CSV, its field, and its value in a row.

use std::fmt;

use build_file::csv_cell;

use super::{cell_value::CellValue, field_definition::FieldDefinition};

/// A column of a table whose rows are of type `Row`.
pub struct TableColumn<Row> {
    /// Its name in JSON and CSV.
    pub key: &'static str,
    /// Its label, unit and number format.
    pub field: FieldDefinition,
    /// Returns its value in a row.
    pub value: fn(&Row) -> CellValue,
    /// Who sees it.
    pub audience: ColumnAudience,
}

/// Who sees a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnAudience {
    /// Both people and programs.
    Everyone,
    /// People only, in terminals and on pages. Programs see the fields that the column is computed from.
    People,
    /// Programs only, in JSON and CSV.
    Programs,
}

impl<Row> TableColumn<Row> {
    /// A column that everyone sees.
    pub const fn new(key: &'static str, field: FieldDefinition, value: fn(&Row) -> CellValue) -> Self {
        Self { key, field, value, audience: ColumnAudience::Everyone }
    }

    /// A column that only people see. Programs see the fields that it is computed from.
    pub const fn for_people(key: &'static str, field: FieldDefinition, value: fn(&Row) -> CellValue) -> Self {
        Self { key, field, value, audience: ColumnAudience::People }
    }

    /// A column that only programs see, in JSON and CSV.
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

/// The columns that people see of these rows: not those of counts in which all is 0.
pub fn people_columns<'c, Row>(columns: &'c [TableColumn<Row>], rows: &[Row]) -> Vec<&'c TableColumn<Row>> {
    let is_nothing = |value: CellValue| matches!(value, CellValue::Missing | CellValue::Whole(0));
    let is_zero = |column: &TableColumn<Row>| rows.iter().all(|row| is_nothing((column.value)(row)));
    for_people(columns).filter(|column| !(column.field.is_hidden_where_zero && is_zero(column))).collect()
}

/// Writes rows as CSV for spreadsheets, with a heading and every column that programs see. Texts are escaped so that
/// a spreadsheet does not run them as formulas. Numbers stay numbers.
///
/// # Errors
/// If a value cannot be written as a cell. No `CellValue` causes this error.
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

/// Escapes a value so that a spreadsheet does not interpret it as a formula.
fn harmless(value: CellValue) -> CellValue {
    match value {
        CellValue::Text(text) => CellValue::Text(csv_cell(&text)),
        CellValue::Prose(text) => CellValue::Prose(csv_cell(&text)),
        CellValue::Order(name) => CellValue::Order(csv_cell(&name)),
        CellValue::NamedPart(part, name) => CellValue::NamedPart(part, csv_cell(&name)),
        other => other,
    }
}
