//! `nestd completions` and `nestd man`: what a shell and `man` know of the command line, made from its own description.

use std::{io::Write, path::PathBuf};

use anyhow::{Context, Result};
use build_file::format_count;
use clap::Command;
use clap_complete::{Shell, env::Shells};

use crate::cli::{CommandExit, terminal::table::print_text};

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

/// Writes the manual pages into a folder.
pub fn write_manual(command: Command, folder: &PathBuf) -> Result<CommandExit> {
    std::fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
    clap_mangen::generate_to(command, folder).with_context(|| format!("writing into {}", folder.display()))?;
    let pages = std::fs::read_dir(folder)?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let pages = pages.filter(|name| name.starts_with("nestd") && name.ends_with(".1")).count();
    print_text(&format!(
        "{} in {}: man -l {}",
        format_count(pages, "page", "pages"),
        folder.display(),
        folder.join("nestd.1").display()
    ))?;
    Ok(CommandExit::Success)
}
