//! Replaces the ledger by a backup, after bringing that up to date with the folders: nothing that was published since
//! is printed again. All work is done on a copy; one rename at the end puts it into place, or one transaction where the
//! ledger is on a server.

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, ensure};
use ledger::{DownPrinter, ExistingRows, Ledger, LedgerAddress, ServingRight};
use settings::Settings;

use super::ledger_service::serving_node;
use crate::{
    leases::{folder_check, own_machines::without_other_nodes, state_lock::StateDirLock},
    records::{folder_builds::FolderExpectations, reconcile::reconcile_ledger, reconcile_report::ReconcileReport},
};

/// Result of restoring.
#[derive(Debug)]
pub struct RestoreOutcome {
    /// Where the previous ledger is now, if there was one.
    pub aside: Option<PathBuf>,
    /// What was learned from the folders.
    pub reconciled: ReconcileReport,
}

/// What the new ledger starts from.
#[derive(Debug, Clone, Copy)]
enum LedgerSource<'a> {
    Backup(&'a Path),
    Empty,
    /// The current ledger.
    Present,
}

/// Replaces the ledger by `backup`; `None` = by a new ledger. The previous ledger is kept aside. `new_folders` are the
/// folders that a person has declared as new.
///
/// # Errors
/// A daemon serves the farm, a folder cannot be read, the backup is damaged or from a newer nestd, or the disk failed.
pub async fn restore_ledger(
    settings: &Settings,
    backup: Option<&Path>,
    new_folders: &[PathBuf],
) -> Result<RestoreOutcome> {
    let begin = backup.map_or(LedgerSource::Empty, LedgerSource::Backup);
    rebuild_ledger(settings, begin, new_folders).await
}

/// Records what the folders hold in the ledger of a farm that no daemon serves, or of a node whose daemon does not run. The other nodes
/// of a farm wait meanwhile where the ledger has lost changes of this one.
///
/// # Errors
/// See [`restore_ledger`].
pub async fn repair_ledger(settings: &Settings, new_folders: &[PathBuf]) -> Result<ReconcileReport> {
    match &settings.ledger {
        LedgerAddress::File(_) => Ok(rebuild_ledger(settings, LedgerSource::Present, new_folders).await?.reconciled),
        LedgerAddress::Server(_) => repair_on_server(settings, new_folders).await,
    }
}

/// Records what the folders of this node hold in the ledger that all nodes share: each finding in a change of its own. What is left by
/// one that is ended before its end is found by the next.
async fn repair_on_server(settings: &Settings, new_folders: &[PathBuf]) -> Result<ReconcileReport> {
    let _lock = lock_state_dir(settings)?;
    let right = ServingRight::RepairedNode(settings.node.name.clone());
    let ledger = Ledger::open_to_serve(&settings.ledger, &serving_node(settings, right)).await?;
    let repair = async {
        // The folders of other nodes' machines are theirs to look at.
        let own = without_other_nodes(settings, &ledger).await?;
        let known = FolderExpectations { state_dir: own.state_dir.clone(), new_folders: new_folders.to_vec() };
        folder_check::watch_other_holders(&own);
        let mut reconciled = reconcile_ledger(&own, &ledger, &known).await?;
        reconciled.apply_folder_steps(&own);
        ledger.record_repair(&settings.node.name).await?;
        anyhow::Ok(reconciled)
    };
    let repaired = repair.await;
    ledger.close().await;
    repaired
}

/// Keeps a daemon of this state folder out.
fn lock_state_dir(settings: &Settings) -> Result<StateDirLock> {
    access::create_private_folders(&settings.state_dir)
        .with_context(|| format!("creating {}", settings.state_dir.display()))?;
    StateDirLock::acquire(&settings.state_dir, jiff::Timestamp::now())
}

async fn rebuild_ledger(
    settings: &Settings,
    begin: LedgerSource<'_>,
    new_folders: &[PathBuf],
) -> Result<RestoreOutcome> {
    let _lock = lock_state_dir(settings)?;
    let base = working_path(settings);
    ledger::clear_unfinished(&base)?;
    // A daemon, on any host, is refused as long as this is open.
    let served = match &settings.ledger {
        LedgerAddress::File(_) => None,
        server => Some(Ledger::open_to_serve(server, &serving_node(settings, ServingRight::WholeLedger)).await?),
    };
    let rebuild = async {
        // The folders of other nodes' machines are theirs to look at.
        let own = match &served {
            Some(served) => without_other_nodes(settings, served).await?,
            None => settings.clone(),
        };
        rebuild_copy(&own, begin, new_folders, &base, served.as_ref()).await
    };
    let rebuilt = rebuild.await;
    if let Some(served) = served {
        served.close().await;
    }
    rebuilt
}

/// Where the copy is made: beside the ledger's file, or in the state folder.
fn working_path(settings: &Settings) -> PathBuf {
    settings.ledger.file().map_or_else(|| settings.state_dir.join("server-ledger.db"), Path::to_owned)
}

async fn rebuild_copy(
    settings: &Settings,
    begin: LedgerSource<'_>,
    new_folders: &[PathBuf],
    base: &Path,
    served: Option<&Ledger>,
) -> Result<RestoreOutcome> {
    let known = FolderExpectations { state_dir: settings.state_dir.clone(), new_folders: new_folders.to_vec() };
    folder_check::watch_other_holders(settings);
    known.check_all_available(settings)?;
    let new = ledger::restoring_path(base);
    match begin {
        LedgerSource::Backup(backup) => copy_verified_backup(backup, &new).await?,
        LedgerSource::Empty => {}
        LedgerSource::Present => {
            let present = Ledger::open_checked(base).await?;
            let copied = present.write_backup(&new).await;
            present.close().await;
            copied?;
        }
    }
    let ledger = Ledger::open(&new).await?;
    let reconciled = reconcile_copy(settings, &ledger, &known).await;
    let down = ledger.down_printers().await;
    let people = match begin {
        LedgerSource::Present => Ok(false),
        // Sessions that ended since the backup would go on.
        _ => ledger.end_all_sessions().await.and(ledger.has_people().await),
    };
    ledger.close_with_checksum().await?;
    let mut reconciled = reconciled?;
    if !matches!(begin, LedgerSource::Present) {
        reconciled.doubts.extend(doubts_on_printers(settings, &down?));
        let people =
            people?.then_some("who may sign in, and with which password, is as in the backup: `nestd people list`");
        reconciled.doubts.extend(people.map(str::to_owned));
    }
    if matches!(begin, LedgerSource::Present) && reconciled == ReconcileReport::default() {
        ledger::clear_unfinished(base)?;
        return Ok(RestoreOutcome { aside: None, reconciled });
    }
    let aside = match served {
        Some(served) => {
            // Before, and again for the machines that the backup has.
            served.mark_repair_due(&settings.node.name).await?;
            let aside = replace_rows(served, base).await?;
            served.mark_repair_due(&settings.node.name).await?;
            Some(aside)
        }
        None => ledger::replace_ledger(base).await?,
    };
    reconciled.apply_folder_steps(settings);
    match served {
        Some(served) => served.record_repair(&settings.node.name).await?,
        None => {
            Ledger::open_existing(base).await?.close_with_checksum().await?;
        }
    }
    Ok(RestoreOutcome { aside, reconciled })
}

/// Brings the copy up to date with the folders. One that does not hold together afterwards is not put into place.
async fn reconcile_copy(settings: &Settings, ledger: &Ledger, known: &FolderExpectations) -> Result<ReconcileReport> {
    let reconciled = reconcile_ledger(settings, ledger, known).await?;
    let faults = ledger.find_inconsistencies().await?;
    ensure!(
        faults.is_empty(),
        "this ledger does not hold together with what the folders tell, so the one that is there stays: {}. Put an older backup back, or \
         begin a new ledger from the folders with `nestd restore --empty`, and report this to nestd's makers",
        faults.join("; ")
    );
    // A process that has the present ledger open must not take this one for the same.
    ledger.begin_line().await?;
    Ok(reconciled)
}

/// Which printers are down is said by people, and only the ledger keeps it.
fn doubts_on_printers(settings: &Settings, down: &[DownPrinter]) -> Vec<String> {
    let mut doubts = Vec::new();
    for profile in settings.profiles.values().filter(|profile| profile.has_named_printers()) {
        let is_down = |name: &str| down.iter().any(|down| down.machine == profile.name && down.printer == name);
        let names = profile.printers.iter().map(|printer| printer.name.as_str());
        let up: Vec<&str> = names.filter(|name| !is_down(name)).collect();
        if !up.is_empty() {
            doubts.push(format!(
                "of {}, {} in use now: what was said of them after the backup was made is lost. Say `nestd printer NAME down` again \
                 for each that is not to take builds",
                profile.name,
                if up.len() == 1 { format!("the printer {} is", up[0]) } else { format!("the printers {} are", up.join(", ")) }
            ));
        }
    }
    doubts
}

/// Puts the rows of the prepared copy in place of those on the server, in one transaction. Returns the file that keeps the
/// earlier ones.
async fn replace_rows(served: &Ledger, base: &Path) -> Result<PathBuf> {
    let aside = ledger::aside_path(base);
    served.write_backup(&aside).await.context("keeping the ledger that is on the server")?;
    let new = Ledger::open_existing(&ledger::restoring_path(base)).await?;
    let copied = new.copy_into_ledger(served, ExistingRows::Replace).await;
    new.close().await;
    copied?;
    ledger::clear_unfinished(base)?;
    Ok(aside)
}

/// Copies the backup beside the ledger, after checking that it is intact; the copy is on disk when this returns.
async fn copy_verified_backup(backup: &Path, copy: &Path) -> Result<()> {
    let found = fs::metadata(backup).with_context(|| format!("reading the backup {}", backup.display()))?;
    ensure!(found.is_file(), "{} is no file: name the file that `nestd backup` has written", backup.display());
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
