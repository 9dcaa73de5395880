//! `nestd dismiss`: a person has seen what was refused.

use anyhow::{Context, Result};

use super::{
    Common, Exit,
    reach::{demand_profile, settings},
    table::say,
};
use crate::farm;

/// Runs the command.
pub fn run(common: &Common, profile: &str) -> Result<Exit> {
    let settings = settings(common)?;
    demand_profile(&settings, profile)?;
    let error_dir = &settings.profiles[profile].folders.error;
    farm::dismiss(error_dir).with_context(|| format!("writing into {}", error_dir.display()))?;
    say(&format!("What was refused so far stays in {}; nobody is told of it any more.", error_dir.display()))?;
    Ok(Exit::Success)
}
