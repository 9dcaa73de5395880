//! What a search in the book finds: the sections that hold all words, those with the words in their headings first.

use super::markdown::{BOOK, ReadChapter, Section};

/// Words of a question that count.
const MAX_WORDS: usize = 10;
/// Characters of a snippet before and behind the first word.
const SNIPPET: (usize, usize) = (60, 160);

/// A section that a search has found.
#[derive(Debug)]
pub(super) struct FoundSection {
    /// Its chapter.
    pub(super) chapter: &'static ReadChapter,
    /// The section.
    pub(super) section: &'static Section,
    /// A piece of its text: words, and whether each piece was asked for.
    pub(super) snippet: Vec<(String, bool)>,
}

/// Letters in lower case, one for each.
fn lower(text: &str) -> Vec<char> {
    text.chars().map(|c| c.to_lowercase().next().unwrap_or(c)).collect()
}

fn position_of(word: &[char], text: &[char]) -> Option<usize> {
    text.windows(word.len()).position(|window| window == word)
}

/// The sections that hold all words of a question in heading or text.
pub(super) fn find_sections(question: &str) -> Vec<FoundSection> {
    let words: Vec<Vec<char>> = question.split_whitespace().take(MAX_WORDS).map(lower).collect();
    if words.is_empty() {
        return Vec::new();
    }
    let mut found: Vec<(usize, FoundSection)> = Vec::new();
    for chapter in BOOK.iter() {
        for section in &chapter.sections {
            let (title, text) = (lower(&section.title), lower(&section.text));
            let in_title = words.iter().filter(|word| position_of(word, &title).is_some()).count();
            if words.iter().all(|word| position_of(word, &title).is_some() || position_of(word, &text).is_some()) {
                let snippet = snippet_of(&section.text, &text, &words);
                found.push((in_title, FoundSection { chapter, section, snippet }));
            }
        }
    }
    // The sort is stable: the order of the book decides between equals.
    found.sort_by_key(|(in_title, _)| words.len() - in_title);
    found.into_iter().map(|(_, found)| found).collect()
}

/// The piece of a text around the first of the words; `folded` is the text in lower case.
fn snippet_of(text: &str, folded: &[char], words: &[Vec<char>]) -> Vec<(String, bool)> {
    let first = words.iter().filter_map(|word| position_of(word, folded)).min().unwrap_or_default();
    let plain: Vec<char> = text.chars().collect();
    let is_blank = |c: &char| c.is_whitespace();
    // Whole words, where there is a blank to begin or to end at.
    let (from, until) = (first.saturating_sub(SNIPPET.0), plain.len().min(first + SNIPPET.1));
    let from = if from == 0 { 0 } else { from + plain[from..first].iter().position(is_blank).map_or(0, |at| at + 1) };
    let until = if until == plain.len() {
        until
    } else {
        first + plain[first..until].iter().rposition(is_blank).unwrap_or(until - first)
    };
    let mut pieces: Vec<(String, bool)> = vec![((if from > 0 { ".. " } else { "" }).to_owned(), false)];
    let mut at = from;
    while at < until {
        let long = words.iter().filter(|word| folded[at..].starts_with(word)).map(Vec::len).max();
        let end = at + long.unwrap_or(1);
        let piece = plain[at..end].iter();
        match pieces.last_mut().filter(|(_, is_asked)| *is_asked == long.is_some()) {
            Some((last, _)) => last.extend(piece),
            None => pieces.push((piece.collect(), long.is_some())),
        }
        at = end;
    }
    pieces
}
