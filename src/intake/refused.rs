//! What the error folder keeps of parts that were refused late, and what goes when a refused part is taken back.

use std::{io, path::Path};

use rustix::fs::AtFlags;

use super::{
    archive, disk,
    name::{raw_name, with_suffix},
    refuse::{RefuseError, io_error},
};

/// Puts a copy of a stored file into `error_dir/<folder>/`, beside its reason: the original was let go when its part began
/// to wait. Safe to repeat.
pub fn refuse_stored(
    stored: &Path,
    error_dir: &Path,
    folder: &str,
    display_name: &str,
    reason: &str,
) -> Result<(), RefuseError> {
    let copy = archive(stored, error_dir, folder, display_name)
        .map_err(|e| io_error("copy into the error folder", stored, e))?;
    let beside = copy.with_file_name(with_suffix(copy.file_name().unwrap_or_default(), "", REASON));
    disk::write_by_rename(&beside, format!("{}\n", reason.trim_end()).as_bytes())
        .map_err(|e| io_error("write", &beside, e))
}

/// The end of the name of a reason.
pub(super) const REASON: &str = ".reason.txt";

/// Removes a refused file of these bytes, with its reason, from the order's folder in `error_dir` or from `error_dir` itself.
/// Names are as the ledger shows them; an order that a ticket made up leads nowhere else. Returns whether there was one.
pub fn remove_refused(error_dir: &Path, order: &str, display_name: &str, content_hash: &str) -> io::Result<bool> {
    let Some(name) = raw_name(display_name) else { return Ok(false) };
    let order: Option<Vec<_>> = order.split('/').map(raw_name).collect();
    let order = order.map(|parts| parts.iter().collect::<std::path::PathBuf>()).unwrap_or_default();
    for folder in [order.as_path(), Path::new("")] {
        let Ok(file) = disk::open_beneath(error_dir, &folder.join(&name)) else { continue };
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(file)?;
        if hasher.finalize().to_hex().as_str() != content_hash {
            continue;
        }
        let folder = disk::open_dir_beneath(error_dir, folder)?;
        rustix::fs::unlinkat(&folder, &name, AtFlags::empty())?;
        return match rustix::fs::unlinkat(&folder, with_suffix(&name, "", REASON), AtFlags::empty()) {
            Err(error) if error != rustix::io::Errno::NOENT => Err(error.into()),
            _ => Ok(true),
        };
    }
    Ok(false)
}

#[cfg(test)]
mod tests {
    use std::{fs, os::unix::fs::symlink};

    use super::*;

    fn hash(text: &str) -> String {
        blake3::hash(text.as_bytes()).to_hex().to_string()
    }

    #[test]
    fn a_refused_file_goes_with_its_reason_from_its_order_or_from_the_top() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir_all(dir.path().join("kit\n1/lid")).unwrap();
        for name in ["kit\n1/lid/a.stl", "kit\n1/lid/a.stl.reason.txt", "b.stl", "b.stl.reason.txt", "c.stl"] {
            fs::write(dir.path().join(name), "x").unwrap();
        }
        assert!(remove_refused(dir.path(), r"kit\n1/lid", "a.stl", &hash("x")).unwrap());
        assert!(remove_refused(dir.path(), "an order of a ticket", "b.stl", &hash("x")).unwrap());
        assert!(!remove_refused(dir.path(), "", "c.stl", &hash("y")).unwrap());
        assert!(!remove_refused(dir.path(), "", "none.stl", &hash("x")).unwrap());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2, "c.stl and the order's folder");
    }

    #[test]
    fn nothing_outside_the_error_folder_is_removed_whatever_an_order_is_called() {
        let dir = tempfile::tempdir().unwrap();
        let (error, queue) = (dir.path().join("error"), dir.path().join("queue"));
        fs::create_dir_all(&error).unwrap();
        fs::create_dir_all(&queue).unwrap();
        fs::write(queue.join("a.stl"), "x").unwrap();
        symlink(&queue, error.join("link")).unwrap();
        symlink(queue.join("a.stl"), error.join("b.stl")).unwrap();
        let absolute = queue.to_str().unwrap();
        for (order, name) in [("../queue", "a.stl"), (absolute, "a.stl"), ("link", "a.stl"), ("", "../queue/a.stl")] {
            assert!(!remove_refused(&error, order, name, &hash("x")).unwrap_or(false), "{order} {name}");
        }
        assert!(!remove_refused(&error, "", "b.stl", &hash("x")).unwrap());
        assert!(queue.join("a.stl").exists());
    }

    #[test]
    fn a_name_of_255_bytes_gets_its_reason_too() {
        let dir = tempfile::tempdir().unwrap();
        let (stored, name) = (dir.path().join("stored"), "ä".repeat(125) + "a.stl");
        fs::write(&stored, "x").unwrap();
        for _ in 0..2 {
            refuse_stored(&stored, &dir.path().join("error"), "part-7", &name, "No room.").unwrap();
        }
        assert_eq!(fs::read_dir(dir.path().join("error/part-7")).unwrap().count(), 2);
    }
}
