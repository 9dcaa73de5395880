//! The words of an enum that another crate defines, for the description of the JSON interface. They are read from its
//! serde implementation, so that there is no second list that can become outdated.

use std::fmt;

use serde::{
    Deserializer, Serialize,
    de::{DeserializeOwned, Error, Visitor},
    forward_to_deserialize_any,
};
use serde_json::Value;

/// The words that serde writes for the variants of an enum, in order.
pub(super) fn words_of<T: Serialize + DeserializeOwned>() -> Vec<Value> {
    let mut read = Vec::new();
    // The deserializer only collects the words. It never provides a value, so the result is always an error.
    let _ = T::deserialize(WordsAsked(&mut read)).is_ok();
    let value = |word: &str| serde_json::from_value::<T>(word.into()).and_then(serde_json::to_value).ok();
    let mut written: Vec<Value> = read.into_iter().filter_map(value).collect();
    // Several words may stand for the same variant.
    written.dedup();
    written
}

/// The same words, and null for a missing value.
pub(super) fn words_or_null<T: Serialize + DeserializeOwned>() -> Vec<Value> {
    let mut words = words_of::<T>();
    words.push(Value::Null);
    words
}

/// A deserializer that collects the words of an enum.
struct WordsAsked<'w>(&'w mut Vec<&'static str>);

/// The error with which the deserializer ends once it has the words.
#[derive(Debug)]
struct NoValue;

impl<'de> Deserializer<'de> for WordsAsked<'_> {
    type Error = NoValue;

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        words: &'static [&'static str],
        _visitor: V,
    ) -> Result<V::Value, NoValue> {
        self.0.extend_from_slice(words);
        Err(NoValue)
    }

    fn deserialize_any<V: Visitor<'de>>(self, _visitor: V) -> Result<V::Value, NoValue> {
        Err(NoValue)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map struct identifier ignored_any
    }
}

impl fmt::Display for NoValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("no value")
    }
}

impl std::error::Error for NoValue {}

impl Error for NoValue {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Self
    }
}
