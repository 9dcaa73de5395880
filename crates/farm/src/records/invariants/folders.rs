//! The files in the error, archive and hot folders, by content.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    path::{Path, PathBuf},
};

use anyhow::Result;
use intake::ClaimsOnDisk;
use ledger::{Ledger, PartState};
use settings::Settings;

use super::report::{Invariant, InvariantExpectations, InvariantReport};

/// Files of a folder by BLAKE3.
pub type FilesByHash = HashMap<String, Vec<PathBuf>>;

/// The files in the folders of all machines, by the name of the machine.
#[derive(Debug, Default)]
pub struct FolderContents {
    /// Refused files.
    pub error: BTreeMap<String, FilesByHash>,
    /// Claims.
    pub work: BTreeMap<String, ClaimsOnDisk>,
    /// Files that were dropped and not claimed; only read if the number of drops is known.
    pub inbox: BTreeMap<String, FilesByHash>,
}

impl FolderContents {
    /// Reads all folders. A folder that cannot be read is a violation, since its contents are not known.
    pub async fn read_all(
        settings: &Settings,
        witness: &InvariantExpectations,
        ledger: &Ledger,
        report: &mut InvariantReport,
    ) -> Result<Self> {
        let mut folders = Self::default();
        let refused = ledger.parts_in_state(PartState::Refused).await?;
        for (name, profile) in &settings.profiles {
            let sizes: HashSet<u64> = refused.iter().filter(|p| p.machine == *name).map(|p| p.file.bytes).collect();
            let wanted = |size| witness.at_rest || sizes.contains(&size);
            let error = files_by_hash(&profile.folders.error, wanted, report);
            folders.error.insert(name.clone(), error);
            match intake::list_claims(&profile.folders.inbox) {
                Ok(work) => drop(folders.work.insert(name.clone(), work)),
                Err(error) => report_unreadable(&profile.folders.inbox.join(".claimed"), &error, report),
            }
            if !witness.dropped.is_empty() {
                folders.inbox.insert(name.clone(), dropped_files_by_hash(&profile.folders.inbox, report));
            }
        }
        Ok(folders)
    }
}

/// The regular files below a folder whose size is wanted; none if the folder does not exist.
pub fn files_by_hash(folder: &Path, wanted: impl Fn(u64) -> bool, report: &mut InvariantReport) -> FilesByHash {
    let mut found = FilesByHash::new();
    if !folder.exists() {
        return found;
    }
    let files = match intake::files_below(folder) {
        Ok(files) => files,
        Err(error) => {
            report_unreadable(folder, &error, report);
            return found;
        }
    };
    for file in files {
        let Ok(meta) = std::fs::symlink_metadata(&file) else { continue };
        let name = file.file_name().unwrap_or_default().as_encoded_bytes();
        if !meta.is_file() || !wanted(meta.len()) || name.starts_with(b".") || intake::is_reason_file(&file) {
            continue;
        }
        add_file_by_hash(&mut found, file, report);
    }
    found
}

fn dropped_files_by_hash(inbox: &Path, report: &mut InvariantReport) -> FilesByHash {
    let mut found = FilesByHash::new();
    match intake::scan_inbox(inbox, intake::ScanLimits::default()) {
        Ok(listing) => {
            for seen in listing.entries.into_iter().filter(|seen| seen.kind == intake::EntryKind::File) {
                add_file_by_hash(&mut found, seen.path, report);
            }
        }
        Err(error) => report.add_violation(Invariant::I1, error.to_string(), "mount it again and look once more"),
    }
    found
}

fn add_file_by_hash(found: &mut FilesByHash, file: PathBuf, report: &mut InvariantReport) {
    match intake::hash_file(&file) {
        Ok(hash) => {
            report.files_read += 1;
            found.entry(hash).or_default().push(file);
        }
        // The file was taken meanwhile.
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
        Err(error) => report_unreadable(&file, &error, report),
    }
}

fn report_unreadable(path: &Path, error: &std::io::Error, report: &mut InvariantReport) {
    let text = format!("{} cannot be read ({error}), so that nothing is known of what lies there", path.display());
    report.add_violation(Invariant::I1, text, "let nestd's user read it, check the disk, and look once more");
}
