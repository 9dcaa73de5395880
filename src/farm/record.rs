//! The record of a published build, beside the originals in the archive: what a ledger that was put back from a backup must
//! know, so that nothing is printed twice. It is on disk before the build appears in the queue.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, ensure};

use crate::{access, intake, ledger::BuildRow};

/// Its name in the build's folder; the dot keeps it out of people's way.
const NAME: &str = ".nestd-build.json";
/// Ends the name of a build file.
const BUILD: &str = ".build.3mf";

/// Writes the record of a build that is about to be published; the same record again changes nothing.
pub fn keep(archive: &Path, build: &BuildRow, record: &str) -> Result<()> {
    let name = build.staged.file_name.as_deref().context("its row names no file")?;
    let file = file_of(archive, name);
    if fs::read_to_string(&file).is_ok_and(|known| known == record) {
        return Ok(());
    }
    let folder = file.parent().unwrap_or(archive);
    access::create_folders(folder).with_context(|| format!("creating {}", folder.display()))?;
    intake::write_by_rename(&file, record.as_bytes()).with_context(|| format!("writing {}", file.display()))
}

/// Whether the record of a build file is kept: then its publishing was begun, also where the ledger, put back from a backup,
/// does not know of it.
pub fn is_kept(archive: &Path, name: &str) -> Result<bool> {
    ensure!(archive.is_dir(), "the archive {} is not there; is it mounted?", archive.display());
    let file = file_of(archive, name);
    match fs::symlink_metadata(&file) {
        Ok(meta) => Ok(meta.is_file()),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error).with_context(|| format!("looking at {}", file.display())),
    }
}

/// Removes the record of a build that is certainly not published.
pub fn forget(archive: &Path, name: &str) -> Result<()> {
    let file = file_of(archive, name);
    if is_kept(archive, name)? {
        fs::remove_file(&file).with_context(|| format!("removing {}", file.display()))?;
    }
    Ok(())
}

fn file_of(archive: &Path, name: &str) -> PathBuf {
    archive.join(name.strip_suffix(BUILD).unwrap_or(name)).join(NAME)
}

/// The builds of which an archive holds a record: name of the build file, and where the record is; oldest first.
///
/// # Errors
/// The archive, or a folder in it, cannot be read.
pub fn all(archive: &Path) -> io::Result<Vec<(String, PathBuf)>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(archive)? {
        let entry = entry?;
        let (name, record) = (entry.file_name(), entry.path().join(NAME));
        let Some(name) = name.to_str() else { continue };
        match fs::symlink_metadata(&record) {
            Ok(meta) if meta.is_file() => found.push((format!("{name}{BUILD}"), record)),
            Ok(_) => {}
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {}
            Err(error) => return Err(error),
        }
    }
    found.sort();
    Ok(found)
}

/// Gives a record that cannot be taken in another name, so that it is asked no more; a person was told of it.
pub fn set_aside(record: &Path) -> io::Result<PathBuf> {
    let aside = record.with_extension("json.not-taken-in");
    fs::rename(record, &aside)?;
    Ok(aside)
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
