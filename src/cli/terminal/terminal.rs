//! What the terminal is: how wide, and whether it shows colours.

use std::{io::IsTerminal, os::fd::AsFd};

use crate::web::Tone;

/// Size of a terminal whose size is unknown, and of a pipe: columns and rows.
const DEFAULT_SIZE: (usize, usize) = (80, 24);

/// Columns and rows of the terminal.
pub fn terminal_size() -> (usize, usize) {
    match rustix::termios::tcgetwinsize(std::io::stdout()) {
        Ok(size) if size.ws_col > 0 && size.ws_row > 0 => (size.ws_col.into(), size.ws_row.into()),
        _ => DEFAULT_SIZE,
    }
}

/// Columns that an output may have: those of the terminal, 80 in a pipe, any number if `is_wide`.
pub fn output_columns(is_wide: bool) -> usize {
    if is_wide { usize::MAX } else { terminal_size().0 }
}

/// Columns of a stream that people look at; any number where it is no terminal, whose lines programs may look for.
pub fn columns_of(stream: &(impl IsTerminal + AsFd)) -> usize {
    match rustix::termios::tcgetwinsize(stream) {
        Ok(size) if stream.is_terminal() && size.ws_col > 0 => size.ws_col.into(),
        _ => usize::MAX,
    }
}

/// How a line is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinePaint {
    /// As any text.
    Plain,
    /// All is well.
    Good,
    /// Probably not as intended.
    Doubtful,
    /// A person must see to it.
    Bad,
}

/// Marks of a painted text on its way to the terminal: noncharacters, which no text of a customer may bring along.
const MARKS: [(char, LinePaint); 3] =
    [('\u{fdd0}', LinePaint::Good), ('\u{fdd1}', LinePaint::Doubtful), ('\u{fdd2}', LinePaint::Bad)];
/// The end of a painted text.
const MARK_END: char = '\u{fdd3}';

/// A text without its marks.
pub fn without_marks(text: &str) -> String {
    text.chars().filter(|c| !is_mark(*c)).collect()
}

/// Whether a letter is a mark, which takes no column.
pub fn is_mark(letter: char) -> bool {
    letter == MARK_END || MARKS.iter().any(|(mark, _)| *mark == letter)
}

/// A text with colours in the place of its marks if standard output shows colours, else without them.
pub fn show_marks(text: &str) -> String {
    if has_colours() { coloured(text) } else { without_marks(text) }
}

fn coloured(text: &str) -> String {
    let shown = |c: char| match MARKS.iter().find(|(mark, _)| *mark == c) {
        Some((_, paint)) => format!("\x1b[{}m", paint.code().unwrap_or("0")),
        None if c == MARK_END => "\x1b[0m".to_owned(),
        None => c.to_string(),
    };
    text.chars().map(shown).collect()
}

impl LinePaint {
    /// That of a state with this word.
    pub fn of_state(word: &str) -> Self {
        match Tone::of_word(word) {
            Tone::Good => Self::Good,
            Tone::Tight => Self::Doubtful,
            Tone::Wrong => Self::Bad,
            Tone::Busy | Tone::Next | Tone::Idle => Self::Plain,
        }
    }

    /// The text between marks, for what [`show_marks`] prints.
    pub fn mark(self, text: &str) -> String {
        match MARKS.iter().find(|(_, paint)| *paint == self) {
            Some((mark, _)) => format!("{mark}{text}{MARK_END}"),
            None => text.to_owned(),
        }
    }

    fn code(self) -> Option<&'static str> {
        match self {
            Self::Plain => None,
            Self::Good => Some("32"),
            Self::Doubtful => Some("33"),
            Self::Bad => Some("31"),
        }
    }
}

/// Whether standard output shows colours: a terminal, unless `NO_COLOR` is set (<https://no-color.org>) or it is a dumb one.
fn has_colours() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    std::io::stdout().is_terminal() && !is_set("NO_COLOR") && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// A text in lines of at most `columns` columns, broken at blanks; lines after the first begin with `indent` blanks. A word that is
/// longer stays whole, so that a path can be copied.
pub fn wrap_words(text: &str, columns: usize, indent: usize) -> String {
    let mut lines: Vec<String> = Vec::new();
    let mut width = 0;
    for word in text.split(' ') {
        let long = seen_width(word);
        match lines.last_mut() {
            Some(line) if width + 1 + long <= columns => {
                *line += &format!(" {word}");
                width += 1 + long;
            }
            Some(_) => {
                lines.push(format!("{}{word}", " ".repeat(indent)));
                width = indent + long;
            }
            None => {
                lines.push(word.to_owned());
                width = long;
            }
        }
    }
    lines.join("\n")
}

/// A text with no line of more columns, as far as its words allow it: what is wrapped stands below the text of its line. A line that is a
/// command stays whole, so that it can be copied.
pub fn fit_lines(text: &str, columns: usize) -> String {
    let fit = |line: &str| match seen_width(line) > columns && !line.trim_start().starts_with("nestd ") {
        true => wrap_words(line, columns, line.len() - line.trim_start().len() + 2),
        false => line.to_owned(),
    };
    text.split('\n').map(fit).collect::<Vec<_>>().join("\n")
}

/// Columns that a text takes.
pub fn seen_width(text: &str) -> usize {
    text.chars().map(letter_width).sum()
}

/// Columns that a letter takes: a mark none, those of Chinese, Japanese and Korean two (Unicode Standard Annex 11).
pub fn letter_width(letter: char) -> usize {
    match letter {
        ' '..='~' => 1,
        mark if is_mark(mark) => 0,
        '\u{1100}'..='\u{115f}'
        | '\u{2e80}'..='\u{a4cf}'
        | '\u{ac00}'..='\u{d7a3}'
        | '\u{f900}'..='\u{faff}'
        | '\u{fe30}'..='\u{fe6f}'
        | '\u{ff01}'..='\u{ff60}'
        | '\u{ffe0}'..='\u{ffe6}'
        | '\u{20000}'..='\u{3fffd}' => 2,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_line_is_wider_than_the_terminal_and_what_is_wrapped_stands_below_its_text() {
        let text = "Refused: the part is built already.\n  -> ask somebody who knows\n";
        let fitted = "Refused: the part\n  is built already.\n  -> ask somebody\n    who knows\n";
        assert_eq!(fit_lines(text, 19), fitted);
        assert_eq!(fit_lines(text, usize::MAX), text);
        let state = LinePaint::Bad.mark("down");
        assert_eq!(fit_lines(&format!("mjf {state}"), 8), format!("mjf {state}"), "marks take no column");
        assert_eq!(fit_lines("パーツ 待機", 6), "パーツ\n  待機");
    }

    #[test]
    fn words_are_wrapped_below_each_other_and_a_long_one_stays_whole() {
        let text = "  file        /a/very/long/path/of/a/file.stl of the build";
        let wrapped = "  file\n    /a/very/long/path/of/a/file.stl\n    of the build";
        assert_eq!(wrap_words("  file /a/very/long/path/of/a/file.stl of the build", 20, 4), wrapped);
        assert_eq!(wrap_words(text, usize::MAX, 4), text, "blanks stay where nothing is wrapped");
    }

    #[test]
    fn a_state_has_the_colour_of_its_tone_where_colours_are_shown() {
        let text = format!(
            "1182  {}  A-17  {}",
            LinePaint::of_state("late").mark("late"),
            LinePaint::of_state("open").mark("open")
        );
        assert_eq!(coloured(&text), "1182  \x1b[31mlate\x1b[0m  A-17  open");
        assert_eq!(without_marks(&text), "1182  late  A-17  open");
    }
}
