//! A build that somebody names, with what stands in it: by its file, or by whatever the ledger knows it by.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use build_file::{BuildInfo, Limits};
use glam::DVec3;

use super::{
    Common, Exit, Usage,
    draft::Draft,
    lookup::{Wanted, builds_named},
    reach::look_at_ledger,
    table::{say, tell},
    values::numbered,
};
use crate::{
    farm::{self, Cake, Standing},
    ledger::{BuildId, BuildRow, Ledger, PartRow},
    settings::{Profile, Settings},
};

/// Which build is asked for.
#[derive(Debug, clap::Args)]
pub struct BuildArgs {
    /// A build file, or a build as show takes it: 42, b42, its file's name, or the name of an order or part that is in one build
    #[arg(required = true, num_args = 1.., value_name = "BUILD")]
    what: Vec<String>,
    /// Build volume in mm, e.g. 200x200x200, of a file that does not say it
    #[arg(long, value_name = "XxYxZ", value_parser = super::values::volume)]
    volume: Option<DVec3>,
}

/// A build that was found.
pub struct Looked {
    /// What stands in it.
    pub cake: Cake,
    /// Where it was found.
    pub source: Source,
}

/// Where a build was found.
pub enum Source {
    /// In the ledger.
    Ledger(Box<BuildRow>, Box<Profile>),
    /// In a file.
    File(PathBuf, Box<BuildInfo>),
}

impl Source {
    /// A name for what is made of the build, without an ending.
    pub fn stem(&self) -> String {
        match self {
            Self::Ledger(build, _) => format!("build-{}", build.id),
            Self::File(file, _) => {
                let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let stem = name.strip_suffix(".3mf").unwrap_or(&name);
                stem.strip_suffix(".build").unwrap_or(stem).to_owned()
            }
        }
    }
}

/// Finds the build and reads what stands in it.
pub fn look(common: &Common, args: &BuildArgs) -> Result<Looked> {
    if let [word] = args.what.as_slice() {
        let file = Path::new(word);
        if file.is_file() {
            return of_file(file, args.volume);
        }
        if word.contains('/') || (word.ends_with(".3mf") && number_in(word).is_none()) {
            return Err(Usage(format!("there is no file {}", file.display())).into());
        }
    }
    of_ledger(common, &args.what)
}

fn of_file(file: &Path, volume_mm: Option<DVec3>) -> Result<Looked> {
    let (info, placed) = build_file::read_build_and_info(file, &Limits::default())
        .map_err(|error| Usage(format!("{}: {:#}", file.display(), anyhow::Error::from(error))))?;
    let volume_mm = farm::volume_of(&info, volume_mm)
        .ok_or_else(|| Usage("the file does not say its volume: give --volume".to_owned()))?;
    let cake = Cake::of_file(&placed, volume_mm);
    Ok(Looked { cake, source: Source::File(file.to_owned(), Box::new(info)) })
}

fn of_ledger(common: &Common, words: &[String]) -> Result<Looked> {
    let (settings, build, parts) = look_at_ledger(common, async |settings, ledger| {
        let build = build_named(ledger, words).await?;
        let profile = profile_of(settings, &build)?;
        let parts = farm::standing(ledger, &build, profile).await?;
        Ok((settings.clone(), build, parts))
    })?;
    let profile = profile_of(&settings, &build)?.clone();
    let cake = cake(&settings, &profile, &build, parts)?;
    Ok(Looked { cake, source: Source::Ledger(Box::new(build), Box::new(profile)) })
}

/// What stands in the published file while it lies in the queue, else what the kept originals show.
fn cake(
    settings: &Settings,
    profile: &Profile,
    build: &BuildRow,
    parts: Vec<(PartRow, Vec<Standing>)>,
) -> Result<Cake> {
    if parts.is_empty() {
        bail!("nothing stands in build {} ({}) yet", build.id, build.state);
    }
    let placed =
        farm::file_in_queue(profile, build).and_then(|file| build_file::read_build(&file, &settings.limits).ok());
    if let Some(placed) = placed {
        return Ok(Cake::of_file(&placed, profile.space.volume_mm));
    }
    let cake = Cake::of_ledger(settings, profile, build, parts);
    match cake.missing() {
        0 => {}
        all if all == cake.parts.len() => bail!(
            "the originals of build {} are no longer kept (archive_days), and its file is not in the queue: give the build file",
            build.id
        ),
        some => {
            tell(&format!("{some} of {} parts are not shown: their originals are no longer kept", cake.parts.len()))
        }
    }
    Ok(cake)
}

fn profile_of<'a>(settings: &'a Settings, build: &BuildRow) -> Result<&'a Profile> {
    let gone = || format!("build {} is of profile '{}', which is not configured", build.id, build.profile);
    settings.profiles.get(&build.profile).with_context(gone)
}

/// The one build that the words mean.
async fn build_named(ledger: &Ledger, words: &[String]) -> Result<BuildRow> {
    let said = words.join(" ");
    let nothing = || format!("there is no build '{said}', and no file of that name here");
    let number = match words {
        [word] => numbered(word, 'b').or_else(|| number_in(word)),
        [build, number] if build == "build" => numbered(number, 'b'),
        _ => None,
    };
    if let Some(number) = number {
        return ledger.build(BuildId(number)).await?.with_context(nothing);
    }
    match builds_named(ledger, &Wanted::parse(words)).await?.as_slice() {
        [] => bail!(nothing()),
        [one] => ledger.build(*one).await?.with_context(nothing),
        several => {
            let numbers: Vec<String> = several.iter().map(BuildId::to_string).collect();
            Err(Usage(format!("'{said}' is in builds {}: say which", numbers.join(", "))).into())
        }
    }
}

/// The build's number in the name of its file: `20261120T044900Z_paper-200_000042.build.3mf`.
fn number_in(name: &str) -> Option<i64> {
    let stem = name.split('.').next()?;
    let (before, digits) = stem.rsplit_once('_')?;
    let is_ours = before.contains('_') && digits.len() >= 6 && digits.bytes().all(|b| b.is_ascii_digit());
    digits.parse().ok().filter(|_| is_ours)
}

/// Writes what was made of a build to where it was asked; "-" is standard output.
pub fn hand_over(target: &Path, bytes: &[u8]) -> Result<Exit> {
    use std::io::Write;
    if target == Path::new("-") {
        std::io::stdout().write_all(bytes).context("writing to standard output")?;
        return Ok(Exit::Success);
    }
    if target.is_dir() {
        return Err(Usage(format!("{} is a folder: name a file", target.display())).into());
    }
    Draft::fill(target, |mut file| Ok(file.write_all(bytes)?))?.publish()?;
    say(&target.display().to_string())?;
    Ok(Exit::Success)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_is_known_by_the_name_of_its_file() {
        assert_eq!(number_in("20261120T044900Z_paper-200_000042.build.3mf"), Some(42));
        assert_eq!(number_in("20261120T044900Z_paper-200_000042"), Some(42));
        assert_eq!(number_in("20261120T044900Z_paper-200_000042.png"), Some(42));
        for other in ["order_7", "bracket_000042.stl", "42x", "a_b_12"] {
            assert_eq!(number_in(other), None, "{other}");
        }
    }
}
