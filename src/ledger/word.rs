//! Words that a column may hold: an enum here, a text there, and no third list of names besides the `CHECK`.

/// Gives an enum whose serde form is a plain word its form in SQL and in print: the same word.
macro_rules! sql_word {
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
    };
}

/// As [`sql_word`], and `Display` too: for the enums of this room.
macro_rules! own_word {
    ($word:ty) => {
        $crate::ledger::word::sql_word!($word);

        impl std::fmt::Display for $word {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                let word = $crate::ledger::word::print(self).map_err(|_| std::fmt::Error)?;
                f.pad(&word)
            }
        }
    };
}

pub(crate) use {own_word, sql_word};

use serde::{Serialize, de::DeserializeOwned};
use sqlx::error::BoxDynError;

sql_word!(crate::format::Unit);
sql_word!(crate::nest::OrientationRule);

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
