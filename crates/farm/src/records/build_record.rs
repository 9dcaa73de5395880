//! The record of a published build, beside the originals in the archive: a ledger that was restored from a backup
//! learns from it what was printed. It is on disk before the build appears in the queue.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, ensure};
use build_file::{DeliveryKind, build_file_stem};
use ledger::{BuildRow, UtcTimestamp};
use serde_json::Value;

/// Name of the record in the build's folder, after what the build was delivered as; a dot-file, so that people do not see it.
fn record_name(kind: DeliveryKind) -> &'static str {
    match kind {
        DeliveryKind::Shared | DeliveryKind::Expanded => ".nestd-build.json",
        DeliveryKind::Stl => ".nestd-build.stl.json",
        DeliveryKind::Parts => ".nestd-build.zip.json",
    }
}

/// Writes the record of a build that is about to be published; repeating this changes nothing.
pub fn write_record(archive: &Path, build: &BuildRow, record: &str) -> Result<()> {
    let name = build.staged.file_name.as_deref().context("its row names no file")?;
    let file = record_path(archive, name);
    if fs::read_to_string(&file).is_ok_and(|known| known == record) {
        return Ok(());
    }
    let folder = file.parent().unwrap_or(archive);
    access::create_folders(folder).with_context(|| format!("creating {}", folder.display()))?;
    intake::write_file_atomically(&file, record.as_bytes()).with_context(|| format!("writing {}", file.display()))
}

/// Whether a build file has a record: then publishing has begun, even if a restored ledger does not know it.
pub fn has_record(archive: &Path, name: &str) -> Result<bool> {
    ensure!(archive.is_dir(), "the archive {} is not there; is it mounted?", archive.display());
    let file = record_path(archive, name);
    match fs::symlink_metadata(&file) {
        Ok(meta) => Ok(meta.is_file()),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error).with_context(|| format!("looking at {}", file.display())),
    }
}

/// Writes into the record of a build that its file was taken back out of the queue untouched: a ledger that was put back from a backup
/// does not count it as printed then. Repeating this changes nothing.
pub fn note_withdrawn(archive: &Path, name: &str, at: UtcTimestamp) -> Result<()> {
    let Some(text) = read_record(archive, name)?.filter(|text| !is_withdrawn(text)) else { return Ok(()) };
    let file = record_path(archive, name);
    let mut record: Value = serde_json::from_str(&text).with_context(|| format!("reading {}", file.display()))?;
    record["builds"][0]["withdrawn_at"] = at.to_string().into();
    intake::write_file_atomically(&file, record.to_string().as_bytes())
        .with_context(|| format!("writing {}", file.display()))
}

/// Whether a record says that the file of its build was taken back out of the queue untouched.
pub fn is_withdrawn(record: &str) -> bool {
    let record: Value = serde_json::from_str(record).unwrap_or_default();
    record["builds"][0]["withdrawn_at"].is_string()
}

/// The text of the record of a build; `None` = it has none.
pub fn read_record(archive: &Path, name: &str) -> Result<Option<String>> {
    if !has_record(archive, name)? {
        return Ok(None);
    }
    let file = record_path(archive, name);
    Ok(Some(fs::read_to_string(&file).with_context(|| format!("reading {}", file.display()))?))
}

/// Removes the record of a build that is certainly not published.
pub fn remove_record(archive: &Path, name: &str) -> Result<()> {
    let file = record_path(archive, name);
    if has_record(archive, name)? {
        fs::remove_file(&file).with_context(|| format!("removing {}", file.display()))?;
    }
    Ok(())
}

fn record_path(archive: &Path, name: &str) -> PathBuf {
    archive_folder(archive, name).join(record_name(DeliveryKind::of_name(name).unwrap_or_default()))
}

/// The folder of a build in an archive: its originals and its record. `name` = that of its build file.
pub fn archive_folder(archive: &Path, name: &str) -> PathBuf {
    archive.join(build_file_stem(name).unwrap_or(name))
}

/// The builds with a record in an archive: name of the build file, and path of the record; oldest first.
///
/// # Errors
/// The archive, or a folder in it, cannot be read.
pub fn list_records(archive: &Path) -> io::Result<Vec<(String, PathBuf)>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(archive)? {
        let entry = entry?;
        let name = entry.file_name();
        let Some(name) = name.to_str() else { continue };
        // `shared` and `expanded` have one ending.
        for kind in [DeliveryKind::Shared, DeliveryKind::Stl, DeliveryKind::Parts] {
            let record = entry.path().join(record_name(kind));
            match fs::symlink_metadata(&record) {
                Ok(meta) if meta.is_file() => found.push((format!("{name}{}", kind.ending()), record)),
                Ok(_) => {}
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) if error.kind() == io::ErrorKind::NotADirectory => break,
                Err(error) => return Err(error),
            }
        }
    }
    found.sort();
    Ok(found)
}

/// Renames a record that cannot be taken in, so that it is not read again; a person was told of it.
pub fn set_record_aside(record: &Path) -> io::Result<PathBuf> {
    let aside = record.with_extension("json.not-taken-in");
    fs::rename(record, &aside)?;
    Ok(aside)
}

/// When a build fired, and its number, from the name of its file.
pub fn parse_build_file_name(name: &str) -> Option<(&str, i64)> {
    let stem = build_file_stem(name)?;
    let (fired, rest) = stem.split_once('_')?;
    Some((fired, rest.rsplit_once('_')?.1.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_tells_when_the_build_fired_and_its_number() {
        let name = "20261120T044900Z_mjf-5200_000042.build.3mf";
        assert_eq!(parse_build_file_name(name), Some(("20261120T044900Z", 42)));
        assert_eq!(parse_build_file_name("x.build.3mf"), None);
        assert_eq!(parse_build_file_name("20261120T044900Z_mjf-5200_000042.png"), None);
    }
}
