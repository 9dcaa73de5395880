//! `STATUS.txt` and `status.json` in the hot folder: what waits, how full, when it will fire.

use std::{
    fs,
    io::{self, Read, Write},
    path::Path,
};

use build_file::visible_lines;

use super::disk;

/// For people.
pub(super) const TEXT_NAME: &str = "STATUS.txt";
/// For programs.
pub(super) const JSON_NAME: &str = "status.json";

/// Writes both by rename, each only when it says something new: a write wakes whoever watches the folder. Returns whether
/// it did. A link in their place is replaced, not written through.
pub fn write_status(inbox: &Path, text: &str, json: &str) -> io::Result<bool> {
    let mut written = false;
    let text = &visible_lines(text);
    for (name, content) in [(TEXT_NAME, text.as_str()), (JSON_NAME, json)] {
        let path = inbox.join(name);
        if !says(&path, content) {
            replace(&path, content)?;
            written = true;
        }
    }
    Ok(written)
}

fn says(path: &Path, content: &str) -> bool {
    let Ok(file) = disk::open_regular(path) else { return false };
    let mut now = Vec::new();
    file.take(content.len() as u64 + 1).read_to_end(&mut now).is_ok() && now == content.as_bytes()
}

/// Not fsynced: it is written again at the next change, and a status that a power cut loses is old anyway.
fn replace(path: &Path, content: &str) -> io::Result<()> {
    let part = disk::unfinished(path);
    disk::create_anew(&part)?.write_all(content.as_bytes())?;
    fs::rename(part, path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::MetadataExt;

    #[test]
    fn a_status_that_did_not_change_is_not_written() {
        let dir = tempfile::tempdir().unwrap();
        assert!(write_status(dir.path(), "3 parts wait", "{}").unwrap());
        let inode = fs::metadata(dir.path().join(TEXT_NAME)).unwrap().ino();
        assert!(!write_status(dir.path(), "3 parts wait", "{}").unwrap());
        assert_eq!(fs::metadata(dir.path().join(TEXT_NAME)).unwrap().ino(), inode);
        assert!(write_status(dir.path(), "3 parts", "{}").unwrap());
        assert_eq!(fs::read_to_string(dir.path().join(TEXT_NAME)).unwrap(), "3 parts");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2);
    }

    #[test]
    fn a_link_in_place_of_the_status_is_replaced_and_its_target_left_alone() {
        let dir = tempfile::tempdir().unwrap();
        let precious = dir.path().join("precious");
        fs::write(&precious, "mine").unwrap();
        std::os::unix::fs::symlink(&precious, dir.path().join(TEXT_NAME)).unwrap();
        std::os::unix::fs::symlink(&precious, disk::unfinished(&dir.path().join(TEXT_NAME))).unwrap();
        write_status(dir.path(), "0 parts", "{}").unwrap();
        assert_eq!(fs::read_to_string(&precious).unwrap(), "mine");
        assert_eq!(fs::read_to_string(dir.path().join(TEXT_NAME)).unwrap(), "0 parts");
    }
}
