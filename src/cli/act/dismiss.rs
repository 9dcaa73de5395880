//! `nestd dismiss`: a person has seen to a profile's refused files, or to a failed print.

use anyhow::{Context, Result};
use ledger::BuildId;

use crate::{
    cli::{
        CommandExit, CommonArgs,
        terminal::{
            farm_context::{load_settings, require_profile, user_at_host, with_ledger},
            table::print_text,
            values::parse_prefixed_number,
        },
    },
    farm,
};

/// Dismisses the files in the error folder of the profile, or the failed print of a build (`b4`).
pub fn run(common: &CommonArgs, what: &str) -> Result<CommandExit> {
    let settings = load_settings(common)?;
    let build = parse_prefixed_number(what, 'b').filter(|_| !settings.profiles.contains_key(what));
    if let Some(build) = build.map(BuildId) {
        with_ledger(common, async |_, ledger| Ok(ledger.mark_failure_seen(build, &user_at_host()).await?))?;
        print_text(&format!("The failed print of build {build} is dismissed; its copies are as they were."))?;
        return Ok(CommandExit::Success);
    }
    require_profile(&settings, what)?;
    let error_dir = &settings.profiles[what].folders.error;
    farm::dismiss_refused(error_dir).with_context(|| format!("writing into {}", error_dir.display()))?;
    print_text(&format!("The refused files stay in {}; they raise no alert any more.", error_dir.display()))?;
    Ok(CommandExit::Success)
}
