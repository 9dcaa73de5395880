//! Numbers beside a word for pieces that may be only a part of what is wanted: sums, ranges, shares, products, dozens and sets.

use std::ffi::OsStr;

use super::{
    copies_sizes::{is_listed, is_number_of_thing, is_size_number},
    copies_words::{HOLDS, NameWord, WordKind, is_digits, is_word_for_pieces, is_word_of},
    name_match::fold_name,
};

/// Words between two numbers of which either may be meant: `2 bis 3 Stk`, `4 of 8 pcs`.
const BETWEEN: &str = "bis to or oder ou o à von of de du und and et y plus til till до из";
/// Words between a number and what it is a part of: `8 per set`.
const PER: [&str; 6] = ["per", "pro", "par", "por", "je", "a"];
/// What has a number of a part.
const WHOLES: &str = "set sets satz sätze saetze kit kits pack package order box assembly assy unit machine part product baugruppe auftrag \
                      gerät geraet maschine packung jeu commande ensemble";
/// Words before one group: `a pair of clips`.
const ONE: [&str; 8] = ["a", "an", "one", "ein", "eine", "einen", "un", "une"];
const FEW: &str = "pair couple dozen paar dutzend paire douzaine";
/// A number of more digits is one of a part or an order.
const MAX_DIGITS: usize = 3;

/// Whether the name of a folder is that of a number of pieces: `5 Stück`, `2x`, `x 3`.
pub(crate) fn is_count_name(folder: &OsStr) -> bool {
    let Some(name) = folder.to_str().map(fold_name) else { return false };
    let bare = name.trim_matches(|c: char| c.is_whitespace() || matches!(c, '(' | ')' | '[' | ']' | '_' | '-'));
    let (front, back) =
        (bare.trim_start_matches(|c: char| c.is_ascii_digit()), bare.trim_end_matches(|c: char| c.is_ascii_digit()));
    let is_word = |word: &str| {
        let word = word.trim_matches(|c: char| !c.is_alphanumeric() && c != '×');
        matches!(word, "x" | "×" | "qty" | "anzahl" | "menge") || is_word_for_pieces(word)
    };
    front.len() < bare.len() && is_word(front) || back.len() < bare.len() && is_word(back)
}

fn is_short_number(words: &[NameWord], at: usize) -> bool {
    words[at].number().is_some_and(|number| number.len() <= MAX_DIGITS)
}

/// Whether the number of pieces at `at` belongs to another number or to what the part is made for: `10-12pcs`, `10+1 Stk`,
/// `2 x 4 pcs`, `box for 12 pcs`. `1042-12pcs` is twelve.
pub(super) fn is_doubtful_number(words: &[NameWord], at: usize) -> bool {
    let Some(before) = at.checked_sub(1) else { return false };
    let gap = words[at].gap.trim();
    let is_range =
        matches!(words[at].gap.as_str(), "-" | "–") || matches!(gap, "+" | "/" | "&" | "±" | "~" | "..." | "…");
    let is_joining = is_listed(BETWEEN, &words[before].text);
    let is_times = matches!(words[before].text.as_str(), "x" | "×");
    let other = before.checked_sub(1).filter(|_| is_joining || is_times);
    let is_joined = other.is_some_and(|other| is_short_number(words, other) && !is_number_of_thing(words, other));
    is_range && is_short_number(words, before) || is_joined || HOLDS.contains(&words[before].text.as_str())
}

/// Whether a number with a multiplication sign, from `at` to `end`, is that of things which the part holds: `for 2x 18650`.
pub(super) fn is_number_of_held(words: &[NameWord], at: usize, end: usize) -> bool {
    let is_for = at.checked_sub(1).is_some_and(|before| HOLDS.contains(&words[before].text.as_str()));
    is_for || words.get(end).is_some_and(|next| is_size_number(&next.text))
}

/// The number of words from `at` that tell of a group, or of pieces in a product: `8 per set`, `a pair`, `2x4 Stk`.
pub(super) fn group_length(words: &[NameWord], at: usize) -> Option<usize> {
    let text = |at: usize| words.get(at).map_or("", |word| word.text.as_str());
    let is_number = |at: usize| words.get(at).is_some_and(|word| word.number().is_some());
    let is_pieces = |word: &str| is_word_of(WordKind::Pieces, word);
    if is_number(at) && PER.contains(&text(at + 1)) && is_listed(WHOLES, text(at + 2)) {
        return Some(3);
    }
    if ONE.contains(&text(at)) && is_listed(FEW, text(at + 1)) {
        return Some(2);
    }
    let (first, second) = text(at).split_once(['x', '×'])?;
    let tail = second.trim_start_matches(|c: char| c.is_ascii_digit());
    let is_product = is_digits(first) && second.len() > tail.len() && first.len() <= MAX_DIGITS;
    match tail {
        "" if is_product && is_pieces(text(at + 1)) && !is_number(at + 2) => Some(2),
        tail if is_product && is_pieces(tail) => Some(1),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_is_called_by_a_number_of_pieces_is_told_from_others() {
        for name in ["5 Stück", "2x", "x 3", "10 pcs", "3_Stk", "Qty 4", "4×"] {
            assert!(is_count_name(OsStr::new(name)), "{name}");
        }
        for name in ["order-7", "4711", "X", "2026-11-30", "5 Meier", "Bambu X1", "Stück"] {
            assert!(!is_count_name(OsStr::new(name)), "{name}");
        }
    }
}
