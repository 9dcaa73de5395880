//! Values that are read from the columns of a row.

use sqlx::{Error, error::BoxDynError};

use super::SqlRow;

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
        impl $crate::ledger::sql::ColumnValue for $type {
            fn read_nullable(
                row: &$crate::ledger::sql::SqlRow,
                column: $crate::ledger::sql::ColumnKey<'_>,
            ) -> Result<Option<Self>, sqlx::Error> {
                row.text(column)?.map(|text| $parse(&text).map_err(|e| column.invalid(e))).transpose()
            }
        }
    };
}

pub(in crate::ledger) use read_text_by;
