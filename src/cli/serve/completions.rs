//! `nestd completions`: what a shell knows of the command line, made from its own description.

use std::io::Write;

use anyhow::{Context, Result};
use clap_complete::{Shell, env::Shells};

use crate::cli::CommandExit;

/// The variable that says for which shell a word is completed.
const COMPLETE_VARIABLE: &str = "COMPLETE";

/// Prints what a shell runs to complete a word: it asks nestd, which knows the machines, builds and parts of the farm.
pub fn print_completions(shell: Shell) -> Result<CommandExit> {
    let (name, shells) = (shell.to_string(), Shells::builtins());
    let completer = shells.completer(&name).with_context(|| format!("no completions for {name}"))?;
    let mut script = Vec::new();
    completer.write_registration(COMPLETE_VARIABLE, "nestd", "nestd", "nestd", &mut script)?;
    std::io::stdout().write_all(&script).context("cannot print")?;
    Ok(CommandExit::Success)
}
