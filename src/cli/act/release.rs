//! `nestd release`: says that a proved build may be published, and shows what that means.

use anyhow::{Context, Result, ensure};
use jiff::Timestamp;
use ledger::{BuildId, BuildState};

use crate::{
    cli::{
        CommandExit, CommonArgs,
        terminal::{
            candidates,
            farm_context::{user_at_host, with_ledger},
            table::{print_json, print_text},
            values::parse_build_number,
        },
    },
    farm::preview_release,
    settings::MachineProfile,
};

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct ReleaseArgs {
    /// Build number, as status prints it (4 or b4)
    #[arg(value_parser = parse_build_number, add = candidates::of_builds())]
    build: i64,
    /// Only show what publishing it would mean
    #[arg(long)]
    preview: bool,
    /// Print the preview as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &ReleaseArgs) -> Result<CommandExit> {
    let id = BuildId(args.build);
    let (preview, sentences, released) = with_ledger(common, async |settings, ledger| {
        let build = ledger.find_build(id).await?.with_context(|| format!("there is no build {id}"))?;
        ensure!(
            build.state == BuildState::Verified,
            "build {id} is {}: only a proved build waits for a yes",
            build.state
        );
        let now = settings.profiles.get(&build.profile);
        let made = MachineProfile::from_snapshot(&build.profile, build.kept.profile_snapshot.as_deref(), now);
        let preview = preview_release(ledger, now.unwrap_or(&made), &build, Timestamp::now()).await?;
        let released = match args.preview || preview.made_again_for.is_some() {
            true => None,
            false => Some(ledger.release_build(id, build.staged.file_hash.as_deref(), &user_at_host()).await?),
        };
        let sentences = preview.sentences(&settings.time_zone);
        Ok((preview, sentences, released))
    })?;
    if args.json {
        return print_json(&preview).map(|()| CommandExit::Success);
    }
    sentences.iter().try_for_each(|sentence| print_text(sentence))?;
    match released {
        None => {}
        Some(true) => print_text(&format!("Build {id} is released and goes to the queue."))?,
        Some(false) => print_text(&format!("Build {id} was released before."))?,
    }
    Ok(CommandExit::Success)
}
