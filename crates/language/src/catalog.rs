//! The catalogs, and how a sentence is made of one.

use std::sync::LazyLock;

use fluent_bundle::{FluentArgs, FluentResource, FluentValue, concurrent::FluentBundle};

use crate::{Language, current};

/// The texts of an area of the pages, in the order of [`Language::ALL`].
pub(crate) struct Area {
    pub(crate) name: &'static str,
    pub(crate) texts: [&'static str; 4],
}

macro_rules! areas {
    ($($name:literal),+ $(,)?) => {
        [$(Area {
            name: $name,
            texts: [
                include_str!(concat!("../catalogs/en/", $name, ".ftl")),
                include_str!(concat!("../catalogs/de/", $name, ".ftl")),
                include_str!(concat!("../catalogs/fr/", $name, ".ftl")),
                include_str!(concat!("../catalogs/ja/", $name, ".ftl")),
            ],
        }),+]
    };
}

/// All areas.
pub(crate) static AREAS: &[Area] = &areas![
    "common",
    "facts",
    "alerts",
    "farm",
    "forms",
    "builds",
    "orders",
    "history",
    "break_out",
    "labels",
    "people",
    "mails",
    "help",
    "scripts",
    "status",
    "told_files",
    "told_lists",
    "told_farm"
];

static BUNDLES: LazyLock<[FluentBundle<FluentResource>; 4]> = LazyLock::new(|| Language::ALL.map(bundle_of));

fn bundle_of(language: Language) -> FluentBundle<FluentResource> {
    let mut bundle = FluentBundle::new_concurrent(vec![language.tag().parse().unwrap_or_default()]);
    // Marks around values are seen by whoever copies a text, and by tests; no language here is written from right to left.
    bundle.set_use_isolating(false);
    if language.has_decimal_comma() {
        bundle.set_formatter(Some(|value, _| match value {
            FluentValue::Number(number) if number.value.fract() != 0.0 => Some(number.as_string().replace('.', ",")),
            _ => None,
        }));
    }
    for area in AREAS {
        let text = area.texts[place_of(language)].to_owned();
        let resource = FluentResource::try_new(text).unwrap_or_else(|(resource, _)| resource);
        // Catalogs without faults are the business of the tests.
        let _ = bundle.add_resource(resource);
    }
    bundle
}

fn place_of(language: Language) -> usize {
    Language::ALL.iter().position(|one| *one == language).unwrap_or(0)
}

/// A value in a sentence.
#[derive(Debug, Clone, PartialEq)]
pub enum Arg {
    /// A text, as it is.
    Text(String),
    /// A number: it chooses the form of a word.
    Number(f64),
    /// A place that the caller fills: the number of the place.
    Slot(u8),
}

/// What can be a value in a sentence.
pub trait IntoArg {
    /// The value.
    fn into_arg(self) -> Arg;
}

macro_rules! into_arg {
    ($($kind:ty => $make:expr),+ $(,)?) => {
        $(impl IntoArg for $kind {
            fn into_arg(self) -> Arg {
                let make: fn($kind) -> Arg = $make;
                make(self)
            }
        })+
    };
}

into_arg! {
    Arg => |arg| arg,
    String => Arg::Text,
    &String => |text| Arg::Text(text.clone()),
    &str => |text| Arg::Text(text.to_owned()),
    i8 => |number| Arg::Number(number.into()),
    u8 => |number| Arg::Number(number.into()),
    i32 => |number| Arg::Number(number.into()),
    u32 => |number| Arg::Number(number.into()),
    i64 => |number| Arg::Number(number as f64),
    u64 => |number| Arg::Number(number as f64),
    usize => |number| Arg::Number(number as f64),
    f64 => Arg::Number,
}

/// A piece of a sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Piece {
    /// Words.
    Text(String),
    /// A place that the caller fills.
    Slot(u8),
}

/// Letters that stand for the places of a sentence while it is made; what others write cannot contain them.
const FIRST_SLOT: u32 = 0xE000;
const LAST_SLOT: u32 = 0xE0FF;

fn is_slot(letter: char) -> bool {
    (FIRST_SLOT..=LAST_SLOT).contains(&u32::from(letter))
}

/// The place that a letter stands for.
fn slot_of(letter: char) -> u8 {
    (u32::from(letter) - FIRST_SLOT) as u8
}

pub(crate) fn slot_letter(slot: u8) -> String {
    char::from_u32(FIRST_SLOT + u32::from(slot)).into_iter().collect()
}

/// An English word of a kind, such as a state or a label, in the language that is current; a word that no catalog has stays as it is.
pub fn say_word(kind: &str, word: &str) -> String {
    if current() == Language::English {
        return word.to_owned();
    }
    let id = word_id(kind, word);
    if BUNDLES[0].has_message(&id) { say(&id, &[]) } else { word.to_owned() }
}

/// The name of a word in the catalogs: `state-in-the-queue`.
pub(crate) fn word_id(kind: &str, word: &str) -> String {
    let dashed: String =
        word.to_lowercase().chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '-' }).collect();
    let words: Vec<&str> = dashed.split('-').filter(|word| !word.is_empty()).collect();
    format!("{kind}-{}", words.join("-"))
}

/// The sentence of a name: see [`crate::say!`].
pub fn say(id: &str, args: &[(&'static str, Arg)]) -> String {
    match current() {
        Language::Marked => say_marked(id, args),
        language => sentence(language, id, args),
    }
}

/// The sentence of a name in pieces, between which the caller puts what it has for the places.
pub fn say_pieces(id: &str, args: &[(&'static str, Arg)]) -> Vec<Piece> {
    pieces_of(&say(id, args))
}

/// A sentence in pieces, at the letters that stand for places.
pub(crate) fn pieces_of(said: &str) -> Vec<Piece> {
    let mut pieces = Vec::new();
    let mut words = String::new();
    for letter in said.chars() {
        if is_slot(letter) {
            if !words.is_empty() {
                pieces.push(Piece::Text(std::mem::take(&mut words)));
            }
            pieces.push(Piece::Slot(slot_of(letter)));
        } else {
            words.push(letter);
        }
    }
    if !words.is_empty() {
        pieces.push(Piece::Text(words));
    }
    pieces
}

pub(crate) fn sentence(language: Language, id: &str, args: &[(&'static str, Arg)]) -> String {
    let mut values = FluentArgs::new();
    for (name, arg) in args {
        match arg {
            Arg::Text(text) => values.set(*name, text.replace(is_slot, "\u{FFFD}")),
            Arg::Number(number) => values.set(*name, *number),
            Arg::Slot(slot) => values.set(*name, slot_letter(*slot)),
        }
    }
    [&BUNDLES[place_of(language)], &BUNDLES[0]]
        .into_iter()
        .find_map(|bundle| {
            let pattern = bundle.get_message(id)?.value()?;
            Some(bundle.format_pattern(pattern, Some(&values), &mut Vec::new()).into_owned())
        })
        .unwrap_or_else(|| id.to_owned())
}

/// English, with marks around all words of the catalog, and none around the values.
fn say_marked(id: &str, args: &[(&'static str, Arg)]) -> String {
    // Places of the caller keep their letters; texts get letters behind them, and are put back afterwards.
    let texts: Vec<(&'static str, Arg)> = (args.iter().enumerate())
        .map(|(at, (name, arg))| match arg {
            Arg::Text(_) => (*name, Arg::Slot(128 + at as u8)),
            other => (*name, other.clone()),
        })
        .collect();
    let said = sentence(Language::English, id, &texts);
    let mut marked = String::new();
    for words in said.split_inclusive(is_slot) {
        let slot = words.chars().next_back().filter(|letter| is_slot(*letter));
        let words = words.trim_end_matches(is_slot);
        if !words.is_empty() {
            marked.push_str(&format!("⟦{words}⟧"));
        }
        match slot.map(|letter| usize::from(slot_of(letter))) {
            Some(at) if at >= 128 => {
                if let Some((_, Arg::Text(text))) = args.get(at - 128) {
                    marked.push_str(text);
                }
            }
            Some(at) => marked.push_str(&slot_letter(at as u8)),
            None => {}
        }
    }
    marked
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::say;

    #[test]
    fn a_sentence_has_its_values_and_the_words_that_they_choose() {
        assert_eq!(say!("count-copies", count = 1), "1 copy");
        assert_eq!(say!("count-copies", count = 3_u32), "3 copies");
        assert_eq!(Language::Marked.within(|| say!("date-month", month = "May", year = "2026")), "May⟦ ⟧2026");
        assert_eq!(say("no-such-sentence", &[]), "no-such-sentence");
    }

    #[test]
    fn the_places_of_a_sentence_are_pieces_and_no_value_can_be_one() {
        let pieces = say_pieces("date-month", &[("month", Arg::Slot(3)), ("year", "20\u{E003}26".into_arg())]);
        assert_eq!(pieces, [Piece::Slot(3), Piece::Text(" 20\u{FFFD}26".to_owned())]);
        let marked = Language::Marked
            .within(|| say_pieces("date-month", &[("month", "May".into_arg()), ("year", Arg::Slot(0))]));
        assert_eq!(marked, [Piece::Text("May⟦ ⟧".to_owned()), Piece::Slot(0)]);
    }
}
