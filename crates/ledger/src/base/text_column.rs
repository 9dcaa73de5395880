//! Stores enums as words in text columns. The words are those of serde, so there is no other list of them besides the
//! `CHECK` constraints.

/// Implements binding and reading of columns for an enum by its serde word.
macro_rules! word_column {
    ($($word:ty),+) => {
        $(
            impl $crate::base::sql::BindValue for $word {
                const NULL: $crate::base::sql::SqlValue = $crate::base::sql::SqlValue::Text(None);

                fn to_sql(&self) -> $crate::base::sql::SqlValue {
                    $crate::base::sql::SqlValue::Text(Some($crate::base::text_column::to_word(self)))
                }
            }

            $crate::base::sql::read_text_by!($word, $crate::base::text_column::parse_word);
        )+
    };
}

/// Implements [`word_column`] and [`Display`](std::fmt::Display) for an enum of the ledger by its serde word.
macro_rules! own_word {
    ($word:ty) => {
        $crate::base::text_column::word_column!($word);

        impl std::fmt::Display for $word {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(&$crate::base::text_column::to_word(self))
            }
        }
    };
}

pub(crate) use {own_word, word_column};

use build_file::LengthUnit;
use nester::OrientationRule;
use serde::{Serialize, de::DeserializeOwned};

word_column!(OrientationRule, LengthUnit);

/// Returns the serde word of a value. Only for enums without fields.
pub fn to_word(value: &impl Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(word)) => word,
        other => unreachable!("{other:?} is not a word"),
    }
}

/// Parses a serde word.
pub fn parse_word<T: DeserializeOwned>(word: &str) -> Result<T, serde_json::Error> {
    serde_json::from_value(serde_json::Value::String(word.to_owned()))
}
