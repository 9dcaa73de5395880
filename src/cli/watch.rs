//! `nestd status --watch`: a text that is redrawn in place on a terminal.

use std::{
    io::{IsTerminal, Write},
    time::Duration,
};

use anyhow::{Context, Result};

use super::Usage;

/// Between two looks.
const EVERY: Duration = Duration::from_secs(2);
/// Where the terminal does not tell its size.
const USUAL: (usize, usize) = (80, 24);

/// Shows what `look` gives for so many columns, over and over, until somebody ends it with Ctrl-C. What fails later than the first time is shown,
/// too: a daemon that starts again is waited for.
pub fn watch(mut look: impl FnMut(usize) -> Result<String>) -> Result<()> {
    let mut terminal = std::io::stdout();
    if !terminal.is_terminal() {
        return Err(Usage("--watch redraws a terminal, and standard output is none: leave it away".to_owned()).into());
    }
    let mut text = look(size().0)?;
    let mut before = "\x1b[2J";
    loop {
        write!(terminal, "{before}{}", frame(&text, size())).context("writing to the terminal")?;
        terminal.flush().context("writing to the terminal")?;
        before = "";
        std::thread::sleep(EVERY);
        text = look(size().0).unwrap_or_else(|error| format!("{error:#}\n"));
    }
}

/// Columns and rows of the terminal.
fn size() -> (usize, usize) {
    match rustix::termios::tcgetwinsize(std::io::stdout()) {
        Ok(size) if size.ws_col > 0 && size.ws_row > 0 => (size.ws_col.into(), size.ws_row.into()),
        _ => USUAL,
    }
}

/// A text over what was shown before, within the terminal: nothing scrolls.
fn frame(text: &str, (columns, rows): (usize, usize)) -> String {
    let cut = |line: &str| line.chars().take(columns).collect::<String>();
    let room = rows.saturating_sub(1).max(1);
    let mut lines: Vec<String> = text.lines().flat_map(|line| wrapped(line, columns)).collect();
    if lines.len() > room {
        lines.truncate(room - 1);
        lines.push(cut("... (the terminal is too low for the rest)"));
    }
    let body: String = lines.iter().map(|line| format!("{line}\x1b[K\r\n")).collect();
    format!("\x1b[H{body}{}\x1b[J", cut("Every 2 s; Ctrl-C ends."))
}

/// A line in pieces that fit: broken between words where there are some, and further in from the second on.
fn wrapped(line: &str, columns: usize) -> Vec<String> {
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
        let text = frame("first line\nsecond\n", (6, 24));
        assert_eq!(text, "\x1b[Hfirst\x1b[K\r\n  line\x1b[K\r\nsecond\x1b[K\r\nEvery \x1b[J");
        let low = frame("a\nb\nc\nd\ne\n", (80, 4));
        assert_eq!(low.matches("\r\n").count(), 3, "three lines and the hint: {low:?}");
        assert!(low.contains("a\x1b[K\r\nb") && !low.contains("\r\nc") && low.contains("too low"));
    }

    #[test]
    fn a_line_that_is_too_wide_goes_on_below_and_loses_nothing() {
        assert_eq!(wrapped("as wide", 7), ["as wide"]);
        assert_eq!(wrapped("", 7), [""]);
        assert_eq!(wrapped("  NEXT BUILD: 55.61 mm, 11 copies", 20), ["  NEXT BUILD: 55.61", "    mm, 11 copies"]);
        assert_eq!(wrapped("a  b", 2), ["a", "b"]);
        let name = "  größe-und-noch-viel-mehr-ohne-jedes-leerzeichen.stl is refused";
        for columns in 1..70 {
            let lines = wrapped(name, columns);
            assert!(lines.iter().all(|line| line.chars().count() <= columns), "{columns}: {lines:?}");
            let letters = |text: &str| text.replace(' ', "");
            assert_eq!(letters(&lines.concat()), letters(name), "{columns}");
        }
    }
}
