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

/// Shows what `look` gives, over and over, until somebody ends it with Ctrl-C. What fails later than the first time is shown,
/// too: a daemon that starts again is waited for.
pub fn watch(mut look: impl FnMut() -> Result<String>) -> Result<()> {
    let mut terminal = std::io::stdout();
    if !terminal.is_terminal() {
        return Err(Usage("--watch redraws a terminal, and standard output is none: leave it away".to_owned()).into());
    }
    let mut text = look()?;
    let mut before = "\x1b[2J";
    loop {
        write!(terminal, "{before}{}", frame(&text, size())).context("writing to the terminal")?;
        terminal.flush().context("writing to the terminal")?;
        before = "";
        std::thread::sleep(EVERY);
        text = look().unwrap_or_else(|error| format!("{error:#}\n"));
    }
}

/// Columns and rows of the terminal.
fn size() -> (usize, usize) {
    match rustix::termios::tcgetwinsize(std::io::stdout()) {
        Ok(size) if size.ws_col > 0 && size.ws_row > 0 => (size.ws_col.into(), size.ws_row.into()),
        _ => USUAL,
    }
}

/// A text over what was shown before, cut to the terminal: no line wraps, and nothing scrolls.
fn frame(text: &str, (columns, rows): (usize, usize)) -> String {
    let hint = "Every 2 s; Ctrl-C ends.";
    let room = rows.saturating_sub(1).max(1);
    let cut = |line: &str| line.chars().take(columns).collect::<String>();
    let mut lines: Vec<String> = text.lines().map(cut).collect();
    if lines.len() > room {
        lines.truncate(room - 1);
        lines.push(cut("... (the terminal is too low for the rest)"));
    }
    let body: String = lines.iter().map(|line| format!("{line}\x1b[K\r\n")).collect();
    format!("\x1b[H{body}{}\x1b[J", cut(hint))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_fits_the_terminal_and_leaves_nothing_of_the_one_before() {
        let text = frame("first line\nsecond\n", (6, 24));
        assert_eq!(text, "\x1b[Hfirst \x1b[K\r\nsecond\x1b[K\r\nEvery \x1b[J");
        let low = frame("a\nb\nc\nd\ne\n", (80, 4));
        assert_eq!(low.matches("\r\n").count(), 3, "three lines and the hint: {low:?}");
        assert!(low.contains("a\x1b[K\r\nb") && !low.contains("\r\nc") && low.contains("too low"));
    }
}
