//! `nestd check`.

use anyhow::Result;

use super::{Common, Exit};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Runs the command.
pub fn run(_common: &Common, _args: &Args) -> Result<Exit> {
    Ok(Exit::Success)
}
