//! What the folders tell of builds. A folder that cannot be read tells nothing, which is not the same as that there is nothing:
//! an error of reading is never taken for an empty folder.

use std::{
    collections::HashSet,
    fs, io,
    path::{Path, PathBuf},
};

use super::{marked, owner::OwnerError, record};
use crate::settings::{Profile, Settings};

/// A folder that must be asked and cannot be.
#[derive(Debug, thiserror::Error)]
#[error(
    "{} cannot be looked at ({why}), and nobody else knows what was printed. Mount it again and let nestd's user read it, then \
     try again; if it is lost for good or truly new, say so with `--new-folder {}`", .folder.display(), .folder.display()
)]
pub struct Away {
    /// The folder.
    pub folder: PathBuf,
    /// Why not.
    pub why: String,
}

/// A build of which the folders tell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ToldBuild {
    /// Name of its file.
    pub name: String,
    /// Its record in the archive; `None` = only its file in the queue tells of it.
    pub record: Option<PathBuf>,
}

/// Folders as a person describes them who knows more than the disk.
#[derive(Debug, Default, Clone)]
pub struct Known {
    /// The state folder, which remembers what was served.
    pub state_dir: PathBuf,
    /// Truly new ones: that nothing is there, is all that is to be known of them.
    pub new_folders: Vec<PathBuf>,
}

impl Known {
    /// Whether a folder is there to be asked.
    ///
    /// # Errors
    /// It cannot be read, or is not there and nobody said that it is new.
    pub fn is_there(&self, folder: &Path) -> Result<bool, Away> {
        match marked::demand_readable(&self.state_dir, folder) {
            Ok(()) => Ok(true),
            Err(OwnerError::Io { why, .. }) if why.kind() == io::ErrorKind::NotFound && self.is_new(folder) => {
                Ok(false)
            }
            // Another directory than the one that was served; a person knows that it is meant.
            Err(OwnerError::Replaced(_)) if self.is_new(folder) => Ok(true),
            Err(OwnerError::Io { why, .. }) => Err(away(folder, &why)),
            Err(error) => Err(Away { folder: folder.to_owned(), why: error.to_string() }),
        }
    }

    fn is_new(&self, folder: &Path) -> bool {
        self.new_folders.iter().any(|new| new == folder || fs::canonicalize(new).is_ok_and(|new| new == folder))
    }

    /// Whether every folder that must be asked before a ledger is changed can be.
    ///
    /// # Errors
    /// The first that cannot be.
    pub fn demand_all(&self, settings: &Settings) -> Result<(), Away> {
        for profile in settings.profiles.values() {
            let folders = &profile.folders;
            for folder in [&folders.archive, &folders.queue, &folders.error, &folders.inbox] {
                self.is_there(folder)?;
            }
        }
        Ok(())
    }
}

fn away(folder: &Path, error: &io::Error) -> Away {
    Away { folder: folder.to_owned(), why: error.to_string() }
}

/// The builds of which a machine's archive and queue tell, oldest first.
///
/// # Errors
/// One of the folders cannot be asked.
pub fn builds(profile: &Profile, known: &Known) -> Result<Vec<ToldBuild>, Away> {
    let (archive, queue) = (&profile.folders.archive, &profile.folders.queue);
    let mut told = Vec::new();
    if known.is_there(archive)? {
        let records = record::all(archive).map_err(|error| away(archive, &error))?;
        told.extend(records.into_iter().map(|(name, record)| ToldBuild { name, record: Some(record) }));
    }
    if known.is_there(queue)? {
        let seen: HashSet<String> = told.iter().map(|build| build.name.clone()).collect();
        let names = build_files(queue).map_err(|error| away(queue, &error))?;
        told.extend(names.into_iter().filter(|name| !seen.contains(name)).map(|name| ToldBuild { name, record: None }));
    }
    told.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(told)
}

fn build_files(queue: &Path) -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(queue)? {
        // What is no UTF-8 is no name that nestd gave.
        names.extend(entry?.file_name().into_string().ok());
    }
    names.retain(|name| !name.starts_with('.') && name.ends_with(".build.3mf"));
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_is_not_there_is_not_an_empty_one_unless_a_person_says_so() {
        let dir = tempfile::tempdir().unwrap();
        let gone = dir.path().join("archive");
        let refused = Known::default().is_there(&gone).unwrap_err().to_string();
        assert!(refused.contains("--new-folder") && refused.contains("Mount it again"), "{refused}");
        let known = Known { new_folders: vec![gone.clone()], ..Known::default() };
        assert!(!known.is_there(&gone).unwrap());
        fs::write(&gone, "a file").unwrap();
        assert!(known.is_there(&gone).is_err(), "what is no folder is not new");
    }
}
