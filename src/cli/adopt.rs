//! `nestd adopt`: takes over what another farm has claimed.

use anyhow::Result;

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
    match farm::adopt(&settings, &settings.profiles[profile])? {
        0 => say("No other nestd has claimed anything there.")?,
        1 => say("1 claim is taken over; the daemon takes it up within seconds.")?,
        claims => say(&format!("{claims} claims are taken over; the daemon takes them up within seconds."))?,
    }
    Ok(Exit::Success)
}
