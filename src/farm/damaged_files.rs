//! A stored file that differs from the file that was dropped is set aside and never printed. Its parts wait, an alert
//! asks for the file, and dropping the same file again repairs it. Parts in other files continue meanwhile.

use std::collections::BTreeMap;

use anyhow::Result;
use tracing::{info, warn};

use super::{alert::AlertKind, failure::LostFileError, farm::Farm, jobs::BackgroundJob};
use crate::{
    intake::{ClaimedPart, StoredFile},
    ledger::{BuildId, PartId},
};

/// Checks damaged stored files; returns the hashes of those that are intact again.
#[derive(Clone)]
pub(super) struct DamagedFilesJob;

impl BackgroundJob<Farm> for DamagedFilesJob {
    const KIND: &'static str = "Damaged";
    type Outcome = Vec<String>;

    fn subject(&self) -> String {
        String::new()
    }

    async fn on_done(self, farm: &mut Farm, hashes: Self::Outcome) -> Result<()> {
        farm.on_files_repaired(&hashes).await
    }
}

impl Farm {
    /// From now on the parts of a lost file wait until it is dropped again.
    pub(super) async fn request_file_again(&mut self, lost: &LostFileError) -> Result<()> {
        warn!("{lost}; the same file must be dropped again.");
        self.meshes.mesh_cache.retain(|key| key.content_hash != lost.content_hash);
        self.ledger.mark_damaged(&lost.content_hash, &lost.to_string()).await?;
        self.update_damaged_alerts().await
    }

    /// Continues a build without the parts of a lost file. If no other part is in it, the build fails and its copies
    /// wait.
    pub(super) async fn continue_without_lost_file(&mut self, build: BuildId, failure: &anyhow::Error) -> Result<()> {
        let Some(lost) = LostFileError::find_in_chain(failure) else { return Ok(()) };
        let parts: Vec<PartId> = (self.ledger.parts_of_build(build).await?.into_iter())
            .filter_map(|part| (part.file.content_hash == lost.content_hash).then_some(part.id))
            .collect();
        let all = self.ledger.copies_of_build(build).await?;
        let gone: Vec<(PartId, u32)> = all.iter().copied().filter(|(part, _)| parts.contains(part)).collect();
        match gone.len() < all.len() {
            true => {
                self.ledger.release_copies(build, &gone).await?;
                // Not a fault of the build: it does not count as an attempt.
                self.nesting.just_fired.insert(build);
            }
            false => self.ledger.fail_build(build, &lost.to_string()).await?,
        }
        self.request_file_again(lost).await
    }

    /// Whether a claimed file replaces a damaged one. If so, it is taken as the replacement and is not a new order.
    pub(super) async fn take_as_replacement(
        &mut self,
        profile: &str,
        claim: &ClaimedPart,
        stored: &StoredFile,
    ) -> Result<bool> {
        let Some(part) = self.ledger.take_replacement(&claim.id, profile, &stored.hash).await? else {
            return Ok(false);
        };
        let name = claim.display_name();
        info!(part.id = %part, profile, "{name} was dropped again: part {part} goes on with it; it is not another order.");
        self.let_replacement_go(profile, claim, stored);
        self.update_damaged_alerts().await?;
        Ok(true)
    }

    /// Checks whether somebody has put a damaged file back.
    pub(super) async fn check_damaged_files(&mut self) -> Result<()> {
        self.update_damaged_alerts().await?;
        let mut hashes: Vec<String> =
            self.ledger.damaged_parts().await?.into_iter().map(|part| part.file.content_hash).collect();
        hashes.dedup();
        if hashes.is_empty() {
            return Ok(());
        }
        let store = self.meshes.store.clone();
        self.jobs.start(DamagedFilesJob, move || {
            hashes.retain(|hash| store.verify_hash(hash).is_ok());
            hashes
        });
        Ok(())
    }

    async fn on_files_repaired(&mut self, hashes: &[String]) -> Result<()> {
        for hash in hashes {
            self.ledger.mark_whole(hash).await?;
        }
        self.update_damaged_alerts().await
    }

    /// One alert for each machine, with its parts.
    async fn update_damaged_alerts(&mut self) -> Result<()> {
        let mut told: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for part in self.ledger.damaged_parts().await? {
            told.entry(part.profile).or_default().push(format!("part {} ({})", part.id, part.name));
        }
        for name in self.machines.keys() {
            match told.get(name) {
                None => self.alerts.clear(AlertKind::FileDamaged, name, ""),
                Some(parts) => {
                    let more = if parts.len() > 3 { format!(" and {} more", parts.len() - 3) } else { String::new() };
                    let detail = parts[..parts.len().min(3)].join(", ") + &more;
                    self.alerts.raise(AlertKind::FileDamaged, name, "", &detail);
                }
            }
        }
        Ok(())
    }
}
