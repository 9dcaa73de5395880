//! Puts a backup of the ledger in its place, and makes it agree with the folders: nothing that was published since is
//! printed again.

use std::{
    fs::{self, File},
    io,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, ensure};

use super::{
    lock::Lock,
    reconcile::{Reconciled, reconcile},
};
use crate::{
    access,
    ledger::{self, Ledger},
    settings::Settings,
};

/// What SQLite and nestd keep beside a ledger.
const BESIDE: [&str; 4] = ["", "-wal", "-shm", ".b3"];

/// What restoring did.
#[derive(Debug)]
pub struct Restored {
    /// Where the ledger that was there is now, if there was one.
    pub aside: Option<PathBuf>,
    /// What the folders told.
    pub reconciled: Reconciled,
}

/// Puts `backup` in the ledger's place; `None` = a new ledger. What was there is kept aside.
///
/// # Errors
/// A daemon serves the farm, the backup is not whole or of a newer nestd, or the disk does not let it.
pub async fn restore(settings: &Settings, backup: Option<&Path>) -> Result<Restored> {
    access::create_private_folders(&settings.state_dir)
        .with_context(|| format!("creating {}", settings.state_dir.display()))?;
    let _lock = Lock::take(&settings.state_dir, jiff::Timestamp::now())?;
    let new = match backup {
        Some(backup) => Some(copy_proved(backup, &settings.ledger).await?),
        None => None,
    };
    let aside = set_aside(&settings.ledger).context("setting the present ledger aside")?;
    if let Some(new) = new {
        fs::rename(&new, &settings.ledger).with_context(|| format!("putting {} in place", new.display()))?;
    }
    let folder = settings.ledger.parent().unwrap_or(Path::new("."));
    File::open(folder).and_then(|folder| folder.sync_all()).context("making it last")?;
    let ledger = Ledger::open(&settings.ledger).await?;
    let reconciled = reconcile(settings, &ledger).await;
    ledger.close_sealed().await?;
    Ok(Restored { aside, reconciled: reconciled? })
}

/// A copy of the backup beside the ledger, on disk, and proved to be whole.
async fn copy_proved(backup: &Path, ledger: &Path) -> Result<PathBuf> {
    let log = with_suffix(backup, "-wal");
    ensure!(
        !fs::metadata(&log).is_ok_and(|log| log.len() > 0),
        "{} lies beside it: this is a ledger in use, not a backup made by `nestd backup`",
        log.display()
    );
    ledger::prove_backup(backup).await?;
    let copy = with_suffix(ledger, ".restoring");
    let copied = fs::copy(backup, &copy).and_then(|_| File::options().write(true).open(&copy)?.sync_all());
    copied.with_context(|| format!("copying {} to {}", backup.display(), copy.display()))?;
    Ok(copy)
}

/// Renames the ledger and what belongs to it; nothing is deleted.
fn set_aside(ledger: &Path) -> io::Result<Option<PathBuf>> {
    let stamp = jiff::Timestamp::now().strftime("%Y%m%dT%H%M%SZ");
    let aside = with_suffix(ledger, &format!(".aside-{stamp}"));
    let mut moved = None;
    for suffix in BESIDE {
        match fs::rename(with_suffix(ledger, suffix), with_suffix(&aside, suffix)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(error),
            Ok(()) => moved = Some(aside.clone()),
        }
    }
    Ok(moved)
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}
