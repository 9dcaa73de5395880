//! `nestd dismiss`: a person has seen to a machine's refused files, or to a failed print.

use anyhow::{Context, Result};
use ledger::{BuildId, OperatorWord};

use super::operate::say;
use crate::cli::{
    CommandExit, CommonArgs,
    terminal::{
        farm_context::{load_settings, require_machine},
        table::print_text,
        values::parse_prefixed_number,
    },
};

/// Dismisses the files in the error folder of the machine, or the failed print of a build (`b4`).
pub fn run(common: &CommonArgs, what: &str) -> Result<CommandExit> {
    let settings = load_settings(common)?;
    let build = parse_prefixed_number(what, 'b').filter(|_| !settings.profiles.contains_key(what));
    if let Some(build) = build.map(BuildId) {
        return say(common, &[OperatorWord::SeenTo(build)], false);
    }
    require_machine(&settings, what)?;
    let error_dir = &settings.profiles[what].folders.error;
    farm::dismiss_refused(error_dir).with_context(|| format!("writing into {}", error_dir.display()))?;
    print_text(&format!("The refused files stay in {}; they raise no alert any more.", error_dir.display()))?;
    Ok(CommandExit::Success)
}
