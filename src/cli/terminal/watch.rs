//! `nestd status --watch`: redraws a text in place on a terminal.

use std::{
    io::{IsTerminal, Write},
    time::Duration,
};

use anyhow::{Context, Result};

use super::terminal::terminal_size;
use crate::cli::UsageError;

/// Time between two redraws.
const REDRAW_INTERVAL: Duration = Duration::from_secs(2);

/// Shows the text that `look` returns for the terminal's columns, again and again, until Ctrl-C. Errors after the first
/// call are shown as text, because a daemon may just be restarting.
pub fn watch_terminal(mut look: impl FnMut(usize) -> Result<String>) -> Result<()> {
    let mut terminal = std::io::stdout();
    if !terminal.is_terminal() {
        return Err(
            UsageError("--watch redraws a terminal, and standard output is none: leave it out".to_owned()).into()
        );
    }
    let mut text = look(terminal_size().0)?;
    let mut before = "\x1b[2J";
    loop {
        write!(terminal, "{before}{}", format_frame(&text, terminal_size())).context("writing to the terminal")?;
        terminal.flush().context("writing to the terminal")?;
        before = "";
        std::thread::sleep(REDRAW_INTERVAL);
        text = look(terminal_size().0).unwrap_or_else(|error| format!("{error:#}\n"));
    }
}

/// A text that overwrites the previous frame and fits the terminal, so that nothing scrolls.
fn format_frame(text: &str, (columns, rows): (usize, usize)) -> String {
    let cut = |line: &str| line.chars().take(columns).collect::<String>();
    let room = rows.saturating_sub(1).max(1);
    let mut lines: Vec<String> = text.lines().flat_map(|line| wrap_line(line, columns)).collect();
    if lines.len() > room {
        lines.truncate(room - 1);
        lines.push(cut("... (the terminal is too low for the rest)"));
    }
    let body: String = lines.iter().map(|line| format!("{line}\x1b[K\r\n")).collect();
    format!("\x1b[H{body}{}\x1b[J", cut("Every 2 s; Ctrl-C ends."))
}

/// Wraps a line to the width of the terminal: between words where possible, with the continuation lines indented.
fn wrap_line(line: &str, columns: usize) -> Vec<String> {
    let mut rest: Vec<char> = line.trim_end().chars().collect();
    let indent = rest.iter().take_while(|c| **c == ' ').count();
    let further = if indent + 2 < columns / 2 { indent + 2 } else { 0 };
    let (mut lines, mut begins) = (Vec::new(), indent);
    while rest.len() > columns {
        let space = (begins + 1..=columns).rev().find(|&at| rest[at] == ' ');
        let piece: String = rest.drain(..space.unwrap_or(columns)).collect();
        lines.push(piece.trim_end().to_owned());
        let words = rest.iter().position(|c| *c != ' ').unwrap_or(rest.len());
        rest.splice(..words, vec![' '; further]);
        begins = further;
    }
    lines.push(rest.into_iter().collect());
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_fits_the_terminal_and_leaves_nothing_of_the_one_before() {
        let text = format_frame("first line\nsecond\n", (6, 24));
        assert_eq!(text, "\x1b[Hfirst\x1b[K\r\n  line\x1b[K\r\nsecond\x1b[K\r\nEvery \x1b[J");
        let low = format_frame("a\nb\nc\nd\ne\n", (80, 4));
        assert_eq!(low.matches("\r\n").count(), 3, "three lines and the hint: {low:?}");
        assert!(low.contains("a\x1b[K\r\nb") && !low.contains("\r\nc") && low.contains("too low"));
    }

    #[test]
    fn a_line_that_is_too_wide_goes_on_below_and_loses_nothing() {
        assert_eq!(wrap_line("as wide", 7), ["as wide"]);
        assert_eq!(wrap_line("", 7), [""]);
        assert_eq!(wrap_line("  NEXT BUILD: 55.61 mm, 11 copies", 20), ["  NEXT BUILD: 55.61", "    mm, 11 copies"]);
        assert_eq!(wrap_line("a  b", 2), ["a", "b"]);
        let name = "  größe-und-noch-viel-mehr-ohne-jedes-leerzeichen.stl is refused";
        for columns in 1..70 {
            let lines = wrap_line(name, columns);
            assert!(lines.iter().all(|line| line.chars().count() <= columns), "{columns}: {lines:?}");
            let letters = |text: &str| text.replace(' ', "");
            assert_eq!(letters(&lines.concat()), letters(name), "{columns}");
        }
    }
}
