//! Checks that the ledger knows everything in the folders: at the start, at every reload and when a folder comes back.
//! An outdated ledger would cause parts to be printed twice, or never.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    time::Duration,
};

use anyhow::{Context, Result};
use delivery::queue::QueueAddress;
use ledger::Ledger;
use settings::{MachineProfile, Settings};
use tokio::sync::OnceCell;

use super::{
    folder_builds::{FolderExpectations, FolderUnavailableError},
    newer_decisions, order_notes,
    reconcile::find_unknown_builds,
};
use crate::{
    alerts::alert::AlertKind,
    files::claim_note,
    leases::{folder_check, own_machines::without_other_nodes},
};

/// The ledger is older than the folders.
#[derive(Debug, thiserror::Error)]
#[error("the ledger is older than the folders: {detail}. {}", AlertKind::LedgerBehind.remedy())]
pub struct LedgerBehindError {
    /// What it does not know.
    pub detail: String,
}

/// Descriptions of what the folders hold and the ledger does not know, and the folders that cannot be read.
///
/// # Errors
/// The ledger or the store cannot be read.
pub async fn find_unknown_to_ledger(
    settings: &Settings,
    ledger: &Ledger,
) -> Result<(Vec<String>, Vec<FolderUnavailableError>)> {
    let (all, settings) = (settings, &without_other_nodes(settings, ledger).await?);
    let (mut unknown, mut unavailable) = (Vec::new(), Vec::new());
    for profile in settings.profiles.values() {
        match find_unknown_build_names(settings, ledger, profile).await {
            Ok(names) => unknown.extend(names),
            Err(error) => unavailable.push(error.downcast::<FolderUnavailableError>()?),
        }
    }
    let kept = claim_note::list_stored_files(settings)?;
    let mut files = claim_note::find_forgotten_files(all, ledger, &kept).await?;
    // A file that is just being claimed is in a hot folder; an unavailable hot folder hides it. What was claimed for a machine that is
    // another node's now lies in the hot folder of that one.
    let is_shared = ledger.file().is_none();
    files.retain(|file| match &file.note {
        None => true,
        Some(taken) => match settings.profiles.get(&taken.part.machine) {
            Some(profile) => profile.folders.inbox.join(".claimed").is_dir(),
            None => !is_shared,
        },
    });
    unknown.extend(files.iter().map(|file| match &file.note {
        Some(taken) => format!("{} ({} copies for {})", file.display_name(), taken.part.copies, taken.part.machine),
        None => file.display_name(),
    }));
    unknown
        .extend(order_notes::find_unknown_lines(ledger, &settings.state_dir).await?.into_iter().map(|(_, line)| line));
    unknown.extend(
        newer_decisions::find_newer_decisions(settings, ledger, &kept)
            .await?
            .iter()
            .map(newer_decisions::describe_decision),
    );
    Ok((unknown, unavailable))
}

/// The builds of a machine that the ledger does not know.
///
/// # Errors
/// [`FolderUnavailableError`] if a folder cannot be read, or an error of the ledger.
pub async fn find_unknown_build_names(
    settings: &Settings,
    ledger: &Ledger,
    profile: &MachineProfile,
) -> Result<Vec<String>> {
    // Folders of a new machine that were never created hold nothing.
    let folders = &profile.folders;
    let mut new_folders = vec![folders.archive.clone()];
    new_folders.extend(profile.queue_folders().map(Path::to_owned));
    new_folders.retain(|folder| !crate::leases::known_folders::is_known_folder(&settings.state_dir, folder));
    let known = FolderExpectations { state_dir: settings.state_dir.clone(), new_folders };
    let builds = find_unknown_builds(settings, ledger, profile, &known, &mut HashSet::new()).await?;
    Ok(builds.into_iter().map(|build| build.name).collect())
}

/// A claim is created, recorded and released within seconds; an older one was abandoned.
const ABANDONED_AFTER: Duration = Duration::from_secs(300);

/// Claims that the ledger does not know, and half-made claims, which no daemon completes before its next start.
///
/// # Errors
/// A hot folder or the ledger cannot be read.
pub async fn find_abandoned_claims(settings: &Settings, ledger: &Ledger) -> Result<Vec<PathBuf>> {
    let (mut claims, mut left) = (HashMap::new(), Vec::new());
    for profile in settings.profiles.values() {
        let inbox = &profile.folders.inbox;
        let work = intake::list_claims(inbox).with_context(|| format!("listing the claims in {}", inbox.display()))?;
        claims.extend(work.claims.into_iter().map(|claim| (claim.id.clone(), intake::claim_dir(inbox, &claim.id))));
        left.extend(work.unfinished);
    }
    let ids: Vec<String> = claims.keys().cloned().collect();
    left.extend(ledger.unknown_claims(&ids).await?.iter().filter_map(|id| claims.remove(id)));
    let is_old = |dir: &PathBuf| {
        let age = std::fs::metadata(dir).and_then(|meta| meta.modified()).map(|at| at.elapsed());
        // A modification time in the future says nothing about the age.
        age.is_ok_and(|age| age.map_or(true, |age| age >= ABANDONED_AFTER))
    };
    left.retain(is_old);
    left.sort();
    Ok(left)
}

/// Fails if the ledger of a farm is older than its folders.
///
/// # Errors
/// [`LedgerBehindError`], or the ledger cannot be read.
pub async fn check_ledger_current(settings: &Settings, ledger: &Ledger) -> Result<()> {
    match summarize_unknown(&find_unknown_to_ledger(settings, ledger).await?.0) {
        Some(detail) => Err(LedgerBehindError { detail }.into()),
        None => Ok(()),
    }
}

/// The first item that the ledger does not know, and the number of others; `None` = it knows all.
pub fn summarize_unknown(unknown: &[String]) -> Option<String> {
    let first = unknown.first()?;
    let more = if unknown.len() > 1 { format!(" and {} more", unknown.len() - 1) } else { String::new() };
    Some(format!("it does not know {first}{more}"))
}

/// Device and inode of a machine's archive, and of those of its queue folders that were there, when they were last compared
/// with the ledger.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FolderIdentities {
    archive: (u64, u64),
    queues: BTreeMap<QueueAddress, (u64, u64)>,
}

impl FolderIdentities {
    /// Looks at the folders; `None` = the archive, or every queue folder, is away. Where one of several printers is away, the others
    /// go on.
    fn look_at(settings: &Settings, profile: &MachineProfile) -> Option<Self> {
        let is_expected = |queue: &QueueAddress| {
            let is_readable = |folder: &Path| folder_check::check_readable(&settings.state_dir, folder).is_ok();
            profile.printers.len() == 1 || queue.folder().is_none_or(is_readable)
        };
        let expected = profile.printers.iter().map(|printer| &printer.queue).filter(|queue| is_expected(queue));
        let queues: BTreeMap<_, _> =
            expected.filter_map(|queue| Some((queue.clone(), queue.identity().ok()??))).collect();
        let archive = std::fs::metadata(&profile.folders.archive).ok()?;
        Some(Self { archive: (archive.dev(), archive.ino()), queues }).filter(|seen| !seen.queues.is_empty())
    }

    /// Whether every queue folder of a machine was there.
    pub fn has_all_queues(&self, profile: &MachineProfile) -> bool {
        profile.printers.iter().all(|printer| self.has_queue(&printer.queue))
    }

    /// Whether a queue was there.
    pub fn has_queue(&self, queue: &QueueAddress) -> bool {
        self.queues.contains_key(queue)
    }
}

/// Result of comparing a machine's folders with the ledger.
#[derive(Debug)]
pub enum FolderComparison {
    /// The folders are still those that agreed with the ledger.
    Unchanged,
    /// The ledger knows everything in them.
    LedgerCurrent(FolderIdentities),
    /// They hold something that the ledger does not know.
    LedgerBehind(String),
    /// One is not there, or is not the one that this farm served. The leases report it.
    FolderAway,
    /// They cannot be read.
    Unavailable(String),
}

/// The store compared with the ledger, once for all machines whose folders are compared together.
#[derive(Debug, Default)]
pub(crate) struct StoreComparison {
    /// What the ledger does not know: machine and description.
    unknown: OnceCell<Vec<(String, String)>>,
}

impl StoreComparison {
    /// Descriptions of what the store holds for a machine and the ledger does not know. The first caller walks the
    /// store.
    async fn unknown_of_machine(&self, settings: &Settings, ledger: &Ledger, machine: &str) -> Result<Vec<String>> {
        let unknown = self.unknown.get_or_try_init(|| find_unknown_in_store(settings, ledger)).await?;
        Ok(unknown.iter().filter(|(of, _)| of == machine).map(|(_, what)| what.clone()).collect())
    }
}

async fn find_unknown_in_store(settings: &Settings, ledger: &Ledger) -> Result<Vec<(String, String)>> {
    let kept = claim_note::list_stored_files(settings)?;
    let files = claim_note::find_forgotten_files(settings, ledger, &kept).await?;
    let decided = newer_decisions::find_newer_decisions(settings, ledger, &kept).await?;
    let files = files.iter().filter_map(|file| Some((file.note.as_ref()?.part.machine.clone(), file.display_name())));
    let decided = decided.iter().map(|claim| (claim.machine.clone(), newer_decisions::describe_decision(claim)));
    let ordered = order_notes::find_unknown_lines(ledger, &settings.state_dir).await?;
    Ok(files.chain(decided).chain(ordered).collect())
}

/// Compares a machine's folders with the ledger, unless they are still those that agreed.
pub(crate) async fn compare_machine_folders(
    settings: &Settings,
    ledger: &Ledger,
    store: &StoreComparison,
    profile: &MachineProfile,
    before: Option<FolderIdentities>,
) -> FolderComparison {
    let seen = match FolderIdentities::look_at(settings, profile) {
        Some(seen) if before.as_ref() == Some(&seen) => return FolderComparison::Unchanged,
        Some(seen) => seen,
        None => return FolderComparison::FolderAway,
    };
    let mut present = profile.clone();
    present.printers.retain(|printer| seen.has_queue(&printer.queue));
    let unknown = async {
        let mut unknown = find_unknown_build_names(settings, ledger, &present).await?;
        unknown.extend(store.unknown_of_machine(settings, ledger, &profile.name).await?);
        anyhow::Ok(unknown)
    };
    match unknown.await {
        Ok(unknown) => {
            summarize_unknown(&unknown).map_or(FolderComparison::LedgerCurrent(seen), FolderComparison::LedgerBehind)
        }
        Err(error) => match error.downcast_ref::<FolderUnavailableError>() {
            Some(unavailable) if unavailable.is_away => FolderComparison::FolderAway,
            _ => FolderComparison::Unavailable(format!("{error:#}")),
        },
    }
}
