//! The record of a published build, beside the originals in the archive: what a ledger that was put back from a backup must
//! know, so that nothing is printed twice. It is on disk before the build appears in the queue.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};

use crate::{access, intake, ledger::BuildRow};

/// Its name in the build's folder; the dot keeps it out of people's way.
const NAME: &str = ".nestd-build.json";
/// Ends the name of a build file.
const BUILD: &str = ".build.3mf";

/// Writes the record of a build that is about to be published; the same record again changes nothing.
pub fn keep(archive: &Path, build: &BuildRow, record: &str) -> Result<()> {
    let name = build.file_name.as_deref().context("its row names no file")?;
    let folder = archive.join(name.strip_suffix(BUILD).unwrap_or(name));
    let file = folder.join(NAME);
    if fs::read_to_string(&file).is_ok_and(|known| known == record) {
        return Ok(());
    }
    access::create_folders(&folder).with_context(|| format!("creating {}", folder.display()))?;
    intake::write_by_rename(&file, record.as_bytes()).with_context(|| format!("writing {}", file.display()))
}

/// The builds of which an archive holds a record: name of the build file, and where the record is; oldest first.
pub fn all(archive: &Path) -> Vec<(String, PathBuf)> {
    let entries = fs::read_dir(archive).into_iter().flatten().flatten();
    let mut found: Vec<(String, PathBuf)> = entries
        .filter_map(|entry| Some((format!("{}{BUILD}", entry.file_name().to_str()?), entry.path().join(NAME))))
        .filter(|(_, record)| record.is_file())
        .collect();
    found.sort();
    found
}

/// When a build file's build fired and its number, by the file's name.
pub fn fired_and_number(name: &str) -> Option<(&str, i64)> {
    let stem = name.strip_suffix(BUILD)?;
    let (fired, rest) = stem.split_once('_')?;
    Some((fired, rest.rsplit_once('_')?.1.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_tells_when_the_build_fired_and_its_number() {
        let name = "20261120T044900Z_mjf-5200_000042.build.3mf";
        assert_eq!(fired_and_number(name), Some(("20261120T044900Z", 42)));
        assert_eq!(fired_and_number("x.build.3mf"), None);
        assert_eq!(fired_and_number("20261120T044900Z_mjf-5200_000042.png"), None);
    }
}
