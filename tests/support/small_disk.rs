//! A file system that is soon full.

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

/// A small file system in memory; unmounted when dropped.
pub struct SmallDisk {
    pub at: PathBuf,
}

impl SmallDisk {
    /// `None` where mounting is not allowed; prints that.
    #[allow(clippy::print_stderr)] // some of the test programs have a harness of their own
    pub fn new(at: &Path, bytes: u64) -> Option<Self> {
        fs::create_dir_all(at).unwrap();
        let mount = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={bytes}"), "none"])
            .arg(at)
            .stderr(Stdio::null())
            .status();
        if !mount.is_ok_and(|status| status.success()) {
            eprintln!("SKIPPED: file systems may not be mounted here");
            return None;
        }
        Some(Self { at: at.to_owned() })
    }

    pub fn fill(&self) {
        let mut bytes = vec![7; 1 << 16];
        let mut file = fs::File::create(self.at.join("filler")).unwrap();
        // Fills the disk to the last byte.
        while !bytes.is_empty() {
            while file.write_all(&bytes).is_ok() {}
            bytes.truncate(bytes.len() / 2);
        }
    }

    pub fn free(&self) {
        fs::remove_file(self.at.join("filler")).unwrap();
    }

    pub fn read_only(&self, is: bool) {
        let word = if is { "remount,ro" } else { "remount,rw" };
        assert!(Command::new("mount").args(["-o", word]).arg(&self.at).status().unwrap().success());
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg("-l").arg(&self.at).stderr(Stdio::null()).status();
    }
}
