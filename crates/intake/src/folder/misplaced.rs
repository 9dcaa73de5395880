//! Finds files that were dropped beside the hot folders instead of into one. nestd does not take them, so somebody must
//! be warned.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use crate::is_ignored;

/// Returns the entries of the folder `inbox_base` that are neither one of `hot_folders` nor a parent of one, sorted.
/// `hot_folders` may include other folders of the farm that are kept there. Temporary files and folders of operating
/// systems are skipped. If the folder does not exist, the result is empty.
///
/// The folder cannot be listed.
pub fn find_misplaced(inbox_base: &Path, hot_folders: &[PathBuf]) -> io::Result<Vec<PathBuf>> {
    if hot_folders.iter().any(|folder| inbox_base.starts_with(folder)) {
        return Ok(Vec::new()); // files in a hot folder are taken
    }
    let entries = match fs::read_dir(inbox_base) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other?,
    };
    let mut stray = Vec::new();
    for entry in entries {
        let entry = entry?;
        let path = entry.path();
        if !is_ignored(&entry.file_name()) && !leads_to_hot_folder(&path, hot_folders) && !is_left_by_machine(&path) {
            stray.push(path);
        }
    }
    stray.sort();
    Ok(stray)
}

/// Whether the entry was the hot folder of a machine that is not configured any more, and holds nothing but nestd's own
/// files.
fn is_left_by_machine(entry: &Path) -> bool {
    const OWN: [&str; 4] = [".nestd-owner", "STATUS.txt", "status.json", ".claimed"];
    let Ok(entries) = fs::read_dir(entry) else { return false };
    let Ok(names) = entries.map(|inner| inner.map(|inner| inner.file_name())).collect::<io::Result<Vec<_>>>() else {
        return false;
    };
    let has_claims = fs::read_dir(entry.join(".claimed")).is_ok_and(|mut claims| claims.next().is_some());
    !has_claims && names.iter().any(|name| name == OWN[0]) && names.iter().all(|name| OWN.iter().any(|own| name == own))
}

/// Whether the entry is a hot folder or contains one, perhaps through a link that somebody made.
fn leads_to_hot_folder(entry: &Path, hot_folders: &[PathBuf]) -> bool {
    let is_real = |real: &PathBuf| hot_folders.iter().filter_map(|f| fs::canonicalize(f).ok()).any(|f| &f == real);
    hot_folders.iter().any(|folder| folder.starts_with(entry))
        || (entry.is_dir() && fs::canonicalize(entry).is_ok_and(|real| is_real(&real)))
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn what_lies_beside_the_hot_folders_is_stray() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        for folder in ["inbox/cube", "inbox/hall-1/fuse", "inbox/cubes", "inbox/@eaDir", "elsewhere"] {
            fs::create_dir_all(at(folder)).unwrap();
        }
        for file in ["inbox/lost.stl", "inbox/cube/a.stl", "inbox/.DS_Store", "inbox/b.stl.part", "inbox/Thumbs.db"] {
            fs::write(at(file), "x").unwrap();
        }
        for file in [".nestd-owner", "STATUS.txt", "status.json"] {
            fs::create_dir_all(at("inbox/removed/.claimed")).unwrap();
            fs::write(at("inbox/removed").join(file), "x").unwrap();
        }
        symlink(at("elsewhere"), at("inbox/mounted")).unwrap();
        symlink("nowhere", at("inbox/dangling")).unwrap();
        let hot = [at("inbox/cube"), at("inbox/hall-1/fuse"), at("elsewhere")];
        let expected = [at("inbox/cubes"), at("inbox/dangling"), at("inbox/lost.stl")];
        assert_eq!(find_misplaced(&at("inbox"), &hot).unwrap(), expected);
    }

    #[test]
    fn nothing_is_stray_where_nothing_is_or_where_all_is_taken() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(find_misplaced(&dir.path().join("inbox"), &[]).unwrap(), Vec::<PathBuf>::new());
        fs::write(dir.path().join("a.stl"), "x").unwrap();
        assert_eq!(find_misplaced(dir.path(), &[dir.path().to_owned()]).unwrap(), Vec::<PathBuf>::new());
        assert!(find_misplaced(&dir.path().join("a.stl"), &[]).is_err());
    }
}
