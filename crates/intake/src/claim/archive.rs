//! The archive: originals of published builds, kept for some days.

use std::{
    fs, io,
    path::{Path, PathBuf},
    time::SystemTime,
};

use super::refuse::io_error;
use crate::{
    InboxEntry, RefuseError,
    folder::{disk, file_role::has_extension},
    names::name::{numbered_name, raw_name},
};

/// The folder of an archive that holds copies of build files. Build folders are named after builds, which begin with a date.
pub const KEPT_BUILDS: &str = "builds";

/// Copies a stored file to `archive_dir/<build stem>/<name>`, where the name is the part's unescaped display name. It
/// never overwrites a file. If a file with the same bytes is there already, the call succeeds, so it can be repeated
/// after a crash. If its bytes differ, the copy is named `name (2)`.
pub fn archive_file(stored: &Path, archive_dir: &Path, build_stem: &str, display_name: &str) -> io::Result<PathBuf> {
    let below = plain_file_name(build_stem)?;
    let folder = archive_dir.join(&below);
    disk::create_dirs_beneath(archive_dir, &below)?;
    let name = raw_name(display_name).unwrap_or_else(|| display_name.into());
    let name = plain_file_name(&name)?;
    for n in 1..=disk::MAX_NAME_NUMBER {
        let to = folder.join(numbered_name(name.as_os_str(), n));
        match disk::path_exists(&to) {
            true if has_same_bytes(stored, &to)? => return Ok(to),
            true => continue,
            false => {}
        }
        match disk::copy_noreplace(stored, &to) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            other => return other.map(|()| to),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Moves an entry of a hot folder to `archive_dir/<kind>/[order/]`, under a free name.
pub(crate) fn archive_entry(
    inbox: &Path,
    seen: &InboxEntry,
    archive_dir: &Path,
    kind: &str,
) -> Result<PathBuf, RefuseError> {
    let folder = seen.path.parent().and_then(|p| p.strip_prefix(inbox).ok()).unwrap_or(Path::new(""));
    let folder = archive_dir.join(kind).join(folder);
    disk::create_dirs(&folder).map_err(|e| io_error("create", &folder, e))?;
    let name = seen.path.file_name().unwrap_or_default();
    disk::move_to_free_name(&seen.path, &folder, name).map_err(|e| io_error("move to the archive", &seen.path, e))
}

/// Whether a file tells the colours of an OBJ: nobody orders it, and nothing of it is needed.
pub fn is_material_library(path: &Path) -> bool {
    has_extension(path, &["mtl"])
}

/// Moves the file that tells the colours of an OBJ to the archive.
///
/// # Errors
/// It stays where it is.
pub fn archive_material_library(inbox: &Path, seen: &InboxEntry, archive_dir: &Path) -> Result<PathBuf, RefuseError> {
    archive_entry(inbox, seen, archive_dir, "material-libraries")
}

/// Checks that a name is a single path component.
fn plain_file_name(name: &(impl AsRef<std::ffi::OsStr> + ?Sized)) -> io::Result<PathBuf> {
    let path = Path::new(name);
    match path.file_name() == Some(name.as_ref()) {
        true => Ok(path.to_owned()),
        false => Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{} is no file name", path.display()))),
    }
}

fn has_same_bytes(one: &Path, other: &Path) -> io::Result<bool> {
    let is_size = fs::metadata(one)?.len() == fs::symlink_metadata(other)?.len();
    Ok(is_size && disk::have_same_bytes(one, other))
}

/// Removes files that were archived before `before`, and folders that became empty; copies of build files stay. Returns
/// the number of files.
pub fn purge_archive(archive_dir: &Path, before: SystemTime) -> io::Result<usize> {
    // Files directly in the archive folder belong to no build: they mark the folder as ours.
    let kept = archive_dir.join(KEPT_BUILDS);
    purge_files(archive_dir, before, |file| file.parent() != Some(archive_dir) && !file.starts_with(&kept))
}

/// Removes copies of build files that were archived before `before`. Returns their number.
pub fn purge_kept_builds(archive_dir: &Path, before: SystemTime) -> io::Result<usize> {
    let kept = archive_dir.join(KEPT_BUILDS);
    purge_files(archive_dir, before, |file| file.starts_with(&kept))
}

/// The ctime tells when a file was archived, because a moved file keeps its old mtime.
fn purge_files(archive_dir: &Path, before: SystemTime, is_meant: impl Fn(&Path) -> bool) -> io::Result<usize> {
    if !disk::path_exists(archive_dir) {
        return Ok(0);
    }
    let mut count = 0;
    for file in disk::files_below(archive_dir)?.iter().filter(|file| is_meant(file)) {
        let came = disk::to_system_time(disk::ctime_ns(&fs::symlink_metadata(file)?));
        if came < before {
            fs::remove_file(file)?;
            count += 1;
            if let Some(folder) = file.parent() {
                disk::remove_empty_parents(folder, archive_dir);
            }
        }
    }
    Ok(count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn originals_are_archived_under_their_build_and_nothing_is_overwritten() {
        let dir = tempfile::tempdir().unwrap();
        let (one, other) = (dir.path().join("one"), dir.path().join("other"));
        fs::write(&one, "one").unwrap();
        fs::write(&other, "two").unwrap();
        let archive_dir = dir.path().join("archive");
        let first = archive_file(&one, &archive_dir, "b1", r"a\n\xff.stl").unwrap();
        assert_eq!(first.file_name().unwrap().as_encoded_bytes(), b"a\n\xff.stl");
        assert_eq!(archive_file(&one, &archive_dir, "b1", r"a\n\xff.stl").unwrap(), first);
        let second = archive_file(&other, &archive_dir, "b1", r"a\n\xff.stl").unwrap();
        assert_eq!(second.file_name().unwrap().as_encoded_bytes(), b"a\n\xff (2).stl");
        assert_eq!(fs::read_to_string(first).unwrap(), "one");
        assert_eq!(fs::read_to_string(second).unwrap(), "two");
        for name in ["", "..", "a/b", "/etc/passwd"] {
            assert!(archive_file(&one, &archive_dir, "b1", name).is_err(), "{name}");
            assert!(archive_file(&one, &archive_dir, name, "a.stl").is_err(), "{name}");
        }
    }

    #[test]
    fn only_what_is_old_is_purged_and_its_empty_folders_with_it() {
        let dir = tempfile::tempdir().unwrap();
        let (one, archive_dir) = (dir.path().join("one"), dir.path().join("archive"));
        assert_eq!(purge_archive(&archive_dir, SystemTime::now()).unwrap(), 0);
        fs::write(&one, "one").unwrap();
        let kept = archive_file(&one, &archive_dir, "b1", "a.stl").unwrap();
        assert_eq!(purge_archive(&archive_dir, SystemTime::now() - Duration::from_secs(3600)).unwrap(), 0);
        assert!(kept.exists());
        assert_eq!(purge_archive(&archive_dir, SystemTime::now() + Duration::from_secs(1)).unwrap(), 1);
        assert!(!archive_dir.join("b1").exists() && archive_dir.exists());
        // Copies of build files have a retention of their own.
        let build = archive_file(&one, &archive_dir, KEPT_BUILDS, "b1.build.3mf").unwrap();
        assert_eq!(purge_archive(&archive_dir, SystemTime::now() + Duration::from_secs(1)).unwrap(), 0);
        assert!(build.exists());
        assert_eq!(purge_kept_builds(&archive_dir, SystemTime::now() - Duration::from_secs(3600)).unwrap(), 0);
        assert_eq!(purge_kept_builds(&archive_dir, SystemTime::now() + Duration::from_secs(1)).unwrap(), 1);
    }
}
