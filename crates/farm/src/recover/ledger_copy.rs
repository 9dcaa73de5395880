//! Moves a ledger between a file and a server. No daemon serves either of the two meanwhile.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use ledger::{CopyReport, ExistingRows, Ledger, LedgerAddress};

use super::ledger_service::copying_node;
use crate::leases::state_lock::{StateDirLock, host_name};

/// Copies a ledger into another one, which must be empty.
///
/// # Errors
/// A daemon serves one of the two, there is none to copy, the other one is not empty, or one cannot be read or written. The other one
/// is then as it was.
pub async fn copy_ledger(from: &LedgerAddress, to: &LedgerAddress) -> Result<CopyReport> {
    ensure!(from != to, "{from} cannot be copied to itself");
    if Ledger::is_missing(from).await? {
        bail!("there is no ledger at {from}: nothing was copied");
    }
    let (from_folder, to_folder) = (folder_of(from), folder_of(to));
    let _locks =
        [lock_folder(from, from_folder)?, lock_folder(to, to_folder.filter(|folder| Some(*folder) != from_folder))?];
    let source = open_alone(from).await?;
    let copied = copy_opened(&source, to).await;
    source.close().await;
    copied
}

async fn copy_opened(source: &Ledger, to: &LedgerAddress) -> Result<CopyReport> {
    source.check_integrity().await?;
    let due = source.find_repair_due().await?;
    ensure!(due.is_empty(), "it has lost changes of {}: run `nestd check --deep --repair` there first", due.join(", "));
    let target = open_alone(to).await?;
    let copied = source.copy_into_ledger(&target, ExistingRows::Refuse).await;
    target.close_with_checksum().await?;
    Ok(copied?)
}

/// Opens a ledger that no daemon serves. On a server, none can begin to as long as it is open.
async fn open_alone(address: &LedgerAddress) -> Result<Ledger> {
    let node = copying_node(&host_name());
    Ok(Ledger::open_to_serve(address, &node).await?)
}

/// The folder of a file.
fn folder_of(address: &LedgerAddress) -> Option<&Path> {
    let folder = address.file()?.parent().filter(|folder| !folder.as_os_str().is_empty());
    Some(folder.unwrap_or(Path::new(".")))
}

/// Takes the lock that a daemon of a file in this folder would hold.
fn lock_folder(address: &LedgerAddress, folder: Option<&Path>) -> Result<Option<StateDirLock>> {
    let Some(folder) = folder else { return Ok(None) };
    ensure!(folder.is_dir(), "there is no folder {}", folder.display());
    let lock = StateDirLock::acquire(folder, jiff::Timestamp::now());
    lock.map(Some).with_context(|| format!("{address} is copied only while no daemon serves it"))
}
