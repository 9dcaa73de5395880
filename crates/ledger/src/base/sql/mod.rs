//! Statements that run on SQLite and on PostgreSQL alike. Parameters are written `$1`, `$2`, .., which both read. The
//! connections, the driver's protocol and the pools are sqlx's.

mod catalog;
mod connection;
mod query;
mod row;
mod value;

pub(crate) use catalog::{
    column_types, last_number, number_from_highest, set_last_number, skip_numbers, table_columns,
};
pub(crate) use connection::{SqlExecutor, SqlTransaction, allow_whole_ledger, answered_within};
pub(crate) use query::{TypedQuery, query, query_as, query_scalar, query_whole_rows, select_as};
pub(crate) use row::{
    ColumnKey, ColumnValue, DynamicRow, FromSqlRow, NamedColumns, SqlRow, add_group, column_name, read_text_by, sql_row,
};
pub(crate) use value::{BindValue, ColumnHolds, SqlValue, bind_as_text};
