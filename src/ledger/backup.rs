//! A copy of the ledger while the farm runs: consistent, proved, and there whole or not at all.

use std::{
    fs::{self, File},
    io,
    os::unix::fs::PermissionsExt,
    path::Path,
};

use sqlx::{
    SqlitePool,
    sqlite::{SqliteConnectOptions, SqlitePoolOptions},
};

use super::{Ledger, LedgerError, error::Result, health, place, schema};

impl Ledger {
    /// Writes a copy of the ledger as of now to `file`, which must not be there, and its seal beside it. The copy is
    /// compact, on disk, and every page of it has been checked when this returns. Returns its size, bytes.
    ///
    /// # Errors
    /// `Backup` when it cannot be written, `Damaged` when the copy is not whole; nothing is left behind then.
    pub async fn backup(&self, file: &Path) -> Result<u64> {
        for taken in [file.to_owned(), health::seal_of(file)] {
            if fs::symlink_metadata(&taken).is_ok() {
                return Err(failed(file, format!("{} is there already; nothing was overwritten", taken.display())));
            }
        }
        let folder = tempfile::Builder::new()
            .prefix(".nestd-backup-")
            .tempdir_in(place::folder(file))
            .map_err(|error| failed(file, error))?;
        let copy = folder.path().join("ledger");
        self.copy_into(file, &copy).await?;
        prove(&copy).await?;
        finish(&copy, file).map_err(|error| failed(file, error))
    }

    async fn copy_into(&self, file: &Path, copy: &Path) -> Result<()> {
        let name = copy.to_str().ok_or_else(|| failed(file, "its path is not UTF-8"))?;
        let copied = sqlx::query("VACUUM INTO ?").bind(name).execute(self.writer()).await;
        match copied.map_err(LedgerError::from) {
            Err(LedgerError::Sql(error)) => Err(failed(file, error)),
            other => other.map(drop),
        }
    }
}

fn failed(file: &Path, what: impl ToString) -> LedgerError {
    LedgerError::Backup { path: file.to_owned(), what: what.to_string() }
}

/// Checks every byte of a ledger that nobody uses against its seal, every page of it, and that its schema is none of a newer
/// nestd. Changes nothing.
///
/// # Errors
/// `Damaged` when it is not whole or no ledger, `NewerSchema`, or SQLite's own trouble.
pub async fn prove(file: &Path) -> Result<()> {
    health::look_at_files(file).await?;
    let pool = read_only(file).await?;
    let proved = match schema::demand(file, &pool).await {
        Err(LedgerError::OlderSchema { found: 0, .. }) => {
            Err(LedgerError::Damaged { path: file.to_owned(), what: "it holds no ledger of nestd".to_owned() })
        }
        Err(error) if !matches!(error, LedgerError::OlderSchema { .. }) => Err(error),
        _ => health::check_all(file, &pool).await,
    };
    pool.close().await;
    proved
}

async fn read_only(file: &Path) -> Result<SqlitePool> {
    let options = SqliteConnectOptions::new().filename(file).read_only(true).immutable(true);
    let pool = SqlitePoolOptions::new().max_connections(1).connect_with(options).await;
    pool.map_err(|error| match LedgerError::from(error) {
        LedgerError::Corrupt(what) => LedgerError::Damaged { path: file.to_owned(), what },
        other => other,
    })
}

/// Gives the proved copy its name, which overwrites nothing; the seal comes after it, so that it never vouches for less.
fn finish(copy: &Path, file: &Path) -> io::Result<u64> {
    let whole = File::open(copy)?;
    // It holds what customers sent: its owner's alone until somebody decides otherwise.
    whole.set_permissions(fs::Permissions::from_mode(0o600))?;
    whole.sync_all()?;
    let bytes = whole.metadata()?.len();
    fs::hard_link(copy, file).or_else(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => Err(error),
        // A file system without hard links: it was looked before that the name is free.
        _ => fs::rename(copy, file),
    })?;
    health::write_seal(file, None)?;
    File::open(place::folder(file))?.sync_all()?;
    Ok(bytes)
}
