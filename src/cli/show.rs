//! `nestd show`: a build, a part or an order, with everything that the ledger knows of it.

use anyhow::Result;

use super::{
    Common, Exit,
    lookup::{Wanted, look},
    reach::look_at_ledger,
    show_text,
    table::{say, say_json, tell},
};
use crate::settings::Profile;

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// 'build 42' or b42, 'part 7' or p7, 'part FILE', 'order NAME', or just a number or a name: then everything of that name
    #[arg(required = true, num_args = 1.., value_name = "BUILD|PART|ORDER")]
    what: Vec<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(common: &Common, args: &Args) -> Result<Exit> {
    let wanted = Wanted::parse(&args.what);
    let found = look_at_ledger(common, async |settings, ledger| {
        let mut found = look(ledger, &wanted).await?;
        if let Some(sheet) = &mut found.build {
            let build = &sheet.build;
            let now = settings.profiles.get(&build.profile);
            let folder = now.map(|profile| profile.folders.queue.clone());
            sheet.file = folder.zip(build.staged.file_name.as_ref()).map(|(folder, name)| folder.join(name));
            sheet.machine = Some(Profile::then(&build.profile, build.kept.profile_snapshot.as_deref(), now));
        }
        Ok(found)
    })?;
    if found.is_empty() {
        // Whoever asks for JSON gets JSON; the exit code says that there is nothing.
        match args.json {
            true => say_json(&found)?,
            false => tell(&format!("there is no build, part or order '{}'", args.what.join(" "))),
        }
        return Ok(Exit::Failure);
    }
    match args.json {
        true => say_json(&found)?,
        false => say(&show_text::found(&found))?,
    }
    Ok(Exit::Success)
}
