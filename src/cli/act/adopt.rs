//! `nestd adopt`: takes over a machine of another node, and the files that another nestd has claimed in its hot folder.

use anyhow::Result;

use crate::cli::{
    CommandExit, CommonArgs,
    terminal::{
        farm_context::{load_settings, require_machine, run_with_ledger, user_at_host},
        table::print_text,
    },
};

/// Runs the command.
pub fn run(common: &CommonArgs, machine: &str) -> Result<CommandExit> {
    let settings = load_settings(common)?;
    require_machine(&settings, machine)?;
    let node = settings.node.name.clone();
    if settings.ledger.file().is_none() {
        let before = run_with_ledger(settings.clone(), async |_, ledger| {
            Ok(ledger.adopt_machine(machine, &node, &user_at_host()).await?)
        })?;
        if let Some(before) = before {
            print_text(&format!(
                "The node {node} serves {machine} from now on, in place of {before}. Its daemon takes it up within a minute. Files \
                 that were taken in before are asked for again, as far as {before} does not give them."
            ))?;
        }
    }
    match farm::adopt_claims(&settings, &settings.profiles[machine])? {
        0 => print_text("No other nestd has claimed anything there.")?,
        1 => print_text("1 claim is taken over; the daemon takes it up within seconds.")?,
        claims => print_text(&format!("{claims} claims are taken over; the daemon takes them up within seconds."))?,
    }
    Ok(CommandExit::Success)
}
