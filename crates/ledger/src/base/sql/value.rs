//! Values that are bound to the parameters of a statement.

use serde_json::Value;

/// A value with its column type, which a NULL needs on PostgreSQL, too.
#[derive(Debug, Clone, PartialEq)]
pub enum SqlValue {
    /// A whole number.
    Integer(Option<i64>),
    /// A floating-point number.
    Real(Option<f64>),
    /// True or false: 1 or 0 on SQLite.
    Flag(Option<bool>),
    /// Text.
    Text(Option<String>),
}

/// What a column of a table holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnHolds {
    /// Whole numbers.
    Integer,
    /// Floating-point numbers.
    Real,
    /// True or false.
    Flag,
    /// Text.
    Text,
}

impl SqlValue {
    /// The value as a column of another database holds it: true is 1 on SQLite, and a NULL has a type on PostgreSQL.
    pub fn held_as(self, holds: ColumnHolds) -> Self {
        match (holds, self) {
            (ColumnHolds::Flag, Self::Integer(value)) => Self::Flag(value.map(|value| value != 0)),
            (ColumnHolds::Integer, Self::Flag(value)) => Self::Integer(value.map(i64::from)),
            (ColumnHolds::Integer, Self::Real(None) | Self::Text(None)) => Self::Integer(None),
            (ColumnHolds::Real, Self::Integer(None) | Self::Flag(None) | Self::Text(None)) => Self::Real(None),
            (ColumnHolds::Flag, Self::Real(None) | Self::Text(None)) => Self::Flag(None),
            (ColumnHolds::Text, Self::Integer(None) | Self::Real(None) | Self::Flag(None)) => Self::Text(None),
            (_, value) => value,
        }
    }

    /// The value as JSON.
    pub fn into_json(self) -> Value {
        match self {
            Self::Integer(value) => value.into(),
            Self::Real(value) => value.into(),
            Self::Flag(value) => value.into(),
            Self::Text(value) => value.into(),
        }
    }
}

/// A value of a row as JSON, which is not NULL.
impl BindValue for Value {
    const NULL: SqlValue = SqlValue::Text(None);

    fn to_sql(&self) -> SqlValue {
        match self {
            Self::Null => Self::NULL,
            Self::Bool(value) => SqlValue::Flag(Some(*value)),
            Self::Number(value) => match value.as_i64() {
                Some(whole) => SqlValue::Integer(Some(whole)),
                None => SqlValue::Real(value.as_f64()),
            },
            Self::String(text) => SqlValue::Text(Some(text.clone())),
            other => SqlValue::Text(Some(other.to_string())),
        }
    }
}

impl BindValue for SqlValue {
    const NULL: SqlValue = SqlValue::Text(None);

    fn to_sql(&self) -> SqlValue {
        self.clone()
    }
}

/// A Rust type that can be bound to a parameter.
pub trait BindValue {
    /// The NULL of this type.
    const NULL: SqlValue;

    /// The value to bind.
    fn to_sql(&self) -> SqlValue;
}

macro_rules! bind_as {
    ($kind:ident, $like:ty, $($type:ty),+) => {
        $(impl BindValue for $type {
            const NULL: SqlValue = SqlValue::$kind(None);

            fn to_sql(&self) -> SqlValue {
                SqlValue::$kind(Some(<$like>::from(*self)))
            }
        })+
    };
}

bind_as!(Integer, i64, i32, i64, u8, u32);
bind_as!(Real, f64, f64);
bind_as!(Flag, bool, bool);

/// Implements [`BindValue`] for a type by the text that [`ToString`] writes.
macro_rules! bind_as_text {
    ($($type:ty),+) => {
        $(impl $crate::base::sql::BindValue for $type {
            const NULL: $crate::base::sql::SqlValue = $crate::base::sql::SqlValue::Text(None);

            fn to_sql(&self) -> $crate::base::sql::SqlValue {
                $crate::base::sql::SqlValue::Text(Some(self.to_string()))
            }
        })+
    };
}

pub(crate) use bind_as_text;

bind_as_text!(str, String);

impl<T: BindValue + ?Sized> BindValue for &T {
    const NULL: SqlValue = T::NULL;

    fn to_sql(&self) -> SqlValue {
        (**self).to_sql()
    }
}

impl<T: BindValue> BindValue for Option<T> {
    const NULL: SqlValue = T::NULL;

    fn to_sql(&self) -> SqlValue {
        self.as_ref().map_or(T::NULL, BindValue::to_sql)
    }
}
