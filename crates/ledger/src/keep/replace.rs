//! Replaces a ledger that is not in use by another one. The new ledger is prepared beside the old one and takes its
//! place by a single rename, the last step. So after a crash at any moment, either the old or the new ledger is
//! complete.

use std::{
    ffi::OsStr,
    fs::{self, File},
    io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
};

use crate::{
    Ledger, LedgerError,
    base::{error::Result, sql},
    store::{
        health, location,
        sqlite_store::{SqliteStore, connect_options},
    },
};

/// Suffixes of the files that SQLite and nestd keep beside a ledger. Those of the old ledger must be gone before the
/// new one is in place, or SQLite would apply the old write-ahead log to it.
const SIDECAR_SUFFIXES: [&str; 4] = ["-wal", "-shm", ".b3", health::CHANGES_NOTED];
/// Suffix of the ledger that is being prepared.
const RESTORING_SUFFIX: &str = ".restoring";
/// Suffix of a replaced ledger, followed by the time.
const ASIDE_SUFFIX: &str = ".aside-";

impl Ledger {
    /// Begins a new line: a process that has the ledger open that this one was made of must not take it for the same.
    pub async fn begin_line(&self) -> Result<()> {
        let mut change = self.begin_change().await?;
        if self.sqlite().is_some() {
            sql::query("UPDATE change_count SET line = random()").execute(change.db()).await?;
        }
        change.commit().await
    }
}

/// Path where the new ledger is prepared.
pub fn restoring_path(ledger: &Path) -> PathBuf {
    with_suffix(ledger, RESTORING_SUFFIX)
}

/// Removes the remains of a failed or killed restore: the unfinished ledger, and the second name of the ledger that is
/// still in place.
///
/// # Errors
/// The folder cannot be read or changed.
pub fn clear_unfinished(ledger: &Path) -> Result<()> {
    clear_files(ledger).map_err(|source| LedgerError::Folder { path: ledger.to_owned(), source })
}

fn clear_files(ledger: &Path) -> io::Result<()> {
    let new = restoring_path(ledger);
    for suffix in SIDECAR_SUFFIXES.into_iter().chain([""]) {
        remove_if_present(&with_suffix(&new, suffix))?;
    }
    let present = match fs::metadata(ledger) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        other => other?,
    };
    if present.nlink() < 2 {
        return Ok(());
    }
    let mut aside = ledger.file_name().unwrap_or_default().to_owned();
    aside.push(ASIDE_SUFFIX);
    for entry in fs::read_dir(location::parent_folder(ledger))? {
        let entry = entry?;
        let meta = entry.metadata()?;
        let is_aside = entry.file_name().as_encoded_bytes().starts_with(aside.as_encoded_bytes());
        if is_aside && (meta.dev(), meta.ino()) == (present.dev(), present.ino()) {
            remove_if_present(&entry.path())?;
        }
    }
    Ok(())
}

/// Renames the prepared ledger into place. Returns the path where the old one is kept, if there was one.
///
/// An error of the disk. The old ledger is then still in place, or, if it was damaged, there is none.
pub async fn replace_ledger(ledger: &Path) -> Result<Option<PathBuf>> {
    let failed = |source| LedgerError::Folder { path: ledger.to_owned(), source };
    let is_one_file = fold_into_one_file(ledger).await;
    let aside = move_aside(ledger, is_one_file).map_err(failed)?;
    let new = restoring_path(ledger);
    // The new ledger must not have a write-ahead log, because only the main file is renamed.
    if health::has_content(&with_suffix(&new, "-wal")) {
        return Err(failed(io::Error::other("the new ledger is in use")));
    }
    fs::rename(&new, ledger).map_err(failed)?;
    sync_folder(ledger).map_err(failed)?;
    for suffix in SIDECAR_SUFFIXES {
        remove_if_present(&with_suffix(&new, suffix)).map_err(failed)?;
    }
    Ok(aside)
}

/// Folds the write-ahead log into the ledger, so that a single file holds everything. `false` = the ledger is missing,
/// damaged or in use.
async fn fold_into_one_file(ledger: &Path) -> bool {
    if !health::has_content(ledger) {
        return false;
    }
    match health::check_files(ledger).await {
        Ok(true) => return true,
        Err(_) => return false,
        Ok(false) => {}
    }
    let Ok(open) = SqliteStore::connect(ledger, connect_options(ledger)).await else { return false };
    let folded = sqlx::query_as::<_, (i64, i64, i64)>("PRAGMA wal_checkpoint(TRUNCATE)").fetch_one(open.writer()).await;
    open.close().await;
    folded.is_ok_and(|(busy, ..)| busy == 0) && !health::has_content(&with_suffix(ledger, "-wal"))
}

/// Path where a ledger that is replaced now is kept.
pub fn aside_path(ledger: &Path) -> PathBuf {
    let stamp = jiff::Timestamp::now().strftime("%Y%m%dT%H%M%S%3fZ");
    with_suffix(ledger, format!("{ASIDE_SUFFIX}{stamp}"))
}

/// Gives the present ledger another name. If it is complete in one file, it also keeps its own name until the new
/// ledger takes it. Otherwise all its files are moved, the main file first: if this is interrupted, what remains looks
/// like a lost ledger, which no daemon serves.
fn move_aside(ledger: &Path, is_one_file: bool) -> io::Result<Option<PathBuf>> {
    let aside = aside_path(ledger);
    if is_one_file {
        fs::hard_link(ledger, &aside)
            .or_else(|_| fs::copy(ledger, &aside).and_then(|_| File::open(&aside)?.sync_all()))?;
        for suffix in SIDECAR_SUFFIXES {
            remove_if_present(&with_suffix(ledger, suffix))?;
        }
        return sync_folder(ledger).map(|()| Some(aside));
    }
    let mut moved = None;
    for suffix in [""].into_iter().chain(SIDECAR_SUFFIXES) {
        match fs::rename(with_suffix(ledger, suffix), with_suffix(&aside, suffix)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(error),
            Ok(()) => moved = Some(aside.clone()),
        }
    }
    sync_folder(ledger).map(|()| moved)
}

fn sync_folder(ledger: &Path) -> io::Result<()> {
    File::open(location::parent_folder(ledger))?.sync_all()
}

fn remove_if_present(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

fn with_suffix(path: &Path, suffix: impl AsRef<OsStr>) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}
