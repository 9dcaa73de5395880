//! What came of holding a ledger that went back in time against its folders: what was done, what a person should look at, and
//! what follows in the folders.

use std::{collections::HashMap, path::PathBuf};

use anyhow::{Context, Result};

use super::{
    error_folder::{REASON, reason_text},
    record,
    told::Known,
};
use crate::{
    intake::{self, Store},
    ledger::PartRow,
    settings::{Profile, Settings},
};

/// What was done, in sentences.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Reconciled {
    /// What the ledger knows now that it did not know.
    pub done: Vec<String>,
    /// What a person should look at.
    pub doubts: Vec<String>,
    /// What is to be done in the folders once this ledger is the farm's; before that, the one in place may need them as they
    /// are.
    pub(super) later: Vec<Later>,
}

/// A step in the folders that follows.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Later {
    /// A stored file of which nobody knows what was asked.
    SetFileAside(String),
    /// A record that cannot be taken in.
    SetRecordAside(PathBuf),
    /// A file in the error folder belongs to a part of another number now: its reason says so.
    Rename(PathBuf, String),
}

/// Why a part is taken out of which more was decided than the ledger knows.
pub(super) const DECIDED_SINCE: &str = "It was refused, cancelled or taken back after the backup was made";

impl Reconciled {
    /// Does what follows in the folders; what fails is told.
    pub(super) fn finish(&mut self, settings: &Settings) {
        let store = Store::at(settings.state_dir.join("store"));
        for step in std::mem::take(&mut self.later) {
            let failed = match &step {
                Later::SetFileAside(hash) => store.set_aside(hash, &settings.state_dir.join(UNKNOWN)).err(),
                Later::SetRecordAside(record) => record::set_aside(record).err(),
                Later::Rename(reason, text) => intake::rewrite_reason(reason, text).err().map(std::io::Error::other),
            };
            self.doubts.extend(failed.map(|error| format!("a step in the folders failed ({step:?}): {error}")));
        }
    }
}

/// In the state folder: stored files of which nobody knows what was asked.
pub(super) const UNKNOWN: &str = "unknown";

/// The files of the error folders by content: profile and BLAKE3.
pub(super) struct Refused(HashMap<(String, String), Vec<PathBuf>>);

impl Refused {
    /// Reads all of them.
    ///
    /// # Errors
    /// A folder cannot be asked.
    pub(super) fn read(settings: &Settings, known: &Known) -> Result<Self> {
        let mut files: HashMap<_, Vec<PathBuf>> = HashMap::new();
        for profile in settings.profiles.values() {
            if !known.is_there(&profile.folders.error)? {
                continue;
            }
            let error_dir = &profile.folders.error;
            let listed = intake::files_below(error_dir).with_context(|| format!("listing {}", error_dir.display()))?;
            for file in listed {
                let name = file.file_name().unwrap_or_default().as_encoded_bytes();
                if name.starts_with(b".") || name.ends_with(REASON.as_bytes()) {
                    continue;
                }
                let hash = intake::hash_file(&file).with_context(|| format!("reading {}", file.display()))?;
                files.entry((profile.name.clone(), hash)).or_default().push(file);
            }
        }
        Ok(Self(files))
    }

    /// Where a content lies in the error folder of a profile.
    pub(super) fn of(&self, profile: &str, hash: &str) -> &[PathBuf] {
        self.0.get(&(profile.to_owned(), hash.to_owned())).map_or(&[], Vec::as_slice)
    }
}

/// A refused part's file and its reason in the error folder, from the store.
pub(super) fn put_into_error(settings: &Settings, profile: &Profile, part: &PartRow) -> Result<()> {
    let stored = Store::at(settings.state_dir.join("store")).path(&part.file.content_hash)?;
    let (folder, text) = (format!("part-{}", part.id), reason_text(part, part.refusal, &part.reason));
    intake::refuse_copy(Some(&stored), &profile.folders.error, &folder, &part.name, &text)
        .with_context(|| format!("copying {} into the error folder", part.name))
}
