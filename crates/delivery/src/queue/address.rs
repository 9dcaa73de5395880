//! Where the queue of a printer is, as the settings say, and what can be asked of it before it is open.

use std::{
    fmt, fs, io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
};

use super::file_names;

/// Where the queue of a printer is.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum QueueAddress {
    /// A folder that the printer, or its software, looks into.
    Folder(PathBuf),
}

impl QueueAddress {
    /// The folder of this machine that it is; `None` = it is none. The farm creates, leases and checks it with its other folders.
    pub fn folder(&self) -> Option<&Path> {
        let Self::Folder(folder) = self;
        Some(folder)
    }

    /// What tells it from another one in its place, of a folder device and inode; `None` = it is not there.
    pub fn identity(&self) -> io::Result<Option<(u64, u64)>> {
        let Self::Folder(folder) = self;
        match fs::metadata(folder) {
            Ok(meta) => Ok(Some((meta.dev(), meta.ino()))),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The names of the builds that are visible, also in a queue that was never opened.
    pub fn visible_builds(&self) -> io::Result<Vec<String>> {
        let Self::Folder(folder) = self;
        let mut names = Vec::new();
        for entry in fs::read_dir(folder)? {
            // nestd gives only names in UTF-8.
            names.extend(entry?.file_name().into_string().ok());
        }
        names.retain(|name| !name.starts_with('.') && file_names::build_stem(name).is_ok());
        Ok(names)
    }

    /// The path under which this machine can read a visible file, if it is there.
    pub fn visible_file(&self, name: &str) -> PathBuf {
        let Self::Folder(folder) = self;
        folder.join(name)
    }
}

impl fmt::Display for QueueAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Folder(folder) = self;
        folder.display().fmt(f)
    }
}
