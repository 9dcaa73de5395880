//! Words that a column may hold: an enum here, a text there, and no third list of names besides the `CHECK`.

/// Gives an enum of this room whose serde form is a plain word its form in SQL and in print: the same word.
macro_rules! own_word {
    ($word:ty) => {
        impl sqlx::Type<sqlx::Sqlite> for $word {
            fn type_info() -> sqlx::sqlite::SqliteTypeInfo {
                <str as sqlx::Type<sqlx::Sqlite>>::type_info()
            }
        }

        impl<'r> sqlx::Decode<'r, sqlx::Sqlite> for $word {
            fn decode(value: sqlx::sqlite::SqliteValueRef<'r>) -> Result<Self, sqlx::error::BoxDynError> {
                $crate::ledger::word::parse(<&str as sqlx::Decode<sqlx::Sqlite>>::decode(value)?)
            }
        }

        impl sqlx::Encode<'_, sqlx::Sqlite> for $word {
            fn encode_by_ref(
                &self,
                buffer: &mut sqlx::sqlite::SqliteArgumentsBuffer,
            ) -> Result<sqlx::encode::IsNull, sqlx::error::BoxDynError> {
                let word = $crate::ledger::word::print(self)?;
                <String as sqlx::Encode<sqlx::Sqlite>>::encode(word, buffer)
            }
        }

        impl std::fmt::Display for $word {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                let word = $crate::ledger::word::print(self).map_err(|_| std::fmt::Error)?;
                f.pad(&word)
            }
        }
    };
}

pub(crate) use own_word;

use build_file::Unit;
use nester::OrientationRule;
use serde::{Serialize, de::DeserializeOwned};
use serde_json::Value;
use sqlx::{
    Decode, Encode, Sqlite, Type,
    encode::IsNull,
    error::BoxDynError,
    sqlite::{SqliteArgumentsBuffer, SqliteTypeInfo, SqliteValueRef},
};

/// An enum of another crate on its way into a column or out of it, as its serde form says; no value is NULL.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Word<T>(pub T);

impl<T> Type<Sqlite> for Word<T> {
    fn type_info() -> SqliteTypeInfo {
        <str as Type<Sqlite>>::type_info()
    }
}

impl<'r, T: DeserializeOwned> Decode<'r, Sqlite> for Word<T> {
    fn decode(value: SqliteValueRef<'r>) -> Result<Self, BoxDynError> {
        let word = <Option<&str> as Decode<Sqlite>>::decode(value)?;
        let word = word.map_or(Value::Null, |word| Value::String(word.to_owned()));
        Ok(Self(serde_json::from_value(word)?))
    }
}

impl<T: Serialize> Encode<'_, Sqlite> for Word<T> {
    fn encode_by_ref(&self, buffer: &mut SqliteArgumentsBuffer) -> Result<IsNull, BoxDynError> {
        match serde_json::to_value(&self.0)? {
            Value::Null => Ok(IsNull::Yes),
            word => <String as Encode<Sqlite>>::encode(print(&word)?, buffer),
        }
    }
}

impl From<Word<Self>> for OrientationRule {
    fn from(word: Word<Self>) -> Self {
        word.0
    }
}

impl From<Word<Self>> for Option<Unit> {
    fn from(word: Word<Self>) -> Self {
        word.0
    }
}

/// The word for a value.
pub fn print(value: &impl Serialize) -> Result<String, BoxDynError> {
    match serde_json::to_value(value)? {
        serde_json::Value::String(word) => Ok(word),
        other => Err(format!("{other} is not a word").into()),
    }
}

/// The value of a word.
pub fn parse<T: DeserializeOwned>(word: &str) -> Result<T, BoxDynError> {
    Ok(serde_json::from_value(serde_json::Value::String(word.to_owned()))?)
}
