//! A file that gets its name when it is whole.

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};

/// A file under a name that nobody looks for, until it is given its own; else it is taken away again.
pub struct Draft {
    /// Where it is written.
    pub hidden: PathBuf,
    target: PathBuf,
}

impl Draft {
    /// A draft that `write` has filled.
    pub fn fill(target: &Path, write: impl FnOnce(File) -> Result<()>) -> Result<Self> {
        let draft = Self::of(target);
        let file = File::create(&draft.hidden).with_context(|| format!("creating {}", draft.hidden.display()))?;
        write(file).with_context(|| format!("writing {}", target.display()))?;
        Ok(draft)
    }

    /// Gives it its name.
    pub fn publish(self) -> Result<()> {
        fs::rename(&self.hidden, &self.target).with_context(|| format!("renaming to {}", self.target.display()))
    }

    fn of(target: &Path) -> Self {
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        Self {
            hidden: target.with_file_name(format!(".{name}.{}.part", std::process::id())),
            target: target.to_owned(),
        }
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // After `publish` there is nothing left to take away.
        let _ = fs::remove_file(&self.hidden);
    }
}
