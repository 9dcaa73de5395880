//! A stored file that differs from the file that was dropped is set aside and never printed. Its parts wait, an alert
//! asks for the file, and dropping the same file again repairs it. Parts in other files continue meanwhile.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
};

use anyhow::Result;
use intake::{ClaimedPart, StoredFile};
use jobs::BackgroundJob;
use ledger::{BuildId, Ledger, PartId};
use tracing::{info, warn};

use super::claim_completion;
use crate::{
    alerts::{
        alert::AlertKind,
        alert_registry::AlertRegistry,
        failure::{LostFileError, PartFault},
    },
    core::{
        desks::{Building, Receiving, Shared},
        farm::Farm,
        machine_state::MachineStates,
    },
    files::mesh_source::MeshSource,
    nesting::node_content::OtherNodes,
};

/// Checks damaged stored files; returns the hashes of those that are intact again.
#[derive(Clone)]
pub(crate) struct DamagedFilesJob;

impl BackgroundJob<Farm> for DamagedFilesJob {
    const KIND: &'static str = "Damaged";
    type Outcome = Vec<String>;
    type Desk<'f> = Receiving<'f>;

    fn subject(&self) -> String {
        String::new()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, hashes: Self::Outcome) -> Result<()> {
        on_files_repaired(&mut desk, &hashes).await
    }
}

/// From now on the parts of a lost file wait until it is dropped again.
pub(crate) async fn request_file_again(
    shared: &mut Shared<'_>,
    machines: &MachineStates,
    meshes: &mut MeshSource,
    lost: &LostFileError,
) -> Result<()> {
    warn!("{lost}; the same file must be dropped again.");
    meshes.mesh_cache.retain(|key| key.content_hash != lost.content_hash);
    shared.ledger.mark_damaged(&lost.content_hash, &lost.to_string()).await?;
    update_damaged_alerts(shared.ledger, machines, shared.alerts).await
}

/// From now on the part in which a failure lies waits for a person.
pub(crate) async fn hold_faulty_part(
    shared: &mut Shared<'_>,
    machines: &MachineStates,
    meshes: &mut MeshSource,
    fault: PartFault<'_>,
) -> Result<()> {
    match fault {
        PartFault::Lost(lost) => request_file_again(shared, machines, meshes, lost).await,
        PartFault::SizeDiffers(differs) => {
            warn!(part.id = %differs.part, "{differs}; it waits for a person.");
            Ok(shared.ledger.hold_other_size(differs.part, differs.found_mm).await?)
        }
        PartFault::MendDiffers(differs) => {
            warn!(part.id = %differs.part, "{differs}; it waits for a person.");
            Ok(shared.ledger.hold_other_mending(differs.part).await?)
        }
    }
}

/// Continues a build without the parts in which a failure lies. If no other part is in it, the build fails and its copies
/// wait.
pub(crate) async fn continue_without_faulty_part(
    desk: &mut Building<'_>,
    build: BuildId,
    failure: &anyhow::Error,
) -> Result<()> {
    let Some(fault) = PartFault::find_in_chain(failure) else { return Ok(()) };
    let parts = desk.shared.ledger.parts_of_build(build).await?;
    let parts: Vec<PartId> = parts.iter().filter(|part| fault.is_of(part)).map(|part| part.id).collect();
    let why = fault.to_string();
    let all = desk.shared.ledger.copies_of_build(build).await?;
    let gone: Vec<(PartId, u32)> = all.iter().copied().filter(|(part, _)| parts.contains(part)).collect();
    match gone.len() < all.len() {
        true => {
            desk.shared.ledger.release_copies(build, &gone, &why).await?;
            // Not a fault of the build: it does not count as an attempt.
            desk.nesting.just_fired.insert(build);
        }
        false => desk.shared.ledger.fail_build(build, &why).await?,
    }
    hold_faulty_part(&mut desk.shared, desk.machines, desk.meshes, fault).await
}

/// A claimed file was recorded as the replacement of a damaged one: it is no new order, and its original is released.
pub(super) async fn go_on_with_replacement(
    desk: &mut Receiving<'_>,
    machine: &str,
    (claim, stored): (&ClaimedPart, &StoredFile),
    part: PartId,
) -> Result<()> {
    let name = claim.display_name();
    info!(part.id = %part, machine, "{name} was dropped again: part {part} goes on with it; it is not another order.");
    claim_completion::release_replacement(desk, machine, claim, stored);
    update_damaged_alerts(desk.shared.ledger, desk.machines, desk.shared.alerts).await
}

/// Checks whether somebody has put a damaged file back, or another node has it.
pub(crate) async fn check_damaged_files(desk: &mut Receiving<'_>) -> Result<()> {
    update_damaged_alerts(desk.shared.ledger, desk.machines, desk.shared.alerts).await?;
    let mut parts = desk.shared.ledger.damaged_parts().await?;
    // The files of another node's machines are looked for there.
    parts.retain(|part| desk.shared.looks_after(desk.machines, &part.machine));
    let mut hashes: Vec<String> = parts.into_iter().map(|part| part.file.content_hash).collect();
    hashes.dedup();
    if hashes.is_empty() {
        return Ok(());
    }
    let store = desk.meshes.store.clone();
    let inboxes: Vec<PathBuf> = desk.machines.values().map(|s| s.profile.folders.inbox.clone()).collect();
    let nodes = OtherNodes::of_ledger(desk.shared.settings, desk.shared.ledger).await?;
    desk.jobs.start(DamagedFilesJob, move || {
        // A node that was gone may have come back with it.
        let is_there =
            |hash: &str| store.verify_hash(hash).is_ok() || nodes.fetch_into_store(&store, hash).unwrap_or(false);
        hashes.retain(|hash| is_there(hash));
        if hashes.is_empty() {
            return hashes;
        }
        // A claimed file is in the store before its row: it would be taken for a new order if the parts did not ask for it
        // any more. The claim came before the stored file, so it is looked for afterwards.
        let Ok(claimed) = claimed_hashes(&inboxes) else { return Vec::new() };
        hashes.retain(|hash| !claimed.contains(hash));
        hashes
    });
    Ok(())
}

/// The hashes of the files that are claimed in the hot folders.
fn claimed_hashes(inboxes: &[PathBuf]) -> Result<BTreeSet<String>> {
    let mut hashes = BTreeSet::new();
    for inbox in inboxes {
        let claims = intake::list_claims(inbox)?.claims;
        // A claim that is completed meanwhile is gone.
        hashes.extend(claims.iter().filter_map(|claim| intake::hash_file(&claim.part).ok()));
    }
    Ok(hashes)
}

async fn on_files_repaired(desk: &mut Receiving<'_>, hashes: &[String]) -> Result<()> {
    for hash in hashes {
        desk.shared.ledger.mark_whole(hash).await?;
    }
    update_damaged_alerts(desk.shared.ledger, desk.machines, desk.shared.alerts).await
}

/// One alert for each machine, with its parts.
async fn update_damaged_alerts(ledger: &Ledger, machines: &MachineStates, alerts: &mut AlertRegistry) -> Result<()> {
    let mut by_machine: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for part in ledger.damaged_parts().await? {
        by_machine.entry(part.machine).or_default().push(format!("part {} ({})", part.id, part.name));
    }
    for name in machines.keys() {
        match by_machine.get(name) {
            None => alerts.clear(AlertKind::FileDamaged, name, ""),
            Some(parts) => {
                let more = if parts.len() > 3 { format!(" and {} more", parts.len() - 3) } else { String::new() };
                let detail = parts[..parts.len().min(3)].join(", ") + &more;
                alerts.raise(AlertKind::FileDamaged, name, "", &detail);
            }
        }
    }
    Ok(())
}
