//! Number of copies in a file name: `bracket_x10.stl` means ten brackets. A name that seems to say a number of copies, but
//! not clearly, means one copy and a question to the technician.

use std::ffi::OsStr;

use build_file::MAX_COPIES;

use super::{
    copies_doubts::{group_length, is_doubtful_number, is_number_of_held},
    copies_sizes::{completes_size, continues_size, follows_any_size, is_number_of_thing},
    copies_words::{
        NameWord, PHRASE_ENDS, TIMES, WordKind, ends_in_own_x, is_counter, is_digits, is_east_asian_count,
        is_tail_word, is_word_of, shown_words, split_name_words, word_before_number,
    },
    name::is_part_name,
};

/// More copies are asked for where only a sign says them: `x60` behind a name is as often a size or a number of a series, and
/// one digit too many costs a build.
const MAX_COPIES_BY_SIGN: u32 = 50;
/// More copies are asked for where a word for pieces says them: `box 500 pcs` may be a box for 500 of something else.
const MAX_COPIES_IN_WORDS: u32 = 100;
/// Words that end in x and a longer number are names, such as those of graphics cards.
const MAX_DIGITS_BEHIND_WORD: usize = 3;
/// `cx5` is a name, `bracketx5` may be five brackets.
const MIN_LETTERS_BEFORE_X: usize = 3;

/// What a file name says about the number of copies.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CopiesInName {
    /// Nothing.
    Unsaid,
    /// A number from 1 to 100.
    Said(u32),
    /// These words may mean a number of copies, or something else.
    Unclear(String),
    /// These words mean more copies than a name alone may order.
    Many(String),
    /// The bytes of the name are not text in UTF-8, so nobody knows its characters.
    Undecodable,
}

impl CopiesInName {
    /// Why the number of copies must be asked for: a clause about the part. `None` = it need not be.
    pub fn unclear_reason(&self) -> Option<String> {
        match self {
            Self::Unsaid | Self::Said(_) => None,
            Self::Unclear(words) => {
                Some(format!("its name says {words:?}, which is no clear number of copies from 1 to {MAX_COPIES}"))
            }
            Self::Many(words) => Some(format!("its name says {words:?}, which is more than a name alone may order")),
            Self::Undecodable => Some("its name is not text in UTF-8, so a number in it cannot be read".to_owned()),
        }
    }

    /// How many copies a file with this name orders where nothing else says it.
    ///
    /// # Errors
    /// It must be asked: [`unclear_reason`](Self::unclear_reason).
    pub fn number(&self) -> Result<u32, String> {
        match (self, self.unclear_reason()) {
            (_, Some(why)) => Err(why),
            (Self::Said(copies), None) => Ok(*copies),
            (_, None) => Ok(1),
        }
    }
}

/// Reads the number of copies from the bytes of a file's name.
pub fn read_copies_in_file_name(name: &OsStr) -> CopiesInName {
    name.to_str().map_or(CopiesInName::Undecodable, read_copies_in_name)
}

/// Returns the number of copies that a file name asks for. `None` if it asks for none or is unclear.
pub fn copies_in_name(name: &str) -> Option<u32> {
    match read_copies_in_name(name) {
        CopiesInName::Said(copies) => Some(copies),
        _ => None,
    }
}

/// Words of a name that may say a number of copies.
#[derive(Debug)]
struct CopiesMention {
    /// The number, if the words mean it without doubt.
    copies: Option<u32>,
    /// The words, as far as they are shown to people.
    text: String,
    /// Whether they contain a word for pieces, which `x4` does not.
    is_in_words: bool,
}

/// Reads what a file name says about the number of copies: `_x10`, `4x_`, `×3`, `qty_6`, `6 Stk`, `5ex`, `3個` and others.
/// The name of a CAMSPEC package is that of its order, and says nothing: how many are wanted stands in the package.
pub fn read_copies_in_name(name: &str) -> CopiesInName {
    if build_file::is_camspec_name(name) {
        return CopiesInName::Unsaid;
    }
    let words = split_name_words(without_copy_number(without_extension(name)));
    let mut mentions = mentions_in_words(&words);
    // `plate_4x_M3_qty_6`: the clear word tells what the unclear one is not.
    if mentions.iter().any(|one| one.is_in_words && one.copies.is_some()) {
        mentions.retain(|one| one.is_in_words || one.copies.is_some());
    }
    let Some(first) = mentions.first() else { return CopiesInName::Unsaid };
    match first.copies.filter(|_| mentions.iter().all(|one| one.copies == first.copies)) {
        Some(copies) if copies > most_copies(&mentions) => CopiesInName::Many(first.text.clone()),
        Some(copies) => CopiesInName::Said(copies),
        None => {
            let mut texts: Vec<&str> = mentions.iter().map(|one| one.text.as_str()).collect();
            texts.dedup();
            CopiesInName::Unclear(texts.join(" .. "))
        }
    }
}

/// The most copies that a name with these mentions may order without a question.
fn most_copies(mentions: &[CopiesMention]) -> u32 {
    match mentions.iter().any(|one| one.is_in_words) {
        true => MAX_COPIES_IN_WORDS,
        false => MAX_COPIES_BY_SIGN,
    }
}

/// Removes the extension, also one that was added twice.
fn without_extension(name: &str) -> &str {
    let Some((stem, _)) = name.rsplit_once('.') else { return name };
    // `bracket.stl.x10` has no extension of its own.
    match times_digits(&name[stem.len() + 1..]) {
        Some(_) => name,
        None if is_part_name(stem.as_ref()) => without_extension(stem),
        None => stem,
    }
}

/// Removes the ` (2)` that browsers and file managers add to the name of a second file.
fn without_copy_number(stem: &str) -> &str {
    let inner = stem.trim_end().strip_suffix(')').and_then(|rest| rest.rsplit_once('('));
    inner.filter(|(_, n)| is_digits(n) && n.len() < 4).map_or(stem, |(before, _)| before)
}

fn mentions_in_words(words: &[NameWord]) -> Vec<CopiesMention> {
    let mut mentions: Vec<CopiesMention> = Vec::new();
    let mut at = 0;
    while at < words.len() {
        let found = mention_in_pieces(words, at)
            .or_else(|| mention_before_number(words, at))
            .or_else(|| mention_by_times(words, at))
            .or_else(|| unclear_mention(words, at));
        if let Some((mention, length)) = found {
            mentions.push(mention);
            at += length;
        } else {
            at += 1;
        }
    }
    mentions
}

/// Parses a number of copies; words for pieces may have a leading zero.
fn parse_copies(digits: &str) -> Option<u32> {
    digits.parse().ok().filter(|copies| (1..=MAX_COPIES).contains(copies))
}

fn in_words(words: &[NameWord], at: usize, length: usize, copies: Option<u32>) -> Option<(CopiesMention, usize)> {
    Some((CopiesMention { copies, text: shown_words(words, at, length), is_in_words: true }, length))
}

/// Splits a word such as `4pcs` into its number and the rest. The number may have signs for thousands.
fn split_leading_number(word: &str) -> (&str, &str) {
    word.split_at(word.bytes().take_while(|b| b.is_ascii_digit() || matches!(b, b'.' | b',' | b'\'')).count())
}

fn is_pieces(word: &str) -> bool {
    is_word_of(WordKind::Pieces, word) || is_word_of(WordKind::PiecesAtEdge, word)
}

/// `4pcs`, `4 pcs`, `4個`, `x4 pcs`.
fn mention_in_pieces(words: &[NameWord], at: usize) -> Option<(CopiesMention, usize)> {
    let word = words[at].text.as_str();
    let (digits, rest) = split_leading_number(word.strip_prefix(['x', '×']).unwrap_or(word));
    if !digits.starts_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let copies = parse_copies(digits).filter(|_| !is_doubtful_number(words, at));
    if !rest.is_empty() {
        // `1st` and `21st` are ordinal numbers.
        let is_ordinal = rest == "st" && digits.ends_with('1');
        let is_clear = is_pieces(rest)
            || is_word_of(WordKind::WantsNumber, rest)
            || is_word_of(WordKind::AttachedPieces, rest) && !is_ordinal;
        let may_be = !is_ordinal && is_word_of(WordKind::MaybePieces, rest) || rest.starts_with(is_counter);
        let is_group = rest == "er" && words.get(at + 1).is_some_and(|next| is_word_of(WordKind::Group, &next.text));
        return match (is_clear, may_be || is_group) {
            (true, _) => in_words(words, at, 1, copies),
            (_, true) => in_words(words, at, 1, None),
            _ => None,
        };
    }
    let next = words.get(at + 1)?;
    let is_followed_by_number = words.get(at + 2).is_some_and(|word| word.number().is_some());
    if is_word_of(WordKind::MaybePieces, &next.text) || next.text == "of" && !is_followed_by_number {
        return in_words(words, at, 2, None);
    }
    // `12 qty`, but not `12 qty 5`.
    let is_qty = is_word_of(WordKind::WantsNumber, &next.text) && !is_followed_by_number;
    if !is_pieces(&next.text) && !is_qty {
        return None;
    }
    // `3_Stk_5` may be three or five, `10 mal 20` is a size.
    let is_at_edge = at == 0 || (at + 2..words.len()).all(|at| is_tail_word(words, at));
    let is_factor =
        TIMES.contains(&next.text.as_str()) && words.iter().any(|word| is_word_of(WordKind::Scale, &word.text));
    let is_phrase = words.get(at + 2).is_some_and(|word| PHRASE_ENDS.contains(&word.text.as_str()));
    let is_other = is_followed_by_number || is_factor || is_phrase;
    let is_clear = !is_other && (is_at_edge || is_qty || is_word_of(WordKind::Pieces, &next.text));
    in_words(words, at, 2, copies.filter(|_| is_clear))
}

/// `qty6`, `qty 6`, `qty=6`, `qty 6 pcs`.
fn mention_before_number(words: &[NameWord], at: usize) -> Option<(CopiesMention, usize)> {
    let word = words[at].text.as_str();
    let letters = word.split(|c: char| c.is_ascii_digit()).next().unwrap_or_default();
    let next = words.get(at + 1);
    let is_equal = next.is_some_and(|next| next.gap.trim() == "=" && next.number().is_some());
    // A letter n is a number of copies only in n=4, and `PZ2` is a screwdriver's bit.
    let is_other = letters == "n" && !is_equal || letters == "pz" && letters != word;
    if word_before_number(letters).is_some() && !is_other {
        let number_at = if letters == word { at + 1 } else { at };
        let number = words.get(number_at).map_or("", |next| next.text.strip_prefix(letters).unwrap_or(&next.text));
        let (digits, rest) = split_leading_number(number);
        if is_digits(digits) && (rest.is_empty() || is_pieces(rest) || is_word_of(WordKind::AttachedPieces, rest)) {
            let has_pieces = rest.is_empty()
                && words.get(number_at + 1).is_some_and(|word| is_pieces(&word.text) || word.text == "x");
            // `PZ 2` may be the bit, `pz. 2` are two pieces.
            let may_be_bit = letters == "pz" && words[number_at].gap.chars().all(char::is_whitespace);
            let copies = parse_copies(digits).filter(|_| !may_be_bit);
            return in_words(words, at, number_at - at + 1 + usize::from(has_pieces), copies);
        }
        if letters == word && is_word_of(WordKind::WantsNumber, letters) {
            return in_words(words, at, 1, None);
        }
    }
    // `bracket=4`
    if is_equal { in_words(words, at, 2, None) } else { None }
}

/// `x4`, `4x`, `×4`, and `x 4` or `4 x` with blanks.
fn mention_by_times(words: &[NameWord], at: usize) -> Option<(CopiesMention, usize)> {
    let word = words[at].text.as_str();
    let (digits, length) = match times_digits(word) {
        Some(digits) => (digits.to_owned(), 1),
        None => (lone_times_digits(words, at)?, 2),
    };
    let is_sign = words[at..at + length].iter().any(|word| word.text.contains('×'));
    let is_before_name = !words[at].text.starts_with(['x', '×']) && at == 0 && at + length < words.len();
    let is_behind_name = at > 0 && (at + length..words.len()).all(|at| is_tail_word(words, at));
    let is_axis = |word: &NameWord, axis: char| word.text.starts_with(axis) && is_digits(&word.text[1..]);
    let has_axis = |words: &[NameWord], axis: char| words.iter().any(|word| is_axis(word, axis));
    // `x10_y20` and `x10_z20` are places, `m1_z20_x10` is a gear.
    if words[at].text.starts_with('x') && (has_axis(words, 'y') || has_axis(&words[at..], 'z')) {
        return None;
    }
    let is_factor = words.iter().any(|word| is_word_of(WordKind::Scale, &word.text));
    // `2×M3` are two holes.
    let is_of_thread = words.get(at + length).is_some_and(|next| {
        next.gap.is_empty()
            && next.text.strip_prefix('m').is_some_and(|size| size.starts_with(|c: char| c.is_ascii_digit()))
    });
    let is_joined = length == 1 || words[at + 1].gap.chars().all(char::is_whitespace);
    // `No 5 x 2` may be two of number 5, or a size.
    let is_between_numbers = length == 2 && words[at].number().is_none() && at > 0 && words[at - 1].number().is_some();
    // `M3 x 20`, `M3 screw x 20` and `6x 8mm` may be sizes.
    let is_size_before = continues_size(words, at) || length == 2 && follows_any_size(words, at);
    let is_of_size = words[at].text.starts_with(['x', '×']) && is_size_before
        || is_before_name && completes_size(words, at + length);
    let is_clear = (is_before_name || is_behind_name || is_sign && words.len() > length)
        && !is_factor
        && !is_of_thread
        && !is_of_size
        && !is_between_numbers
        && !is_number_of_held(words, at, at + length)
        && is_joined
        && !digits.starts_with('0');
    let copies = parse_copies(&digits).filter(|_| is_clear);
    Some((CopiesMention { copies, text: shown_words(words, at, length), is_in_words: false }, length))
}

/// The digits of `x4` or `4x`. A decimal number such as x1.5 is returned too, though it is no number of copies.
fn times_digits(word: &str) -> Option<&str> {
    let digits = word.strip_prefix(['x', '×']).or_else(|| word.strip_suffix(['x', '×']))?;
    let is_number = digits.starts_with(|c: char| c.is_ascii_digit())
        && digits.bytes().all(|b| b.is_ascii_digit() || b == b'.' || b == b',');
    is_number.then_some(digits)
}

/// The digits of `x 4` or `4 x`, unless it is a size such as `20 x 30`.
fn lone_times_digits(words: &[NameWord], at: usize) -> Option<String> {
    let is_times = |word: &NameWord| matches!(word.text.as_str(), "x" | "×");
    let is_number = |word: Option<&NameWord>| word.is_some_and(|word| word.number().is_some());
    let next = words.get(at + 1)?;
    let before = at.checked_sub(1).map(|at| &words[at]);
    if is_times(&words[at]) {
        let has_pieces = words.get(at + 2).is_some_and(|word| is_pieces(&word.text));
        let is_size = is_number(before) && !is_number_of_thing(words, at - 1);
        return next.number().filter(|_| !is_size && !has_pieces).map(str::to_owned);
    }
    let is_size = is_number(words.get(at + 2)) || before.is_some_and(is_times);
    words[at].number().filter(|_| is_times(next) && !is_size).map(str::to_owned)
}

/// Words that may mean a number of copies but never do so clearly: `bracketx4`, `4xbracket`, `lot de 4`, `three pieces`.
fn unclear_mention(words: &[NameWord], at: usize) -> Option<(CopiesMention, usize)> {
    let word = words[at].text.as_str();
    let next = words.get(at + 1).map(|next| next.text.as_str());
    let is_number_next = words.get(at + 1).is_some_and(|word| word.number().is_some());
    if is_word_before_x(word) || is_x_before_word(word) || is_x_behind_word(word) || is_x_behind_version(word) {
        return Some((CopiesMention { copies: None, text: word.to_owned(), is_in_words: false }, 1));
    }
    if is_pieces_behind_word(word) {
        return in_words(words, at, 1, None);
    }
    let is_last_no = next == Some("no") && words[at].number().is_some() && at + 2 == words.len();
    if is_word_of(WordKind::Repeat, word) || is_east_asian_count(word) || is_last_no {
        return in_words(words, at, 1 + usize::from(is_last_no), None);
    }
    let is_number_word = |word: &str| is_word_of(WordKind::NumberWord, word);
    if is_number_word(word) && next.is_some_and(is_pieces)
        || word == "x" && next.is_some_and(is_number_word)
        || is_word_of(WordKind::Ask, word) && is_number_next
    {
        return in_words(words, at, 2, None);
    }
    let is_group = is_word_of(WordKind::Group, word) && next.is_some_and(|next| is_word_of(WordKind::Of, next));
    let is_of_number = words.get(at + 2).is_some_and(|word| word.number().is_some());
    let length = if is_group && is_of_number { Some(3) } else { group_length(words, at) };
    in_words(words, at, length?, None)
}

/// `bracketx4`, but not `matrix4`.
fn is_word_before_x(word: &str) -> bool {
    let letters = word.trim_end_matches(|c: char| c.is_ascii_digit());
    let digits = word.len() - letters.len();
    let Some(before) = letters.strip_suffix('x') else { return false };
    (1..=MAX_DIGITS_BEHIND_WORD).contains(&digits)
        && before.chars().count() >= MIN_LETTERS_BEFORE_X
        && before.chars().all(char::is_alphabetic)
        && !ends_in_own_x(letters)
}

/// `bracket4x`, but not `v10x`.
fn is_x_behind_word(word: &str) -> bool {
    let Some(rest) = word.strip_suffix('x') else { return false };
    let letters = rest.trim_end_matches(|c: char| c.is_ascii_digit());
    (1..=MAX_DIGITS_BEHIND_WORD).contains(&(rest.len() - letters.len()))
        && letters.chars().count() >= MIN_LETTERS_BEFORE_X
        && letters.chars().all(char::is_alphabetic)
}

/// `bracket4pcs` and `bracketQty4` may be four brackets.
fn is_pieces_behind_word(word: &str) -> bool {
    let bare = word.trim_end_matches(|c: char| c.is_ascii_digit());
    if bare.len() < word.len() && bare.len() > MIN_LETTERS_BEFORE_X && bare.ends_with("qty") {
        return true;
    }
    let head = word.trim_end_matches(|c: char| !c.is_ascii_digit());
    let letters = head.trim_end_matches(|c: char| c.is_ascii_digit());
    (1..=MAX_DIGITS_BEHIND_WORD).contains(&(head.len() - letters.len()))
        && letters.chars().count() >= MIN_LETTERS_BEFORE_X
        && letters.chars().all(char::is_alphabetic)
        && is_word_of(WordKind::Pieces, &word[head.len()..])
}

/// `ver2x4` may be four of version 2.
fn is_x_behind_version(word: &str) -> bool {
    let is_version = |head: &str| {
        let letters = head.trim_end_matches(|c: char| c.is_ascii_digit());
        letters.len() < head.len() && ["v", "ver", "rev"].iter().any(|version| letters.ends_with(version))
    };
    word.split_once(['x', '×']).is_some_and(|(head, tail)| is_digits(tail) && is_version(head))
}

/// `4xbracket`, `2xM3`, but not a size such as `2xl` or `2x4`.
fn is_x_before_word(word: &str) -> bool {
    let (digits, rest) = word.split_at(word.bytes().take_while(u8::is_ascii_digit).count());
    let Some(rest) = rest.strip_prefix('x') else { return false };
    (1..=MAX_DIGITS_BEHIND_WORD).contains(&digits.len())
        && rest.chars().count() >= 2
        && rest.starts_with(char::is_alphabetic)
}

#[cfg(test)]
#[path = "tests/copies_tests.rs"]
mod tests;
