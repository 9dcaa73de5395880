//! Rows that a statement returns, and the values of their columns.

use sqlx::{
    Column, ColumnIndex, Database, Decode, Error, Row, Type, TypeInfo, ValueRef, error::BoxDynError, sqlite::SqliteRow,
};

use super::SqlValue;

/// A row of one of the two databases.
pub enum SqlRow {
    /// Of SQLite.
    Sqlite(SqliteRow),
    /// Of PostgreSQL.
    Postgres(sqlx::postgres::PgRow),
}

macro_rules! column_reader {
    ($(#[$doc:meta])* $reader:ident, $type:ty) => {
        $(#[$doc])*
        pub fn $reader(&self, column: ColumnKey<'_>) -> Result<Option<$type>, Error> {
            match (self, column) {
                (Self::Sqlite(row), ColumnKey::Name(name)) => row.try_get(name),
                (Self::Sqlite(row), ColumnKey::Place(place)) => row.try_get(place),
                (Self::Postgres(row), ColumnKey::Name(name)) => row.try_get(name),
                (Self::Postgres(row), ColumnKey::Place(place)) => row.try_get(place),
            }
        }
    };
}

impl SqlRow {
    column_reader! {
        /// Reads a whole number.
        integer, i64
    }
    column_reader! {
        /// Reads a floating-point number.
        real, f64
    }
    column_reader! {
        /// Reads true or false.
        flag, bool
    }
    column_reader! {
        /// Reads a text.
        text, String
    }

    /// All columns with their names, whatever they are.
    pub fn values(&self) -> Result<DynamicRow, Error> {
        match self {
            Self::Sqlite(row) => read_values(row),
            Self::Postgres(row) => read_values(row),
        }
    }

    /// Reads the column with this name.
    pub fn column<T: ColumnValue>(&self, name: &str) -> Result<T, Error> {
        T::read(self, ColumnKey::Name(name))
    }
}

fn read_values<'r, R: Row>(row: &'r R) -> Result<DynamicRow, Error>
where
    usize: ColumnIndex<R>,
    i64: Decode<'r, R::Database> + Type<R::Database>,
    f64: Decode<'r, R::Database> + Type<R::Database>,
    bool: Decode<'r, R::Database> + Type<R::Database>,
    String: Decode<'r, R::Database> + Type<R::Database>,
{
    let read = |column: &<R::Database as Database>::Column| -> Result<SqlValue, Error> {
        let place = column.ordinal();
        let kind = row.try_get_raw(place)?.type_info().name().to_owned();
        Ok(match kind.as_str() {
            "INTEGER" | "INT8" | "INT4" => SqlValue::Integer(row.try_get(place)?),
            "REAL" | "FLOAT8" => SqlValue::Real(row.try_get(place)?),
            "BOOLEAN" | "BOOL" => SqlValue::Flag(row.try_get(place)?),
            _ => SqlValue::Text(row.try_get(place)?),
        })
    };
    row.columns().iter().map(|column| Ok((column.name().to_owned(), read(column)?))).collect()
}

/// A row with its columns by name, whatever they are.
pub type DynamicRow = Vec<(String, SqlValue)>;

/// A Rust type that a whole row can be read as.
pub trait FromSqlRow: Sized {
    /// Reads the row.
    fn from_sql_row(row: &SqlRow) -> Result<Self, Error>;
}

/// A row that names the columns it is read from. A statement that names them keeps its result when a newer nestd adds columns.
pub trait NamedColumns: FromSqlRow {
    /// Adds the names of the columns.
    fn add_columns(names: &mut Vec<&'static str>);
}

/// Adds the columns of a group, which a row gives.
pub fn add_group<R, G: NamedColumns>(names: &mut Vec<&'static str>, _: fn(&R) -> &G) {
    G::add_columns(names);
}

/// Implements [`FromSqlRow`] and [`NamedColumns`] for a struct by the names of its fields: those before the semicolon are columns, those after
/// it are groups of columns of the same row. `field = "column"` names a column that differs from its field.
macro_rules! sql_row {
    ($type:ty { $($field:ident $(= $name:literal)?),* $(,)? $(; $($group:ident),+ $(,)?)? }) => {
        impl $crate::base::sql::FromSqlRow for $type {
            fn from_sql_row(row: &$crate::base::sql::SqlRow) -> Result<Self, sqlx::Error> {
                Ok(Self {
                    $($field: row.column($crate::base::sql::column_name!($field $($name)?))?,)*
                    $($($group: $crate::base::sql::FromSqlRow::from_sql_row(row)?,)+)?
                })
            }
        }

        impl $crate::base::sql::NamedColumns for $type {
            fn add_columns(names: &mut Vec<&'static str>) {
                $(names.push($crate::base::sql::column_name!($field $($name)?));)*
                $($($crate::base::sql::add_group(names, |row: &Self| &row.$group);)+)?
            }
        }
    };
}

macro_rules! column_name {
    ($field:ident) => {
        stringify!($field)
    };
    ($field:ident $name:literal) => {
        $name
    };
}

pub(crate) use {column_name, sql_row};

macro_rules! tuple_row {
    ($($type:ident $place:literal),+) => {
        impl<$($type: ColumnValue),+> FromSqlRow for ($($type,)+) {
            fn from_sql_row(row: &SqlRow) -> Result<Self, Error> {
                Ok(($($type::read(row, ColumnKey::Place($place))?,)+))
            }
        }
    };
}

tuple_row!(A 0);
tuple_row!(A 0, B 1);
tuple_row!(A 0, B 1, C 2);
tuple_row!(A 0, B 1, C 2, D 3);
tuple_row!(A 0, B 1, C 2, D 3, E 4);

/// A column of a row: by its name, or by its place from 0.
#[derive(Debug, Clone, Copy)]
pub enum ColumnKey<'a> {
    /// By name.
    Name(&'a str),
    /// By place.
    Place(usize),
}

impl ColumnKey<'_> {
    /// The error that the value of this column is not what it should be.
    pub fn invalid(self, source: impl Into<BoxDynError>) -> Error {
        let index = match self {
            Self::Name(name) => name.to_owned(),
            Self::Place(place) => place.to_string(),
        };
        Error::ColumnDecode { index, source: source.into() }
    }
}

/// A Rust type that a column can be read as.
pub trait ColumnValue: Sized {
    /// Reads the column. `None` = NULL.
    fn read_nullable(row: &SqlRow, column: ColumnKey<'_>) -> Result<Option<Self>, Error>;

    /// Reads the column. NULL is an error, unless the type has a place for it.
    fn read(row: &SqlRow, column: ColumnKey<'_>) -> Result<Self, Error> {
        Self::read_nullable(row, column)?.ok_or_else(|| column.invalid("it is NULL"))
    }
}

impl<T: ColumnValue> ColumnValue for Option<T> {
    fn read_nullable(row: &SqlRow, column: ColumnKey<'_>) -> Result<Option<Self>, Error> {
        Ok(Some(T::read_nullable(row, column)?))
    }
}

macro_rules! read_by {
    ($reader:ident, $($type:ty),+) => {
        $(impl ColumnValue for $type {
            fn read_nullable(row: &SqlRow, column: ColumnKey<'_>) -> Result<Option<Self>, Error> {
                row.$reader(column)
            }
        })+
    };
}

macro_rules! read_integer {
    ($($type:ty),+) => {
        $(impl ColumnValue for $type {
            fn read_nullable(row: &SqlRow, column: ColumnKey<'_>) -> Result<Option<Self>, Error> {
                row.integer(column)?.map(|value| value.try_into().map_err(|e| column.invalid(e))).transpose()
            }
        })+
    };
}

read_by!(integer, i64);
read_by!(real, f64);
read_by!(flag, bool);
read_by!(text, String);
read_integer!(u8, u32, u64);

/// Implements [`ColumnValue`] for a type by a function that parses the column's text.
macro_rules! read_text_by {
    ($type:ty, $parse:expr) => {
        impl $crate::base::sql::ColumnValue for $type {
            fn read_nullable(
                row: &$crate::base::sql::SqlRow,
                column: $crate::base::sql::ColumnKey<'_>,
            ) -> Result<Option<Self>, sqlx::Error> {
                row.text(column)?.map(|text| $parse(&text).map_err(|e| column.invalid(e))).transpose()
            }
        }
    };
}

pub(crate) use read_text_by;
