//! What people read, in their language: English, German, French or Japanese.
//!
//! A sentence has a name, and stands in a catalog (`catalogs/en/*.ftl`, Project Fluent). [`say!`] gives it in the language that is
//! current: that of the request ([`Language::scope`]) or of the file that is written ([`Language::within`]). Without one it is English, as
//! logs, commands and JSON are. A sentence that a language lacks is said in English. [`told`] says an English text again that was stored.

mod catalog;
mod current;
mod dates;
mod language;
mod marked;
mod retold;
mod signs;

pub use catalog::{Arg, IntoArg, Piece, say, say_pieces, say_word};
pub use current::current;
pub use dates::{clock_text, day_text, decimal, long_day_text, month_text, year_text};
pub use language::Language;
pub use marked::unsaid_words;
pub use retold::{retold, told};
pub use signs::{colon, comma, join_names, join_sentences};

/// The sentence of a name in the language that is current. Values are numbers and texts: `count = 3`.
#[macro_export]
macro_rules! say {
    ($id:literal $(, $name:ident = $value:expr)* $(,)?) => {
        $crate::say($id, &[$((stringify!($name), $crate::IntoArg::into_arg($value))),*])
    };
}

#[cfg(test)]
mod catalog_tests;
#[cfg(test)]
mod told_tests;
