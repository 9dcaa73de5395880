//! `nestd adopt`: takes over the files that another nestd has claimed.

use anyhow::Result;

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
    match farm::adopt_claims(&settings, &settings.profiles[profile])? {
        0 => print_text("No other nestd has claimed anything there.")?,
        1 => print_text("1 claim is taken over; the daemon takes it up within seconds.")?,
        claims => print_text(&format!("{claims} claims are taken over; the daemon takes them up within seconds."))?,
    }
    Ok(CommandExit::Success)
}
