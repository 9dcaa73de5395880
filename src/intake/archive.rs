//! The archive: originals of published builds, kept for some days.

use std::{
    fs, io,
    path::{Path, PathBuf},
    time::SystemTime,
};

use super::{
    disk,
    name::{numbered, raw_name},
};

/// Copies a stored file to `archive_dir/<build stem>/<name>`, where the name is the part's display name unescaped. Never
/// overwrites: the same bytes there already is success (so that it can be repeated after a crash), other bytes make this
/// one `name (2)`.
pub fn archive(stored: &Path, archive_dir: &Path, build_stem: &str, display_name: &str) -> io::Result<PathBuf> {
    let below = plain(build_stem)?;
    let folder = archive_dir.join(&below);
    disk::create_dirs_beneath(archive_dir, &below)?;
    let name = raw_name(display_name).unwrap_or_else(|| display_name.into());
    let name = plain(&name)?;
    for n in 1..=disk::MAX_NUMBER {
        let to = folder.join(numbered(name.as_os_str(), n));
        match disk::is_there(&to) {
            true if is_same(stored, &to)? => return Ok(to),
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

/// One plain component of a path.
fn plain(name: &(impl AsRef<std::ffi::OsStr> + ?Sized)) -> io::Result<PathBuf> {
    let path = Path::new(name);
    match path.file_name() == Some(name.as_ref()) {
        true => Ok(path.to_owned()),
        false => Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{} is no file name", path.display()))),
    }
}

fn is_same(one: &Path, other: &Path) -> io::Result<bool> {
    let is_size = fs::metadata(one)?.len() == fs::symlink_metadata(other)?.len();
    Ok(is_size && disk::same_bytes(one, other))
}

/// Removes what came into the archive before `before`, and folders that became empty. Returns how many files. What came
/// when is told by the ctime: a file that was moved here keeps its old mtime.
pub fn purge(archive_dir: &Path, before: SystemTime) -> io::Result<usize> {
    if !disk::is_there(archive_dir) {
        return Ok(0);
    }
    let mut count = 0;
    // What lies in the archive itself is not of a build: the marker of the folder.
    for file in disk::files_below(archive_dir)?.iter().filter(|file| file.parent() != Some(archive_dir)) {
        let came = disk::as_time(disk::ctime_ns(&fs::symlink_metadata(file)?));
        if came < before {
            fs::remove_file(file)?;
            count += 1;
            if let Some(folder) = file.parent() {
                disk::remove_empty_up_to(folder, archive_dir);
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
        let first = archive(&one, &archive_dir, "b1", r"a\n\xff.stl").unwrap();
        assert_eq!(first.file_name().unwrap().as_encoded_bytes(), b"a\n\xff.stl");
        assert_eq!(archive(&one, &archive_dir, "b1", r"a\n\xff.stl").unwrap(), first);
        let second = archive(&other, &archive_dir, "b1", r"a\n\xff.stl").unwrap();
        assert_eq!(second.file_name().unwrap().as_encoded_bytes(), b"a\n\xff (2).stl");
        assert_eq!(fs::read_to_string(first).unwrap(), "one");
        assert_eq!(fs::read_to_string(second).unwrap(), "two");
        for name in ["", "..", "a/b", "/etc/passwd"] {
            assert!(archive(&one, &archive_dir, "b1", name).is_err(), "{name}");
            assert!(archive(&one, &archive_dir, name, "a.stl").is_err(), "{name}");
        }
    }

    #[test]
    fn only_what_is_old_is_purged_and_its_empty_folders_with_it() {
        let dir = tempfile::tempdir().unwrap();
        let (one, archive_dir) = (dir.path().join("one"), dir.path().join("archive"));
        assert_eq!(purge(&archive_dir, SystemTime::now()).unwrap(), 0);
        fs::write(&one, "one").unwrap();
        let kept = archive(&one, &archive_dir, "b1", "a.stl").unwrap();
        assert_eq!(purge(&archive_dir, SystemTime::now() - Duration::from_secs(3600)).unwrap(), 0);
        assert!(kept.exists());
        assert_eq!(purge(&archive_dir, SystemTime::now() + Duration::from_secs(1)).unwrap(), 1);
        assert!(!archive_dir.join("b1").exists() && archive_dir.exists());
    }
}
