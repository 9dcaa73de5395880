//! Result of reconciling a ledger with its folders: what was done, what a person should check, and what remains to do
//! in the folders.

use std::{collections::HashMap, path::PathBuf};

use anyhow::{Context, Result};
use intake::ContentStore;
use ledger::PartRow;
use settings::{MachineProfile, Settings};

use super::{build_record, folder_builds::FolderExpectations};
use crate::files::error_folder::reason_text;

/// What was done, in sentences.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct ReconcileReport {
    /// What the ledger has learned.
    pub done: Vec<String>,
    /// What a person should check.
    pub doubts: Vec<String>,
    /// Steps in the folders that follow once this ledger is in place; the current ledger may need the folders as they
    /// are until then.
    pub(super) folder_steps: Vec<DeferredFolderStep>,
}

/// A step in the folders that is carried out later.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum DeferredFolderStep {
    /// Set aside a stored file without a note.
    SetFileAside(String),
    /// Set aside a record that cannot be taken in.
    SetRecordAside(PathBuf),
    /// Rewrite a reason in the error folder, since the file now belongs to a part with another number.
    RewriteReason(PathBuf, String),
}

/// Why a part is refused when its note counts more decisions than the ledger.
pub(super) const DECIDED_SINCE: &str = "It was refused, cancelled, taken back or changed after the backup was made";

impl ReconcileReport {
    /// Carries out the remaining steps in the folders; failures are added to the doubts.
    pub(crate) fn apply_folder_steps(&mut self, settings: &Settings) {
        let store = ContentStore::from_dir(settings.state_dir.join("store"));
        for step in std::mem::take(&mut self.folder_steps) {
            let failed = match &step {
                DeferredFolderStep::SetFileAside(hash) => {
                    store.set_aside(hash, &settings.state_dir.join(UNKNOWN_FILES_DIR)).err()
                }
                DeferredFolderStep::SetRecordAside(record) => build_record::set_record_aside(record).err(),
                DeferredFolderStep::RewriteReason(reason, text) => {
                    intake::rewrite_reason(reason, text).err().map(std::io::Error::other)
                }
            };
            self.doubts.extend(failed.map(|error| format!("a step in the folders failed ({step:?}): {error}")));
        }
    }
}

/// In the state folder: stored files without a note.
pub(super) const UNKNOWN_FILES_DIR: &str = "unknown";

/// The files in the error folders, by machine and BLAKE3.
pub(crate) struct ErrorFolderIndex(HashMap<(String, String), Vec<PathBuf>>);

impl ErrorFolderIndex {
    /// Reads all error folders.
    ///
    /// # Errors
    /// A folder cannot be read.
    pub(super) fn read_all(settings: &Settings, known: &FolderExpectations) -> Result<Self> {
        let mut files: HashMap<_, Vec<PathBuf>> = HashMap::new();
        for profile in settings.profiles.values() {
            if !known.is_available(&profile.folders.error)? {
                continue;
            }
            let error_dir = &profile.folders.error;
            let listed = intake::files_below(error_dir).with_context(|| format!("listing {}", error_dir.display()))?;
            for file in listed {
                let name = file.file_name().unwrap_or_default().as_encoded_bytes();
                if name.starts_with(b".") || intake::is_reason_file(&file) {
                    continue;
                }
                let hash = intake::hash_file(&file).with_context(|| format!("reading {}", file.display()))?;
                files.entry((profile.name.clone(), hash)).or_default().push(file);
            }
        }
        Ok(Self(files))
    }

    /// The paths of a content in the error folder of a machine.
    pub(super) fn files_with_content(&self, machine: &str, hash: &str) -> &[PathBuf] {
        self.0.get(&(machine.to_owned(), hash.to_owned())).map_or(&[], Vec::as_slice)
    }
}

/// Copies a refused part's file from the store into the error folder, with its reason.
pub(crate) fn copy_to_error_folder(settings: &Settings, profile: &MachineProfile, part: &PartRow) -> Result<()> {
    let stored = ContentStore::from_dir(settings.state_dir.join("store")).file_path(&part.file.content_hash)?;
    let folder = format!("part-{}", part.id);
    let text = settings.language.within(|| reason_text(part, part.refused.refusal, &part.refused.reason));
    intake::copy_to_error_folder(Some(&stored), &profile.folders.error, &folder, &part.name, &text)
        .with_context(|| format!("copying {} into the error folder", part.name))
}
