//! What a table or a sheet is made of: values, fields and columns with key, label, unit and format.

pub(super) mod cell_value;
pub(super) mod field_definition;
pub(super) mod table_column;
pub(super) mod time_view;
