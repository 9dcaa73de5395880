//! Puts another ledger in the place of one that nobody uses. Everything is made ready beside it; one rename, the last step,
//! makes the change, so that a crash at any moment leaves the one or the other whole.

use std::{
    ffi::OsStr,
    fs::{self, File},
    io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
};

use super::{Ledger, LedgerError, error::Result, health, ledger::options, place};

/// What SQLite and nestd keep beside a ledger. Of the old one it must be gone before the new one stands there: SQLite would
/// play the old write-ahead log into it.
const BESIDE: [&str; 4] = ["-wal", "-shm", ".b3", health::CHANGES_NOTED];
/// Ends the name of the ledger that is being made ready.
const NEW: &str = ".restoring";
/// Follows the name of a ledger that another one took the place of.
const ASIDE: &str = ".aside-";

/// Where the ledger is made ready that is to take the place of this one.
pub fn restoring(ledger: &Path) -> PathBuf {
    with_suffix(ledger, NEW)
}

/// Removes what an ended or killed restore left: the unfinished ledger, and a second name of the one that is still in place.
///
/// # Errors
/// The folder cannot be read or changed.
pub fn clear_unfinished(ledger: &Path) -> Result<()> {
    clear(ledger).map_err(|source| LedgerError::Folder { path: ledger.to_owned(), source })
}

fn clear(ledger: &Path) -> io::Result<()> {
    let new = restoring(ledger);
    for suffix in BESIDE.into_iter().chain([""]) {
        remove(&with_suffix(&new, suffix))?;
    }
    let present = match fs::metadata(ledger) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        other => other?,
    };
    if present.nlink() < 2 {
        return Ok(());
    }
    let mut aside = ledger.file_name().unwrap_or_default().to_owned();
    aside.push(ASIDE);
    for entry in fs::read_dir(place::folder(ledger))? {
        let entry = entry?;
        let meta = entry.metadata()?;
        let is_aside = entry.file_name().as_encoded_bytes().starts_with(aside.as_encoded_bytes());
        if is_aside && (meta.dev(), meta.ino()) == (present.dev(), present.ino()) {
            remove(&entry.path())?;
        }
    }
    Ok(())
}

/// Renames the ledger that was made ready into its place. Returns where the one that was there is kept, if there was one.
///
/// # Errors
/// The disk does not let it; then the old ledger is in its place still, or, where it was damaged, none is.
pub async fn replace(ledger: &Path) -> Result<Option<PathBuf>> {
    let failed = |source| LedgerError::Folder { path: ledger.to_owned(), source };
    let is_one_file = is_one_file(ledger).await;
    let aside = aside(ledger, is_one_file).map_err(failed)?;
    let new = restoring(ledger);
    // Nothing of the new one may stand in a log of its own: only the file itself is renamed.
    if health::holds_something(&with_suffix(&new, "-wal")) {
        return Err(failed(io::Error::other("the new ledger is in use")));
    }
    fs::rename(&new, ledger).map_err(failed)?;
    sync_folder(ledger).map_err(failed)?;
    for suffix in BESIDE {
        remove(&with_suffix(&new, suffix)).map_err(failed)?;
    }
    Ok(aside)
}

/// Folds the log of a ledger into it, so that one file holds all; `false` = it is not there, damaged or in use.
async fn is_one_file(ledger: &Path) -> bool {
    if !health::holds_something(ledger) {
        return false;
    }
    match health::look_at_files(ledger).await {
        Ok(true) => return true,
        Err(_) => return false,
        Ok(false) => {}
    }
    let Ok(open) = Ledger::connect(ledger, options(ledger)).await else { return false };
    let folded = sqlx::query_as::<_, (i64, i64, i64)>("PRAGMA wal_checkpoint(TRUNCATE)").fetch_one(open.writer()).await;
    open.close().await;
    folded.is_ok_and(|(busy, ..)| busy == 0) && !health::holds_something(&with_suffix(ledger, "-wal"))
}

/// Gives the present ledger another name. One that is whole in one file keeps its own too, until the new one takes it; of
/// any other all files are moved, the ledger first: what is left looks like a lost ledger, which no daemon serves.
fn aside(ledger: &Path, is_one_file: bool) -> io::Result<Option<PathBuf>> {
    let stamp = jiff::Timestamp::now().strftime("%Y%m%dT%H%M%S%3fZ");
    let aside = with_suffix(ledger, format!("{ASIDE}{stamp}"));
    if is_one_file {
        fs::hard_link(ledger, &aside)
            .or_else(|_| fs::copy(ledger, &aside).and_then(|_| File::open(&aside)?.sync_all()))?;
        for suffix in BESIDE {
            remove(&with_suffix(ledger, suffix))?;
        }
        return sync_folder(ledger).map(|()| Some(aside));
    }
    let mut moved = None;
    for suffix in [""].into_iter().chain(BESIDE) {
        match fs::rename(with_suffix(ledger, suffix), with_suffix(&aside, suffix)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(error),
            Ok(()) => moved = Some(aside.clone()),
        }
    }
    sync_folder(ledger).map(|()| moved)
}

fn sync_folder(ledger: &Path) -> io::Result<()> {
    File::open(place::folder(ledger))?.sync_all()
}

fn remove(path: &Path) -> io::Result<()> {
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
