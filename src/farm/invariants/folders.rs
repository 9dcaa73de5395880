//! What lies in the error, archive and hot folders, by content.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    path::{Path, PathBuf},
};

use anyhow::Result;

use super::looked::{Invariant, Looked, Witness};
use crate::{
    intake::{self, Work},
    ledger::{Ledger, PartState},
    settings::Settings,
};

/// The files of a folder by the BLAKE3 of each.
pub type ByHash = HashMap<String, Vec<PathBuf>>;

/// What was found in the folders of every machine, by profile.
#[derive(Debug, Default)]
pub struct Folders {
    /// Refused files.
    pub error: BTreeMap<String, ByHash>,
    /// Claims.
    pub work: BTreeMap<String, Work>,
    /// Files that were dropped and not taken; only asked for where there is a witness.
    pub inbox: BTreeMap<String, ByHash>,
}

impl Folders {
    /// Reads them. What cannot be read is a violation, for nothing can be said of what lies there.
    pub async fn read(settings: &Settings, witness: &Witness, ledger: &Ledger, looked: &mut Looked) -> Result<Self> {
        let mut folders = Self::default();
        let refused = ledger.parts_in_state(PartState::Rejected).await?;
        for (name, profile) in &settings.profiles {
            let sizes: HashSet<u64> = refused.iter().filter(|p| p.profile == *name).map(|p| p.file.bytes).collect();
            let wanted = |size| witness.at_rest || sizes.contains(&size);
            let error = by_hash(&profile.folders.error, wanted, looked);
            folders.error.insert(name.clone(), error);
            match intake::work(&profile.folders.inbox) {
                Ok(work) => drop(folders.work.insert(name.clone(), work)),
                Err(error) => unreadable(&profile.folders.inbox.join(".claimed"), &error, looked),
            }
            if !witness.dropped.is_empty() {
                folders.inbox.insert(name.clone(), in_hot_folder(&profile.folders.inbox, looked));
            }
        }
        Ok(folders)
    }
}

/// The regular files below a folder whose size is wanted; one that is not there holds none.
pub fn by_hash(folder: &Path, wanted: impl Fn(u64) -> bool, looked: &mut Looked) -> ByHash {
    let mut found = ByHash::new();
    if !folder.exists() {
        return found;
    }
    let files = match intake::files_below(folder) {
        Ok(files) => files,
        Err(error) => {
            unreadable(folder, &error, looked);
            return found;
        }
    };
    for file in files {
        let Ok(meta) = std::fs::symlink_metadata(&file) else { continue };
        let name = file.file_name().unwrap_or_default().as_encoded_bytes();
        if !meta.is_file() || !wanted(meta.len()) || name.starts_with(b".") || name.ends_with(b".reason.txt") {
            continue;
        }
        hash_into(&mut found, file, looked);
    }
    found
}

fn in_hot_folder(inbox: &Path, looked: &mut Looked) -> ByHash {
    let mut found = ByHash::new();
    match intake::scan(inbox, intake::ScanLimits::default()) {
        Ok(listing) => {
            for seen in listing.seen.into_iter().filter(|seen| seen.kind == intake::Kind::File) {
                hash_into(&mut found, seen.path, looked);
            }
        }
        Err(error) => looked.found(Invariant::I1, error.to_string(), "mount it again and look once more"),
    }
    found
}

fn hash_into(found: &mut ByHash, file: PathBuf, looked: &mut Looked) {
    match intake::hash_file(&file) {
        Ok(hash) => {
            looked.files += 1;
            found.entry(hash).or_default().push(file);
        }
        // Somebody took it meanwhile.
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
        Err(error) => unreadable(&file, &error, looked),
    }
}

fn unreadable(path: &Path, error: &std::io::Error, looked: &mut Looked) {
    let text = format!("{} cannot be read ({error}), so that nothing is known of what lies there", path.display());
    looked.found(Invariant::I1, text, "let nestd's user read it, check the disk, and look once more");
}
