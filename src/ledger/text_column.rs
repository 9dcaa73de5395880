//! Stores enums as words in text columns. The words are those of serde, so there is no other list of them besides the
//! `CHECK` constraints.

/// Implements SQL encoding and [`Display`](std::fmt::Display) for an enum of the ledger by its serde word.
macro_rules! own_word {
    ($word:ty) => {
        impl sqlx::Type<sqlx::Sqlite> for $word {
            fn type_info() -> sqlx::sqlite::SqliteTypeInfo {
                <str as sqlx::Type<sqlx::Sqlite>>::type_info()
            }
        }

        impl<'r> sqlx::Decode<'r, sqlx::Sqlite> for $word {
            fn decode(value: sqlx::sqlite::SqliteValueRef<'r>) -> Result<Self, sqlx::error::BoxDynError> {
                $crate::ledger::text_column::parse_word(<&str as sqlx::Decode<sqlx::Sqlite>>::decode(value)?)
            }
        }

        impl sqlx::Encode<'_, sqlx::Sqlite> for $word {
            fn encode_by_ref(
                &self,
                buffer: &mut sqlx::sqlite::SqliteArgumentsBuffer,
            ) -> Result<sqlx::encode::IsNull, sqlx::error::BoxDynError> {
                let word = $crate::ledger::text_column::to_word(self)?;
                <String as sqlx::Encode<sqlx::Sqlite>>::encode(word, buffer)
            }
        }

        impl std::fmt::Display for $word {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                let word = $crate::ledger::text_column::to_word(self).map_err(|_| std::fmt::Error)?;
                f.pad(&word)
            }
        }
    };
}

pub(crate) use own_word;

use build_file::LengthUnit;
use nester::OrientationRule;
use serde::{Serialize, de::DeserializeOwned};
use serde_json::Value;
use sqlx::{
    Decode, Encode, Sqlite, Type,
    encode::IsNull,
    error::BoxDynError,
    sqlite::{SqliteArgumentsBuffer, SqliteTypeInfo, SqliteValueRef},
};

/// Wraps an enum of another crate for reading or writing a text column. The text is its serde word; `None` is NULL.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TextColumn<T>(pub T);

impl<T> Type<Sqlite> for TextColumn<T> {
    fn type_info() -> SqliteTypeInfo {
        <str as Type<Sqlite>>::type_info()
    }
}

impl<'r, T: DeserializeOwned> Decode<'r, Sqlite> for TextColumn<T> {
    fn decode(value: SqliteValueRef<'r>) -> Result<Self, BoxDynError> {
        let word = <Option<&str> as Decode<Sqlite>>::decode(value)?;
        let word = word.map_or(Value::Null, |word| Value::String(word.to_owned()));
        Ok(Self(serde_json::from_value(word)?))
    }
}

impl<T: Serialize> Encode<'_, Sqlite> for TextColumn<T> {
    fn encode_by_ref(&self, buffer: &mut SqliteArgumentsBuffer) -> Result<IsNull, BoxDynError> {
        match serde_json::to_value(&self.0)? {
            Value::Null => Ok(IsNull::Yes),
            word => <String as Encode<Sqlite>>::encode(to_word(&word)?, buffer),
        }
    }
}

impl From<TextColumn<Self>> for OrientationRule {
    fn from(word: TextColumn<Self>) -> Self {
        word.0
    }
}

impl From<TextColumn<Self>> for Option<LengthUnit> {
    fn from(word: TextColumn<Self>) -> Self {
        word.0
    }
}

/// Returns the serde word of a value.
pub fn to_word(value: &impl Serialize) -> Result<String, BoxDynError> {
    match serde_json::to_value(value)? {
        serde_json::Value::String(word) => Ok(word),
        other => Err(format!("{other} is not a word").into()),
    }
}

/// Parses a serde word.
pub fn parse_word<T: DeserializeOwned>(word: &str) -> Result<T, BoxDynError> {
    Ok(serde_json::from_value(serde_json::Value::String(word.to_owned()))?)
}
