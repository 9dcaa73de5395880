//! Copies that are printed again need their original, which lies in the archive once their part was built; that of a part which was
//! moved to this node lies on another one. A job copies it into the store, with a note of the claim. Where neither holds it any more,
//! the same file must be dropped again.

use std::path::{Path, PathBuf};

use anyhow::Result;
use intake::{ContentStore, StoreError};
use jobs::BackgroundJob;
use ledger::{BuildState, Ledger, PartRow, PartState};
use tracing::info;

use crate::{
    alerts::{alert::AlertKind, failure::LostFileError},
    core::{
        desks::{Receiving, Shared},
        farm::Farm,
    },
    files::claim_note::ClaimNote,
    leases::folder_leases::FolderLeases,
    nesting::node_content::{OtherNodes, archive_folders, find_original},
    receive::damaged_files,
    records::kept_build::KeptBuild,
};

/// What fails, and is tried again later, when an original cannot be fetched.
const BACKOFF: &str = "fetching originals";

/// Copies originals back from the archive.
#[derive(Clone)]
pub(crate) struct FetchOriginalsJob;

/// What became of the originals, by content hash.
#[derive(Debug, Default)]
pub(crate) struct FetchedOriginals {
    /// In the store.
    stored: Vec<String>,
    /// In no archive, but not needed: their build is issued once more from its kept file.
    unneeded: Vec<String>,
    /// In no archive, with the name of a part.
    missing: Vec<(String, String)>,
    /// Failures that are retried.
    failures: Vec<String>,
}

impl BackgroundJob<Farm> for FetchOriginalsJob {
    const KIND: &'static str = "Fetch";
    type Outcome = FetchedOriginals;
    type Desk<'f> = Receiving<'f>;

    fn subject(&self) -> String {
        String::new()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, fetched: Self::Outcome) -> Result<()> {
        on_fetched(&mut desk, fetched).await
    }
}

/// The original of a part, and where it may be.
struct WantedOriginal {
    hash: String,
    name: String,
    claim: String,
    note: String,
    decisions: u32,
    /// The folders of its builds in the archive, newest first.
    folders: Vec<PathBuf>,
    /// The kept file of the build that is issued once more.
    kept: Option<KeptBuild>,
    leases: FolderLeases,
}

/// Starts to fetch the originals of parts that are printed again.
pub(crate) async fn fetch_originals(desk: &mut Receiving<'_>) -> Result<()> {
    if desk.jobs.is_running::<FetchOriginalsJob>("")
        || desk.shared.schedule.step_backoff.is_waiting(&BACKOFF.to_owned())
    {
        return Ok(());
    }
    let mut wanted = Vec::new();
    for part in desk.shared.ledger.parts_to_fetch().await? {
        // The stored file is being removed, because its part was built: it is fetched after that.
        if !desk.completion.forgetting.is_under_way(&part.file.content_hash) {
            wanted.extend(wanted_original(desk, part).await?);
        }
    }
    if wanted.is_empty() {
        return Ok(());
    }
    let store = desk.meshes.store.clone();
    let nodes = OtherNodes::of_ledger(desk.shared.settings, desk.shared.ledger).await?;
    desk.jobs.start(FetchOriginalsJob, move || {
        let mut fetched = FetchedOriginals::default();
        for original in &wanted {
            match original.copy_into_store(&store, &nodes) {
                Ok(true) => fetched.stored.push(original.hash.clone()),
                Ok(false) if original.has_kept_build() => fetched.unneeded.push(original.hash.clone()),
                Ok(false) => fetched.missing.push((original.hash.clone(), original.name.clone())),
                Err(failure) => fetched.failures.push(format!("{}: {failure:#}", original.name)),
            }
        }
        fetched
    });
    Ok(())
}

/// Whether a part of a machine waits for its original, and will have it soon.
pub(crate) async fn awaits_original(shared: &Shared<'_>, machine: &str) -> Result<bool> {
    let is_failing = shared.schedule.step_backoff.is_failing(&BACKOFF.to_owned());
    Ok(!is_failing && shared.ledger.parts_to_fetch().await?.iter().any(|part| part.machine == machine))
}

async fn wanted_original(desk: &Receiving<'_>, part: PartRow) -> Result<Option<WantedOriginal>> {
    let Some(machine) = desk.machines.get(&part.machine) else { return Ok(None) };
    let machine_named = |name: &str| desk.machines.get(name).map(|machine| &*machine.profile);
    let mut folders = archive_folders(desk.shared.ledger, &part.file.content_hash, machine_named).await?;
    // The original of a part that was not read yet, where the machine came from another node.
    folders.push(intake::claim_dir(&machine.profile.folders.inbox, &part.file.claim));
    Ok(Some(WantedOriginal {
        hash: part.file.content_hash.clone(),
        name: part.full_name(),
        claim: part.file.claim.clone(),
        decisions: desk.shared.ledger.decision_count(&part.file.claim).await?,
        note: ClaimNote::of_part(desk.shared.lifecycle.holder.farm_id(), &part).to_text(),
        folders,
        kept: find_kept_build(desk.shared.ledger, &part, &machine.profile.folders.archive).await?,
        leases: machine.leases.clone(),
    }))
}

/// The kept file of a build that is issued once more with all wanted copies of a part.
async fn find_kept_build(ledger: &Ledger, part: &PartRow, archive: &Path) -> Result<Option<KeptBuild>> {
    for build in ledger.builds_in_state(BuildState::Nesting).await? {
        let Some(printed) = build.search.repeats else { continue };
        let parts = ledger.parts_of_build(build.id).await?;
        if part.state == PartState::Batched && parts.iter().any(|other| other.id == part.id) {
            return Ok(ledger.find_build(printed).await?.and_then(|row| KeptBuild::of_build(archive, &row)));
        }
    }
    Ok(None)
}

impl WantedOriginal {
    fn has_kept_build(&self) -> bool {
        self.kept.as_ref().is_some_and(|kept| kept.proved_path().is_some())
    }

    /// Copies the original into the store and writes its note. `false` = neither an archive nor another node holds it.
    fn copy_into_store(&self, store: &ContentStore, nodes: &OtherNodes) -> Result<bool> {
        if store.verify_hash(&self.hash).is_err() {
            // An archive that is not mounted is never an empty one.
            self.leases.archive.clone().check_usable()?;
            match self.folders.iter().find_map(|folder| find_original(folder, &self.hash)) {
                Some(found) if store.store_file(&found)?.hash != self.hash => {
                    return Err(StoreError::Changed(found).into());
                }
                Some(_) => {}
                None if !nodes.fetch_into_store(store, &self.hash)? => return Ok(false),
                None => {}
            }
        }
        store.write_note(&self.hash, &self.claim, &self.note)?;
        store.mark_decisions(&self.hash, &self.claim, self.decisions)?;
        Ok(true)
    }
}

async fn on_fetched(desk: &mut Receiving<'_>, fetched: FetchedOriginals) -> Result<()> {
    for hash in &fetched.stored {
        info!("The original with the BLAKE3 {hash} is in the store again: its copies wait.");
        desk.shared.ledger.mark_fetched(hash).await?;
    }
    for hash in &fetched.unneeded {
        info!("No archive holds the original with the BLAKE3 {hash} any more: its build is issued from the kept file.");
        desk.shared.ledger.mark_fetched(hash).await?;
    }
    for (hash, name) in &fetched.missing {
        let lost = LostFileError { name: name.clone(), content_hash: hash.clone(), aside: None };
        damaged_files::request_file_again(&mut desk.shared, desk.machines, desk.meshes, &lost).await?;
        desk.shared.ledger.mark_fetched(hash).await?;
    }
    match fetched.failures.first() {
        None => {
            desk.shared.schedule.step_backoff.record_success(&BACKOFF.to_owned());
            desk.shared.alerts.clear(AlertKind::StepFails, "", BACKOFF);
        }
        Some(first) => {
            desk.shared.schedule.step_backoff.record_failure(BACKOFF.to_owned());
            desk.shared.report_failure(AlertKind::StepFails, "", BACKOFF, &anyhow::anyhow!("{first}"));
        }
    }
    Ok(())
}
