//! Typed row numbers, so a part number cannot be used as a build number.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::sql::{BindValue, ColumnKey, ColumnValue, SqlRow, SqlValue};

macro_rules! row_id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, schemars::JsonSchema)]
        #[serde(transparent)]
        #[schemars(inline)]
        pub struct $name(pub i64);

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }

        impl BindValue for $name {
            const NULL: SqlValue = i64::NULL;

            fn to_sql(&self) -> SqlValue {
                self.0.to_sql()
            }
        }

        impl ColumnValue for $name {
            fn read_nullable(row: &SqlRow, column: ColumnKey<'_>) -> Result<Option<Self>, sqlx::Error> {
                Ok(i64::read_nullable(row, column)?.map(Self))
            }
        }
    };
}

row_id! {
    /// Number of a part.
    PartId
}
row_id! {
    /// Number of a build.
    BuildId
}
row_id! {
    /// Number of a command.
    CommandId
}
