//! Puts a backup of the ledger in its place, after it was made to agree with the folders: nothing that was published since is
//! printed again. All is done on a copy; one rename at the end makes it the farm's ledger.

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, ensure};

use super::{lock::Lock, reconcile::reconcile, reconciled::Reconciled, told::Known};
use crate::{
    access,
    ledger::{self, Ledger},
    settings::Settings,
};

/// What restoring did.
#[derive(Debug)]
pub struct Restored {
    /// Where the ledger that was there is now, if there was one.
    pub aside: Option<PathBuf>,
    /// What the folders told.
    pub reconciled: Reconciled,
}

/// What the new ledger begins with.
#[derive(Debug, Clone, Copy)]
enum Begin<'a> {
    Backup(&'a Path),
    Empty,
    /// The ledger that is in place.
    Present,
}

/// Puts `backup` in the ledger's place; `None` = a new ledger. What was there is kept aside. `new_folders` are those of which a
/// person says that they are truly new.
///
/// # Errors
/// A daemon serves the farm, a folder cannot be asked, the backup is not whole or of a newer nestd, or the disk does not let it.
pub async fn restore(settings: &Settings, backup: Option<&Path>, new_folders: &[PathBuf]) -> Result<Restored> {
    let begin = backup.map_or(Begin::Empty, Begin::Backup);
    begin_anew(settings, begin, new_folders).await
}

/// Takes what the folders tell into the ledger of a farm that no daemon serves.
///
/// # Errors
/// As [`restore`].
pub async fn repair(settings: &Settings, new_folders: &[PathBuf]) -> Result<Reconciled> {
    Ok(begin_anew(settings, Begin::Present, new_folders).await?.reconciled)
}

async fn begin_anew(settings: &Settings, begin: Begin<'_>, new_folders: &[PathBuf]) -> Result<Restored> {
    access::create_private_folders(&settings.state_dir)
        .with_context(|| format!("creating {}", settings.state_dir.display()))?;
    let _lock = Lock::take(&settings.state_dir, jiff::Timestamp::now())?;
    ledger::clear_unfinished(&settings.ledger)?;
    let known = Known { state_dir: settings.state_dir.clone(), new_folders: new_folders.to_vec() };
    known.demand_all(settings)?;
    let new = ledger::restoring(&settings.ledger);
    match begin {
        Begin::Backup(backup) => copy_proved(backup, &new).await?,
        Begin::Empty => {}
        Begin::Present => {
            let present = Ledger::open_whole(&settings.ledger).await?;
            let copied = present.backup(&new).await;
            present.close().await;
            copied?;
        }
    }
    let ledger = Ledger::open(&new).await?;
    let reconciled = reconcile(settings, &ledger, &known).await;
    ledger.close_sealed().await?;
    let mut reconciled = reconciled?;
    if matches!(begin, Begin::Present) && reconciled == Reconciled::default() {
        ledger::clear_unfinished(&settings.ledger)?;
        return Ok(Restored { aside: None, reconciled });
    }
    let aside = ledger::replace(&settings.ledger).await?;
    reconciled.finish(settings);
    Ledger::open_existing(&settings.ledger).await?.close_sealed().await?;
    Ok(Restored { aside, reconciled })
}

/// A copy of the backup beside the ledger, on disk, and proved to be whole.
async fn copy_proved(backup: &Path, copy: &Path) -> Result<()> {
    let mut log = backup.as_os_str().to_owned();
    log.push("-wal");
    ensure!(
        !fs::metadata(&log).is_ok_and(|log| log.len() > 0),
        "{} lies beside it: this is a ledger in use, not a backup made by `nestd backup`",
        Path::new(&log).display()
    );
    ledger::prove_backup(backup).await?;
    let copied = fs::copy(backup, copy).and_then(|_| File::options().write(true).open(copy)?.sync_all());
    copied.with_context(|| format!("copying {} to {}", backup.display(), copy.display()))
}
