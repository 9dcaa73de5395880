//! Finds the build that the user names, by its file or through the ledger, and reads the copies in it.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use build_file::{BuildMetadata, ReadLimits};
use farm::{CakeContents, CakeCopy};
use glam::DVec3;
use ledger::{BuildId, BuildRow, Ledger, PartRow};
use settings::{MachineProfile, Settings};

use super::{
    atomic_file::AtomicFile,
    farm_context::with_ledger_to_read,
    lookup::{LookupQuery, find_builds},
    table::{print_text, print_to_stderr},
    values::parse_prefixed_number,
};
use crate::cli::{CommandExit, CommonArgs, UsageError};

/// The options that select a build.
#[derive(Debug, clap::Args)]
pub struct BuildLookupArgs {
    /// A build file, or a build as for show: 42, b42, its file name, or the name of an order or part that is in only
    /// one build
    #[arg(required = true, num_args = 1.., value_name = "BUILD", add = super::candidates::of_builds())]
    what: Vec<String>,
    /// Build volume in mm, e.g. 200x200x200, for a file that does not state it
    #[arg(long, value_name = "XxYxZ", value_parser = super::values::parse_volume)]
    volume: Option<DVec3>,
}

/// A build that was found.
pub struct FoundBuild {
    /// The copies in the build with their meshes.
    pub cake: CakeContents,
    /// Where it was found.
    pub source: BuildSource,
}

/// Where a build was found.
pub enum BuildSource {
    /// In the ledger.
    Ledger(Box<BuildRow>, Box<MachineProfile>),
    /// In a file.
    File(PathBuf, Box<BuildMetadata>),
}

impl BuildSource {
    /// A name for output files of the build, without an extension.
    pub fn output_stem(&self) -> String {
        match self {
            Self::Ledger(build, _) => format!("build-{}", build.id),
            Self::File(file, _) => {
                let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let stem = BUILD_ENDINGS.iter().find_map(|ending| name.strip_suffix(ending)).unwrap_or(&name);
                stem.strip_suffix(".build").unwrap_or(stem).to_owned()
            }
        }
    }
}

/// Finds the build and reads the copies in it.
pub fn find_build(common: &CommonArgs, args: &BuildLookupArgs) -> Result<FoundBuild> {
    if let [word] = args.what.as_slice() {
        let file = Path::new(word);
        if file.is_file() {
            return load_from_file(file, args.volume);
        }
        let is_build = word.ends_with(".3mf") || build_file::build_file_stem(word).is_some();
        if word.contains('/') || (is_build && number_in_name(word).is_none()) {
            return Err(UsageError(format!("there is no file {}", file.display())).into());
        }
    }
    load_from_ledger(common, &args.what)
}

/// How files of builds end, also those of other programs.
const BUILD_ENDINGS: [&str; 3] = [".3mf", ".stl", ".zip"];

fn load_from_file(file: &Path, volume_mm: Option<DVec3>) -> Result<FoundBuild> {
    let (info, placed) = build_file::read_build_and_metadata(file, &ReadLimits::default())
        .map_err(|error| UsageError(format!("{}: {:#}", file.display(), anyhow::Error::from(error))))?;
    let volume_mm = farm::resolve_volume_mm(&info, volume_mm)
        .ok_or_else(|| UsageError("the file does not say its volume: give --volume".to_owned()))?;
    let cake = CakeContents::from_placed_meshes(&placed, volume_mm);
    Ok(FoundBuild { cake, source: BuildSource::File(file.to_owned(), Box::new(info)) })
}

fn load_from_ledger(common: &CommonArgs, words: &[String]) -> Result<FoundBuild> {
    let (settings, build, parts) = with_ledger_to_read(common, async |settings, ledger| {
        let build = find_build_row(ledger, words).await?;
        let profile = configured_profile(settings, &build)?;
        let parts = farm::load_placed_parts(ledger, &build, profile).await?;
        Ok((settings.clone(), build, parts))
    })?;
    let profile = configured_profile(&settings, &build)?.clone();
    let cake = assemble_cake(&settings, &profile, &build, parts)?;
    Ok(FoundBuild { cake, source: BuildSource::Ledger(Box::new(build), Box::new(profile)) })
}

/// Reads the copies from the published file while it is in the queue, else from the kept originals.
fn assemble_cake(
    settings: &Settings,
    profile: &MachineProfile,
    build: &BuildRow,
    parts: Vec<(PartRow, Vec<CakeCopy>)>,
) -> Result<CakeContents> {
    if parts.is_empty() {
        bail!("nothing stands in build {} ({}) yet", build.id, build.state);
    }
    let placed =
        farm::find_proved_file(profile, build).and_then(|file| build_file::read_build(&file, &settings.limits).ok());
    if let Some(placed) = placed {
        return Ok(CakeContents::from_placed_meshes(&placed, profile.space.volume_mm));
    }
    let cake = CakeContents::from_ledger(settings, profile, build, parts);
    match cake.missing_mesh_count() {
        0 => {}
        all if all == cake.parts.len() => bail!(
            "the originals of build {} are no longer kept (archive_days), and its file is not in the queue: give the build file",
            build.id
        ),
        some => print_to_stderr(&format!(
            "{some} of {} parts are not shown: their originals are no longer kept",
            cake.parts.len()
        )),
    }
    Ok(cake)
}

fn configured_profile<'a>(settings: &'a Settings, build: &BuildRow) -> Result<&'a MachineProfile> {
    let gone = || format!("build {} is of machine '{}', which is not configured", build.id, build.machine);
    settings.profiles.get(&build.machine).with_context(gone)
}

/// The one build that the words name.
async fn find_build_row(ledger: &Ledger, words: &[String]) -> Result<BuildRow> {
    let query = words.join(" ");
    let nothing = || format!("there is no build '{query}', and no file of that name here");
    let number = match words {
        [word] => parse_prefixed_number(word, 'b').or_else(|| number_in_name(word)),
        [build, number] if build == "build" => parse_prefixed_number(number, 'b'),
        _ => None,
    };
    if let Some(number) = number {
        return ledger.find_build(BuildId(number)).await?.with_context(nothing);
    }
    match find_builds(ledger, &LookupQuery::from_words(words)).await?.as_slice() {
        [] => bail!(nothing()),
        [one] => ledger.find_build(*one).await?.with_context(nothing),
        several => {
            let numbers: Vec<String> = several.iter().map(BuildId::to_string).collect();
            Err(UsageError(format!("'{query}' is in builds {}: say which", numbers.join(", "))).into())
        }
    }
}

/// The build's number in the name of its file: `20261120T044900Z_paper-200_000042.build.3mf`.
fn number_in_name(name: &str) -> Option<i64> {
    let stem = name.split('.').next()?;
    let (before, digits) = stem.rsplit_once('_')?;
    let is_ours = before.contains('_') && digits.len() >= 6 && digits.bytes().all(|b| b.is_ascii_digit());
    digits.parse().ok().filter(|_| is_ours)
}

/// Writes output to the target path; `-` is standard output.
pub fn write_output(target: &Path, bytes: &[u8]) -> Result<CommandExit> {
    use std::io::Write;
    if target == Path::new("-") {
        std::io::stdout().write_all(bytes).context("writing to standard output")?;
        return Ok(CommandExit::Success);
    }
    if target.is_dir() {
        return Err(UsageError(format!("{} is a folder: name a file", target.display())).into());
    }
    AtomicFile::write_hidden(target, |mut file| Ok(file.write_all(bytes)?))?.rename_into_place()?;
    print_text(&target.display().to_string())?;
    Ok(CommandExit::Success)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_is_known_by_the_name_of_its_file() {
        assert_eq!(number_in_name("20261120T044900Z_paper-200_000042.build.3mf"), Some(42));
        assert_eq!(number_in_name("20261120T044900Z_paper-200_000042"), Some(42));
        assert_eq!(number_in_name("20261120T044900Z_paper-200_000042.png"), Some(42));
        for other in ["order_7", "bracket_000042.stl", "42x", "a_b_12"] {
            assert_eq!(number_in_name(other), None, "{other}");
        }
    }
}
