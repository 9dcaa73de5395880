//! `nestd release`: says that a proved build may be published, and shows what that means.

use anyhow::{Context, Result, ensure};
use farm::preview_release;
use jiff::Timestamp;
use ledger::{BuildId, BuildState, OperatorWord};
use settings::MachineProfile;

use super::operate::say_all;
use crate::cli::{
    CommandExit, CommonArgs,
    terminal::{
        candidates,
        farm_context::with_ledger,
        table::{print_json, print_text},
        values::parse_build_number,
    },
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
    let (preview, sentences) = with_ledger(common, async |settings, ledger| {
        let build = ledger.find_build(id).await?.with_context(|| format!("there is no build {id}"))?;
        ensure!(
            build.state == BuildState::Verified,
            "build {id} is {}: only a proved build waits for a yes",
            build.state
        );
        let now = settings.profiles.get(&build.machine);
        let made = MachineProfile::from_snapshot(&build.machine, build.kept.profile_snapshot.as_deref(), now);
        let preview = preview_release(ledger, now.unwrap_or(&made), &build, Timestamp::now()).await?;
        let mut sentences = preview.sentences(&settings.time_zone);
        if !args.preview {
            let word = OperatorWord::Release { build: id, seen: build.staged.file_hash.clone() };
            sentences.extend(say_all(settings, ledger, &[word], false).await?);
        }
        Ok((preview, sentences))
    })?;
    if args.json {
        return print_json(&preview).map(|()| CommandExit::Success);
    }
    sentences.iter().try_for_each(|sentence| print_text(sentence))?;
    Ok(CommandExit::Success)
}
