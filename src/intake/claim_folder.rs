//! The folder of a claim: its name says what state it is in and whose it is. `.claimed/<id>@<farm>`; one without a farm is of
//! an earlier release and counts as own.

use std::{
    collections::BTreeMap,
    fs, io,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

/// Claims lie here, below the hot folder and so on its own file system.
pub(super) const CLAIMED_DIR: &str = ".claimed";
/// A claim that is being put together.
pub(super) const NEW: &str = ".new-";
/// A claim that is being removed.
pub(super) const DONE: &str = ".done-";

/// Begins the name of the trace of a claim that was taken over: `.adopted-<id>@<former farm>`. It stays: the former farm may
/// come back at any time, also with an older ledger.
pub(super) const ADOPTED: &str = ".adopted-";

/// Held while claims of a hot folder are put together or taken apart: a recovery must not take for a crash's leftover what
/// another thread is putting together. Moving a large file to another file system takes long; other hot folders do not wait.
pub(super) fn claiming(inbox: &Path) -> MutexGuard<'static, ()> {
    static CLAIMING: Mutex<BTreeMap<PathBuf, &'static Mutex<()>>> = Mutex::new(BTreeMap::new());
    let mut known = CLAIMING.lock().unwrap_or_else(PoisonError::into_inner);
    let of_inbox: &'static Mutex<()> = match known.get(inbox) {
        Some(of_inbox) => of_inbox,
        // A process serves few hot folders, and each for long.
        None => known.entry(inbox.to_owned()).or_insert(Box::leak(Box::default())),
    };
    drop(known);
    of_inbox.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The name of a claim's folder; `farm` "" = it says nothing.
pub(super) fn folder_name(id: &str, farm: &str) -> String {
    if farm.is_empty() { id.to_owned() } else { format!("{id}@{farm}") }
}

/// Id and farm of the name of a claim's folder.
pub(super) fn id_and_farm(name: &str) -> (&str, Option<&str>) {
    let name = [NEW, DONE, ADOPTED].iter().find_map(|with| name.strip_prefix(with)).unwrap_or(name);
    name.split_once('@').map_or((name, None), |(id, farm)| (id, Some(farm)))
}

/// Id of the claim whose folder, whole or not, has this name.
pub fn claim_id(name: &str) -> &str {
    id_and_farm(name).0
}

/// Where the trace would be that a claim was taken over.
pub(super) fn taken_over_name(dir: &Path) -> PathBuf {
    dir.with_file_name(format!("{ADOPTED}{}", dir.file_name().unwrap_or_default().to_string_lossy()))
}

/// Whether it is the name of a claim, whole or not, of another farm.
pub(super) fn is_foreign(name: &str, farm: &str) -> bool {
    !name.starts_with(ADOPTED) && id_and_farm(name).1.is_some_and(|of| of != farm)
}

/// Where a claim lies.
pub(super) fn find(inbox: &Path, id: &str) -> Option<PathBuf> {
    let is_it = |name: &&String| !name.starts_with('.') && id_and_farm(name).0 == id;
    Some(inbox.join(CLAIMED_DIR).join(names(inbox).ok()?.iter().find(is_it)?))
}

/// Where a claim lies, or would lie.
pub fn claim_dir(inbox: &Path, id: &str) -> PathBuf {
    find(inbox, id).unwrap_or_else(|| inbox.join(CLAIMED_DIR).join(id))
}

/// The names of all that lies in `.claimed/`.
pub(super) fn names(inbox: &Path) -> io::Result<Vec<String>> {
    let entries = match fs::read_dir(inbox.join(CLAIMED_DIR)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other?,
    };
    let names = entries.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()));
    names.collect()
}
