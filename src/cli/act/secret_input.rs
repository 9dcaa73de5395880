//! Passwords and PINs that a person types: twice, and not shown; or one line of what is piped in.

use std::io::{BufRead, IsTerminal, Write};

use anyhow::{Context, Result};
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcsetattr};

use crate::cli::UsageError;

/// Keeps a terminal from showing what is typed, until it is dropped.
struct HiddenTyping(Termios);

impl HiddenTyping {
    fn begin() -> Result<Self> {
        let before = tcgetattr(std::io::stdin()).context("asking the terminal how it is set")?;
        let mut hidden = before.clone();
        hidden.local_modes.remove(LocalModes::ECHO);
        tcsetattr(std::io::stdin(), OptionalActions::Flush, &hidden).context("keeping the terminal from showing it")?;
        Ok(Self(before))
    }
}

impl Drop for HiddenTyping {
    fn drop(&mut self) {
        _ = tcsetattr(std::io::stdin(), OptionalActions::Now, &self.0);
    }
}

/// Reads a secret: `what` it is, such as "password of anna".
pub(super) fn read_secret(what: &str) -> Result<String> {
    if !std::io::stdin().is_terminal() {
        return read_line();
    }
    let first = ask(&format!("New {what}: "))?;
    if first != ask("Once more: ")? {
        return Err(UsageError("the two are not the same: give the command again".to_owned()).into());
    }
    Ok(first)
}

fn ask(question: &str) -> Result<String> {
    let hidden = HiddenTyping::begin()?;
    eprint!("{question}");
    std::io::stderr().flush()?;
    let line = read_line();
    drop(hidden);
    eprintln!();
    line
}

fn read_line() -> Result<String> {
    let mut line = String::new();
    std::io::stdin().lock().read_line(&mut line).context("reading it")?;
    Ok(line.trim_end_matches(['\n', '\r']).to_owned())
}
