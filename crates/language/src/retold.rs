//! Sentences that were written in English, said again in the language that is current.
//!
//! Reasons, details of alerts and events are written once, in English: logs, commands, JSON and the ledger have them so. Their sentences
//! stand in the catalogs of [`TOLD`]. A text that was made of them is known by their words, as `gettext` knows a text by its English; what
//! stands between these words are its values. Nothing is decided by it: what no catalog knows stays as it is.

use std::{cmp::Reverse, collections::HashMap, sync::LazyLock};

use crate::{
    Arg, Language, Piece,
    catalog::{AREAS, pieces_of, sentence, slot_letter},
    comma, current, decimal, say,
};

/// Areas of sentences that are written in English and said again.
pub(crate) const TOLD: [&str; 4] = ["alerts", "told_files", "told_lists", "told_farm"];
/// Values that are sentences themselves: a text is known only if these are.
pub(crate) const SENTENCES: [&str; 7] = ["what", "why", "remedy", "rest", "formats", "who", "others"];
/// What separates sentences: no name has it.
const SEPARATORS: [&str; 3] = ["; ", ". ", ": "];
/// The value that stands for a number while the forms of a sentence are made; no catalog has it.
const SAMPLE: u32 = 98_765_400;
/// Sentences stand in each other no deeper.
const MAX_DEPTH: u32 = 8;
/// Places that are tried for the values of one text. A name may contain what separates values.
const MAX_TRIES: u32 = 4000;
/// To look through all sentences counts as so many places.
const TRIES_OF_A_LOOK: u32 = 20;
/// A longer text stays as it is, bytes.
const LONGEST_TEXT: usize = 8000;

/// One form of a sentence, as it stands in an English text.
struct Pattern {
    name: &'static str,
    /// Its values, and what they can be.
    values: Vec<(&'static str, ValueKind)>,
    /// Numbers that this form says itself: `1 copy`.
    fixed: Vec<(usize, u32)>,
    /// Its words, and the places of its values.
    pieces: Vec<Piece>,
    /// Letters of its own. The more they are, the surer it is meant.
    letters: usize,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum ValueKind {
    /// A number, a size or a word, as it is.
    Data,
    /// A name, as it is. It may have a comma.
    Name,
    /// An absolute path.
    Path,
    /// Names with commas between them.
    Names,
    /// Any text of others.
    Quote,
    /// A sentence, to be said again.
    Sentence,
    /// A whole number that chooses words.
    Number,
}

static PATTERNS: LazyLock<Vec<Pattern>> = LazyLock::new(|| {
    let told = AREAS.iter().filter(|area| TOLD.contains(&area.name));
    let mut patterns: Vec<Pattern> = told.flat_map(|area| sentences_of(area.texts[0])).flat_map(forms_of).collect();
    patterns.sort_by_key(|pattern| Reverse(pattern.letters));
    patterns
});

/// The names of a catalog with what is written behind them.
pub(crate) fn sentences_of(text: &'static str) -> Vec<(&'static str, &'static str)> {
    let begins_a_name = |line: &str| line.starts_with(|letter: char| letter.is_ascii_lowercase());
    let mut starts: Vec<usize> = text.match_indices('\n').map(|(at, _)| at + 1).collect();
    starts.insert(0, 0);
    starts.retain(|at| begins_a_name(&text[*at..]));
    let ends = starts.iter().skip(1).copied().chain([text.len()]);
    // A remark belongs to what follows it.
    let blocks = starts.iter().zip(ends).filter_map(|(from, to)| text[*from..to].split("\n#").next()?.split_once('='));
    blocks.map(|(name, sentence)| (name.trim(), sentence)).collect()
}

/// The values that a sentence names, in the order of their first place.
pub(crate) fn values_of(sentence: &'static str) -> Vec<&'static str> {
    let mut values = Vec::new();
    for rest in sentence.split('$').skip(1) {
        let end = rest.find(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_').unwrap_or(rest.len());
        if !values.contains(&&rest[..end]) {
            values.push(&rest[..end]);
        }
    }
    values
}

/// The forms that a sentence has in English: with each of its numbers 1, and more.
fn forms_of((name, text): (&'static str, &'static str)) -> Vec<Pattern> {
    let kind_of = |value: &'static str| {
        let kind = match () {
            () if text.contains(&format!("${value} ->")) => ValueKind::Number,
            () if SENTENCES.contains(&value) => ValueKind::Sentence,
            () => match value {
                "name" => ValueKind::Name,
                "path" => ValueKind::Path,
                "names" | "places" => ValueKind::Names,
                "detail" | "reason" => ValueKind::Quote,
                _ => ValueKind::Data,
            },
        };
        (value, kind)
    };
    let values: Vec<_> = values_of(text).into_iter().map(kind_of).collect();
    let numbers: Vec<usize> = (0..values.len()).filter(|at| values[*at].1 == ValueKind::Number).collect();
    let forms = 0..1_u32 << numbers.len();
    forms
        .map(|form| {
            let is_one = |at: usize| numbers.iter().position(|n| *n == at).is_some_and(|n| form >> n & 1 == 1);
            let fixed: Vec<(usize, u32)> = numbers.iter().filter(|at| is_one(**at)).map(|at| (*at, 1)).collect();
            let args: Vec<(&'static str, Arg)> = (values.iter().enumerate())
                .map(|(at, (value, kind))| {
                    let arg = match kind {
                        ValueKind::Number if is_one(at) => Arg::Number(1.0),
                        ValueKind::Number => Arg::Number((SAMPLE + at as u32).into()),
                        _ => Arg::Slot(at as u8),
                    };
                    (*value, arg)
                })
                .collect();
            let mut said = sentence(Language::English, name, &args);
            for at in &numbers {
                said = said.replace(&(SAMPLE + *at as u32).to_string(), &slot_letter(*at as u8));
            }
            let pieces = pieces_of(said.strip_suffix('.').unwrap_or(&said));
            let letters = pieces.iter().map(letters_of).sum();
            Pattern { name, values: values.clone(), fixed, pieces, letters }
        })
        .collect()
}

/// Letters of the sentence itself.
fn letters_of(piece: &Piece) -> usize {
    match piece {
        Piece::Text(words) => words.chars().filter(|letter| letter.is_alphabetic()).count(),
        Piece::Slot(_) => 0,
    }
}

/// A text of English sentences of the catalogs, in the language that is current; `None` = the catalogs do not know all of it.
pub fn retold(text: &str) -> Option<String> {
    if current() == Language::English {
        return Some(text.to_owned());
    }
    if text.len() > LONGEST_TEXT {
        return None;
    }
    let mut telling = Telling { depth: 0, tries: MAX_TRIES, known: HashMap::new() };
    let lines: Option<Vec<String>> = text
        .lines()
        .map(|line| if line.trim().is_empty() { Some(String::new()) } else { telling.retell(line.trim_end()) })
        .collect();
    lines.map(|lines| lines.join("\n"))
}

/// The same; what no catalog knows stays English.
pub fn told(text: &str) -> String {
    retold(text).unwrap_or_else(|| text.to_owned())
}

/// What is left to try for a text.
struct Telling {
    depth: u32,
    tries: u32,
    /// Pieces that were looked at before, and what is said of them.
    known: HashMap<String, Option<String>>,
}

impl Telling {
    fn retell(&mut self, text: &str) -> Option<String> {
        let (bare, stop) = match text.strip_suffix('.') {
            Some(bare) => (bare, current().full_stop()),
            None => (text, ""),
        };
        if bare.is_empty() || self.depth == MAX_DEPTH {
            return None;
        }
        if let Some(known) = self.known.get(text) {
            return known.clone();
        }
        self.tries = self.tries.checked_sub(TRIES_OF_A_LOOK)?;
        self.depth += 1;
        let found = PATTERNS.iter().find_map(|pattern| pattern.say_again(bare, self));
        let said = found
            .map(|said| format!("{}{stop}", said.trim_end_matches(['.', '。'])))
            .or_else(|| self.retell_each(text));
        self.depth -= 1;
        self.known.insert(text.to_owned(), said.clone());
        said
    }

    /// Sentences that stand behind each other.
    fn retell_each(&mut self, text: &str) -> Option<String> {
        text.match_indices(". ").map(|(at, _)| at + 1).find_map(|at| {
            let first = self.retell(&text[..at])?;
            let rest = self.retell(&text[at + 1..])?;
            Some(format!("{first}{}{rest}", current().space_between_sentences()))
        })
    }
}

impl Pattern {
    /// The sentence in the language that is current, if a text is this one.
    fn say_again(&self, text: &str, telling: &mut Telling) -> Option<String> {
        let has_words = |piece: &Piece| match piece {
            Piece::Text(words) => text.contains(words.as_str()),
            Piece::Slot(_) => true,
        };
        if !self.pieces.iter().all(has_words) {
            return None;
        }
        let mut found: Vec<Option<Arg>> = vec![None; self.values.len()];
        for (at, number) in &self.fixed {
            found[*at] = Some(Arg::Number((*number).into()));
        }
        if !self.matches(&self.pieces, text, &mut found, telling) {
            return None;
        }
        let args: Option<Vec<(&'static str, Arg)>> =
            self.values.iter().zip(found).map(|((name, _), arg)| Some((*name, arg?))).collect();
        Some(say(self.name, &args?))
    }

    fn matches(&self, pieces: &[Piece], text: &str, found: &mut Vec<Option<Arg>>, telling: &mut Telling) -> bool {
        let Some((first, rest)) = pieces.split_first() else { return text.is_empty() };
        let at = match first {
            Piece::Text(words) => {
                return text.strip_prefix(words.as_str()).is_some_and(|text| self.matches(rest, text, found, telling));
            }
            Piece::Slot(at) => usize::from(*at),
        };
        let ends: Vec<usize> = match rest.first() {
            Some(Piece::Text(words)) => text.match_indices(words.as_str()).map(|(end, _)| end).collect(),
            _ => vec![text.len()],
        };
        ends.into_iter().filter(|end| *end > 0).any(|end| {
            let Some(left) = telling.tries.checked_sub(1) else { return false };
            telling.tries = left;
            let mut others = found.clone();
            if !self.matches(rest, &text[end..], &mut others, telling) {
                return false;
            }
            let Some(arg) = self.arg_of(at, &text[..end], telling) else { return false };
            // A value that a sentence names twice is the same.
            let is_same = others[at].as_ref().is_none_or(|known| *known == arg);
            others[at] = Some(arg);
            *found = others;
            is_same
        })
    }

    /// A value of a text, in the language that is current; `None` = it is none.
    fn arg_of(&self, at: usize, text: &str, telling: &mut Telling) -> Option<Arg> {
        match self.values[at].1 {
            ValueKind::Number => {
                let is_digits = text.bytes().all(|byte| byte.is_ascii_digit());
                Some(Arg::Number(text.parse().ok().filter(|_| is_digits)?))
            }
            ValueKind::Sentence => telling.retell(text).map(Arg::Text),
            ValueKind::Quote => Some(Arg::Text(text.to_owned())),
            _ if SEPARATORS.iter().any(|between| text.contains(between)) => None,
            ValueKind::Path if !text.starts_with('/') => None,
            ValueKind::Data if text.contains(", ") => None,
            ValueKind::Names => Some(Arg::Text(text.replace(", ", &comma()))),
            _ => {
                let is_number = text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
                Some(Arg::Text(if is_number { decimal(text.to_owned()) } else { text.to_owned() }))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_stored_in_english_is_said_in_the_language_of_the_reader() {
        let text = "Its file is no longer kept. Drop it again.";
        assert_eq!(told(text), text);
        Language::Japanese.within(|| {
            let said = retold(text).unwrap();
            assert!(said.ends_with('。') && !said.contains('.'), "{said}");
        });
        Language::Marked.within(|| {
            assert_eq!(
                told("bracket.stl: the file is truncated: it ends within facet 7"),
                "bracket.stl⟦: ⟧⟦the file is truncated: ⟧⟦it ends within facet ⟧7"
            );
            assert_eq!(told("2 open edges, 1 open edge"), "⟦2 open edges⟧⟦, ⟧⟦1 open edge⟧");
        });
    }

    #[test]
    fn what_no_catalog_knows_stays_and_costs_little() {
        Language::German.within(|| {
            for text in ["", ".", "the cat sat on the mat", "bracket.stl: what is this"] {
                assert_eq!(told(text), text);
                assert_eq!(retold(text).is_some(), text.is_empty(), "{text}");
            }
            let hostile = ": the mesh is not closed (, ".repeat(200) + &". ".repeat(2000);
            let began = std::time::Instant::now();
            assert_eq!(told(&hostile), hostile.trim_end_matches('\n'));
            assert!(began.elapsed().as_secs_f64() < 2.0, "{:?}", began.elapsed());
        });
    }
}
