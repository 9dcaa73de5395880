//! Backs up the ledger while the farm runs. The copy is consistent, verified, and exists completely or not at all.

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

use crate::{
    CopyError, ExistingRows, Ledger, LedgerError,
    base::error::Result,
    store::{health, location, schema},
};

impl Ledger {
    /// Writes a copy of the present ledger, also of one on a server, to `file`, which must not exist, and its checksum file beside it. On return
    /// the copy is compact, durable, and every page of it has been checked. Returns its size, bytes.
    ///
    /// `Backup` if the copy cannot be written, `Damaged` if the copy is damaged. In both cases no file remains.
    pub async fn write_backup(&self, file: &Path) -> Result<u64> {
        for taken in [file.to_owned(), health::checksum_path(file)] {
            if fs::symlink_metadata(&taken).is_ok() {
                return Err(backup_error(
                    file,
                    format!("{} is there already; nothing was overwritten", taken.display()),
                ));
            }
        }
        let folder = tempfile::Builder::new()
            .prefix(".nestd-backup-")
            .tempdir_in(location::parent_folder(file))
            .map_err(|error| backup_error(file, error))?;
        let copy = folder.path().join("ledger");
        self.copy_into(file, &copy).await?;
        prove_backup(&copy).await?;
        finish_backup(&copy, file).map_err(|error| backup_error(file, error))
    }

    async fn copy_into(&self, file: &Path, copy: &Path) -> Result<()> {
        let name = copy.to_str().ok_or_else(|| backup_error(file, "its path is not UTF-8"))?;
        let Some(store) = self.sqlite() else {
            let new = Self::open(copy).await?;
            let copied = self.copy_into_ledger(&new, ExistingRows::Refuse).await;
            new.close_with_checksum().await?;
            return match copied {
                Err(CopyError::Ledger(error)) => Err(error),
                other => other.map(drop).map_err(|error| backup_error(file, error)),
            };
        };
        let copied = sqlx::query("VACUUM INTO ?").bind(name).execute(store.writer()).await;
        match copied.map_err(LedgerError::from) {
            Err(LedgerError::Sql(error)) => Err(backup_error(file, error)),
            other => other.map(drop),
        }
    }
}

fn backup_error(file: &Path, what: impl ToString) -> LedgerError {
    LedgerError::Backup { path: file.to_owned(), what: what.to_string() }
}

/// Verifies a ledger that is not in use: every byte against its checksum, every page, and that its schema is not newer
/// than this nestd. Changes nothing.
///
/// `Damaged` if the file is damaged or is not a ledger, `NewerSchema`, or an error of SQLite.
pub async fn prove_backup(file: &Path) -> Result<()> {
    health::check_files(file).await?;
    let pool = open_read_only(file).await?;
    let proved = match schema::ensure_current_version(file, &pool).await {
        Err(LedgerError::OlderSchema { found: 0, .. }) => {
            Err(LedgerError::Damaged { path: file.to_owned(), what: "it holds no ledger of nestd".to_owned() })
        }
        Err(error) if !matches!(error, LedgerError::OlderSchema { .. }) => Err(error),
        _ => health::check_database(file, &pool).await,
    };
    pool.close().await;
    proved
}

async fn open_read_only(file: &Path) -> Result<SqlitePool> {
    let options = SqliteConnectOptions::new().filename(file).read_only(true).immutable(true);
    let pool = SqlitePoolOptions::new().max_connections(1).connect_with(options).await;
    pool.map_err(|error| match LedgerError::from(error) {
        LedgerError::Corrupt(what) => LedgerError::Damaged { path: file.to_owned(), what },
        other => other,
    })
}

/// Gives the verified copy its final name without overwriting a file. The checksum is written afterwards, so it never
/// describes an incomplete file.
fn finish_backup(copy: &Path, file: &Path) -> io::Result<u64> {
    let whole = File::open(copy)?;
    // It contains customer data: only its owner may read it, until somebody decides otherwise.
    whole.set_permissions(fs::Permissions::from_mode(0o600))?;
    whole.sync_all()?;
    let bytes = whole.metadata()?.len();
    fs::hard_link(copy, file).or_else(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => Err(error),
        // A file system without hard links: the name was checked to be free before.
        _ => fs::rename(copy, file),
    })?;
    health::write_checksum(file, None)?;
    File::open(location::parent_folder(file))?.sync_all()?;
    Ok(bytes)
}
