//! The builds in the folders. A folder that cannot be read is not an empty one: a read error is never taken for "there
//! is nothing".

use std::{
    collections::HashSet,
    fs, io,
    path::{Path, PathBuf},
};

use anyhow::Context;
use delivery::queue::FileState;
use settings::{MachineProfile, Settings};

use super::build_record;
use crate::leases::{folder_check, folder_lease::LeaseError};

/// A folder that must be read and cannot be.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be looked at ({why}), and nothing else shows what was printed{remedy}", .folder.display())]
pub struct FolderUnavailableError {
    /// The folder.
    pub folder: PathBuf,
    /// Why not.
    pub why: String,
    /// Whether the whole folder is not there, is another one, or is served by another daemon.
    pub is_away: bool,
    /// Whether another daemon serves it.
    pub is_served_by_other: bool,
    /// What to do about it, as the rest of the sentence; "" = whoever reports it says so.
    remedy: String,
}

/// A build that was found in the folders.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FolderBuild {
    /// Name of its file.
    pub name: String,
    /// Its record in the archive; `None` = only its file in the queue was found.
    pub record: Option<PathBuf>,
}

/// What a person knows of the folders and the disk does not show.
#[derive(Debug, Default, Clone)]
pub struct FolderExpectations {
    /// The state folder, which stores the folders that were served.
    pub state_dir: PathBuf,
    /// Folders that are new: nothing is expected in them.
    pub new_folders: Vec<PathBuf>,
}

impl FolderExpectations {
    /// Whether a folder can be read; `false` = it is declared as new and does not exist.
    ///
    /// # Errors
    /// It cannot be read, or does not exist and was not declared as new.
    pub fn is_available(&self, folder: &Path) -> Result<bool, FolderUnavailableError> {
        match folder_check::check_readable(&self.state_dir, folder) {
            Ok(()) => Ok(true),
            Err(LeaseError::Io { why, .. })
                if why.kind() == io::ErrorKind::NotFound && self.is_declared_new(folder) =>
            {
                Ok(false)
            }
            // It is another directory than the one that was served, but a person has declared it as new.
            Err(LeaseError::Replaced(_)) if self.is_declared_new(folder) => Ok(true),
            Err(error) => {
                let why = match &error {
                    LeaseError::Io { why, .. } => why.to_string(),
                    other => other.to_string(),
                };
                let remedy = match &error {
                    LeaseError::HeldByOther { .. } => String::new(),
                    _ => format!(
                        ". Mount it again and let nestd's user read it, then try again; if it is lost for good or truly \
                         new, say so with `--new-folder {}`",
                        folder.display()
                    ),
                };
                let is_served_by_other = matches!(error, LeaseError::HeldByOther { .. });
                Err(FolderUnavailableError {
                    folder: folder.to_owned(),
                    why,
                    is_away: true,
                    is_served_by_other,
                    remedy,
                })
            }
        }
    }

    fn is_declared_new(&self, folder: &Path) -> bool {
        self.new_folders.iter().any(|new| new == folder || fs::canonicalize(new).is_ok_and(|new| new == folder))
    }

    /// Checks that every folder can be read that must be before a ledger is changed.
    ///
    /// # Errors
    /// The first folder that cannot be read.
    pub fn check_all_available(&self, settings: &Settings) -> Result<(), FolderUnavailableError> {
        for profile in settings.profiles.values() {
            let folders = &profile.folders;
            for folder in
                [&*folders.archive, &*folders.error, &*folders.inbox].into_iter().chain(profile.queue_folders())
            {
                self.is_available(folder)?;
            }
        }
        Ok(())
    }
}

fn unavailable_error(folder: &Path, error: &io::Error) -> FolderUnavailableError {
    FolderUnavailableError {
        folder: folder.to_owned(),
        why: error.to_string(),
        is_away: false,
        is_served_by_other: false,
        remedy: String::new(),
    }
}

/// The builds in a machine's archive and queues, oldest first.
///
/// # Errors
/// One of the folders cannot be read.
pub fn list_folder_builds(
    profile: &MachineProfile,
    known: &FolderExpectations,
) -> Result<Vec<FolderBuild>, FolderUnavailableError> {
    let archive = &profile.folders.archive;
    let mut builds = Vec::new();
    if known.is_available(archive)? {
        let records = build_record::list_records(archive).map_err(|error| unavailable_error(archive, &error))?;
        builds.extend(records.into_iter().map(|(name, record)| FolderBuild { name, record: Some(record) }));
    }
    for queue in profile.printers.iter().map(|printer| &printer.queue) {
        if let Some(folder) = queue.folder()
            && !known.is_available(folder)?
        {
            continue;
        }
        let seen: HashSet<String> = builds.iter().map(|build| build.name.clone()).collect();
        let names = queue.visible_builds().map_err(|error| unavailable_error(Path::new(&queue.to_string()), &error))?;
        builds.extend(
            names.into_iter().filter(|name| !seen.contains(name)).map(|name| FolderBuild { name, record: None }),
        );
    }
    builds.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(builds)
}

/// Whether the file of a build is still under its dot-name: its record was written, but it was not published. Of several printers, the
/// folder of another one than `queue_id` may still hold what was staged for an earlier attempt: that says nothing.
pub fn is_staged(profile: &MachineProfile, name: &str, queue_id: Option<&str>) -> anyhow::Result<bool> {
    let marker = queue_id.filter(|_| profile.printers.len() > 1);
    for queue in profile.printers.iter().map(|printer| &printer.queue) {
        if queue.identity().with_context(|| format!("looking at {queue}"))?.is_none() {
            continue;
        }
        let state = queue.open().and_then(|queue| match marker.is_none_or(|id| id == queue.id()) {
            true => queue.state(name),
            false => Ok(FileState::Gone),
        });
        if state.with_context(|| format!("looking for {name} in {queue}"))? == FileState::Staged {
            return Ok(true);
        }
    }
    Ok(false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_is_not_there_is_not_an_empty_one_unless_a_person_says_so() {
        let dir = tempfile::tempdir().unwrap();
        let gone = dir.path().join("archive");
        let refused = FolderExpectations::default().is_available(&gone).unwrap_err().to_string();
        assert!(refused.contains("--new-folder") && refused.contains("Mount it again"), "{refused}");
        let known = FolderExpectations { new_folders: vec![gone.clone()], ..FolderExpectations::default() };
        assert!(!known.is_available(&gone).unwrap());
        fs::write(&gone, "a file").unwrap();
        assert!(known.is_available(&gone).is_err(), "what is no folder is not new");
    }
}
