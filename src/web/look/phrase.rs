//! Sentences with elements in them: links, times and chips stand where each language wants them.

use language::{Arg, IntoArg, Piece};
use ledger::{BuildId, PartId};
use maud::{Markup, html};

/// A sentence of the catalogs with elements among its values: `build = html! { b { (7) } }, count = 3`.
macro_rules! phrase {
    ($id:literal $(, $name:ident = $value:expr)* $(,)?) => {{
        let mut _elements: Vec<::maud::Markup> = Vec::new();
        let values = [$((stringify!($name), $crate::web::look::phrase::InPhrase::in_phrase($value, &mut _elements))),*];
        $crate::web::look::phrase::phrase_of($id, &values, &_elements)
    }};
}

/// What can be a value of a sentence on a page.
pub(crate) trait InPhrase {
    /// The value; an element is put with the others.
    fn in_phrase(self, elements: &mut Vec<Markup>) -> Arg;
}

impl InPhrase for Markup {
    fn in_phrase(self, elements: &mut Vec<Markup>) -> Arg {
        elements.push(self);
        Arg::Slot(u8::try_from(elements.len() - 1).unwrap_or(u8::MAX))
    }
}

macro_rules! plain_in_phrase {
    ($($kind:ty),+) => {
        $(impl InPhrase for $kind {
            fn in_phrase(self, _: &mut Vec<Markup>) -> Arg {
                self.into_arg()
            }
        })+
    };
}

plain_in_phrase!(String, &String, &str, u32, i64, u64, usize, f64);

macro_rules! number_in_phrase {
    ($($kind:ty),+) => {
        $(impl InPhrase for $kind {
            fn in_phrase(self, _: &mut Vec<Markup>) -> Arg {
                Arg::Text(self.to_string())
            }
        })+
    };
}

number_in_phrase!(BuildId, PartId);

/// The sentence of a name, with its elements: see `phrase!`.
pub(crate) fn phrase_of(id: &str, values: &[(&'static str, Arg)], elements: &[Markup]) -> Markup {
    html! {
        @for piece in language::say_pieces(id, values) {
            @match piece {
                Piece::Text(words) => (words),
                Piece::Slot(slot) => { @if let Some(element) = elements.get(usize::from(slot)) { (element) } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_stand_in_a_sentence_and_its_texts_are_escaped() {
        let shown = phrase!("date-month", month = "<May>", year = html! { b { (2026) } });
        assert_eq!(shown.into_string(), "&lt;May&gt; <b>2026</b>");
    }
}
