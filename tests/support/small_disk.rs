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
    pub fn new(at: &Path, bytes: u64) -> Self {
        fs::create_dir_all(at).unwrap();
        Self::try_new(at, bytes).expect("file systems may be mounted here")
    }

    fn try_new(at: &Path, bytes: u64) -> Option<Self> {
        let mount = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={bytes}"), "none"])
            .arg(at)
            .stderr(Stdio::null())
            .status();
        mount.is_ok_and(|status| status.success()).then(|| Self { at: at.to_owned() })
    }

    /// Why there can be none here.
    pub fn missing() -> Option<String> {
        let folder = tempfile::tempdir().unwrap();
        Self::try_new(folder.path(), 1 << 20).is_none().then(|| "needs the right to mount file systems".to_owned())
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
