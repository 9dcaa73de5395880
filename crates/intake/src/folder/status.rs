//! Writes `STATUS.txt` and `status.json` into the hot folder: what is waiting, how full the open build is, and when it
//! will be nested.

use std::{
    fs,
    io::{self, Read, Write},
    path::Path,
};

use build_file::escape_invisible_lines;

use super::disk;

/// Status for people.
pub(super) const TEXT_NAME: &str = "STATUS.txt";
/// Status for programs.
pub(super) const JSON_NAME: &str = "status.json";

/// Writes both files by rename, each only if its content changed, because each write wakes programs that watch the
/// folder. Returns whether a file was written. If somebody put a link there, the link is replaced, not followed.
pub fn write_status(inbox: &Path, text: &str, json: &str) -> io::Result<bool> {
    let mut written = false;
    let text = &escape_invisible_lines(text);
    for (name, content) in [(TEXT_NAME, text.as_str()), (JSON_NAME, json)] {
        let path = inbox.join(name);
        if !has_content(&path, content) {
            replace_file(&path, content)?;
            written = true;
        }
    }
    Ok(written)
}

fn has_content(path: &Path, content: &str) -> bool {
    let Ok(file) = disk::open_regular_file(path) else { return false };
    let mut now = Vec::new();
    file.take(content.len() as u64 + 1).read_to_end(&mut now).is_ok() && now == content.as_bytes()
}

/// Not fsynced: the file is written again at the next change, and a status lost in a power cut is outdated anyway.
fn replace_file(path: &Path, content: &str) -> io::Result<()> {
    let part = disk::temporary_path(path);
    disk::create_fresh_file(&part)?.write_all(content.as_bytes())?;
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
        std::os::unix::fs::symlink(&precious, disk::temporary_path(&dir.path().join(TEXT_NAME))).unwrap();
        write_status(dir.path(), "0 parts", "{}").unwrap();
        assert_eq!(fs::read_to_string(&precious).unwrap(), "mine");
        assert_eq!(fs::read_to_string(dir.path().join(TEXT_NAME)).unwrap(), "0 parts");
    }
}
