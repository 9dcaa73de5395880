//! A file that appears under its name only when it is complete.

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};

/// A file that is written under a hidden name and then renamed into place. Without the rename, it is removed on drop.
pub struct AtomicFile {
    /// The hidden path that is written first.
    pub hidden: PathBuf,
    target: PathBuf,
}

impl AtomicFile {
    /// Creates the hidden file and lets `write` fill it.
    pub fn write_hidden(target: &Path, write: impl FnOnce(File) -> Result<()>) -> Result<Self> {
        let draft = Self::for_target(target);
        let file = File::create(&draft.hidden).with_context(|| format!("creating {}", draft.hidden.display()))?;
        write(file).with_context(|| format!("writing {}", target.display()))?;
        Ok(draft)
    }

    /// Renames the file to its target.
    pub fn rename_into_place(self) -> Result<()> {
        fs::rename(&self.hidden, &self.target).with_context(|| format!("renaming to {}", self.target.display()))
    }

    fn for_target(target: &Path) -> Self {
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        Self {
            hidden: target.with_file_name(format!(".{name}.{}.part", std::process::id())),
            target: target.to_owned(),
        }
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        // Fails after `publish`, when the hidden file no longer exists.
        let _ = fs::remove_file(&self.hidden);
    }
}
