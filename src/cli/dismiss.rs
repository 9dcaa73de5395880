//! `nestd dismiss`: marks the refused files of a profile as seen by a person.

use anyhow::{Context, Result};

use super::{
    CommandExit, CommonArgs,
    farm_context::{load_settings, require_profile},
    table::print_text,
};
use crate::farm;

/// Runs the command.
pub fn run(common: &CommonArgs, profile: &str) -> Result<CommandExit> {
    let settings = load_settings(common)?;
    require_profile(&settings, profile)?;
    let error_dir = &settings.profiles[profile].folders.error;
    farm::dismiss_refused(error_dir).with_context(|| format!("writing into {}", error_dir.display()))?;
    print_text(&format!("The refused files stay in {}; they raise no alert any more.", error_dir.display()))?;
    Ok(CommandExit::Success)
}
