//! A stored file that does not hold what was dropped: it is set aside and never printed, its parts wait, a person is told, and
//! the same file dropped again heals it. Parts in other files go on meanwhile.

use std::collections::BTreeMap;

use anyhow::Result;
use tracing::{info, warn};

use super::{attention::Attention, failure::Lost, farm::Farm, jobs::Job};
use crate::{
    intake::{Claim, Stored},
    ledger::{BuildId, PartId},
};

/// Looking at stored files that were damaged; gives those that are whole again, by content.
#[derive(Clone)]
pub(super) struct DamagedJob;

impl Job<Farm> for DamagedJob {
    const KIND: &'static str = "Damaged";
    type Outcome = Vec<String>;

    fn about(&self) -> String {
        String::new()
    }

    async fn done(self, farm: &mut Farm, hashes: Self::Outcome) -> Result<()> {
        farm.on_whole(&hashes).await
    }
}

impl Farm {
    /// The parts of a lost file wait for it from now on.
    pub(super) async fn ask_again(&mut self, lost: &Lost) -> Result<()> {
        warn!("{lost}; it is asked for again.");
        self.meshes.shelf.keep(|key| key.content_hash != lost.content_hash);
        self.ledger.mark_damaged(&lost.content_hash, &lost.to_string()).await?;
        self.tell_damaged().await
    }

    /// A build goes on without the parts of a lost file; one of nothing else ends, and its copies wait.
    pub(super) async fn go_on_without(&mut self, build: BuildId, failure: &anyhow::Error) -> Result<()> {
        let Some(lost) = Lost::of(failure) else { return Ok(()) };
        let parts: Vec<PartId> = (self.ledger.parts_of_build(build).await?.into_iter())
            .filter_map(|part| (part.file.content_hash == lost.content_hash).then_some(part.id))
            .collect();
        let all = self.ledger.copies_of_build(build).await?;
        let gone: Vec<(PartId, u32)> = all.iter().copied().filter(|(part, _)| parts.contains(part)).collect();
        match gone.len() < all.len() {
            true => {
                self.ledger.release_copies(build, &gone).await?;
                // No fault of the build's: it costs no attempt.
                self.nesting.fresh.insert(build);
            }
            false => self.ledger.fail_build(build, &lost.to_string()).await?,
        }
        self.ask_again(lost).await
    }

    /// Whether a drop was asked for in place of a damaged file; it is taken as that then, and is no order of its own.
    pub(super) async fn is_replacement(&mut self, profile: &str, claim: &Claim, stored: &Stored) -> Result<bool> {
        let Some(part) = self.ledger.take_replacement(&claim.id, profile, &stored.hash).await? else {
            return Ok(false);
        };
        let name = claim.display_name();
        info!(part.id = %part, profile, "{name} was dropped again: part {part} goes on with it; it is not another order.");
        self.let_replacement_go(profile, claim, stored);
        self.tell_damaged().await?;
        Ok(true)
    }

    /// Looks whether somebody put a damaged file back.
    pub(super) async fn look_at_damaged(&mut self) -> Result<()> {
        self.tell_damaged().await?;
        let mut hashes: Vec<String> =
            self.ledger.damaged_parts().await?.into_iter().map(|part| part.file.content_hash).collect();
        hashes.dedup();
        if hashes.is_empty() {
            return Ok(());
        }
        let store = self.meshes.store.clone();
        self.jobs.start(DamagedJob, move || {
            hashes.retain(|hash| store.verify(hash).is_ok());
            hashes
        });
        Ok(())
    }

    async fn on_whole(&mut self, hashes: &[String]) -> Result<()> {
        for hash in hashes {
            self.ledger.mark_whole(hash).await?;
        }
        self.tell_damaged().await
    }

    /// One notice for each machine, with its parts.
    async fn tell_damaged(&mut self) -> Result<()> {
        let mut told: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for part in self.ledger.damaged_parts().await? {
            told.entry(part.profile).or_default().push(format!("part {} ({})", part.id, part.name));
        }
        for name in self.stations.keys() {
            match told.get(name) {
                None => self.notices.clear(Attention::FileDamaged, name, ""),
                Some(parts) => {
                    let more = if parts.len() > 3 { format!(" and {} more", parts.len() - 3) } else { String::new() };
                    let detail = parts[..parts.len().min(3)].join(", ") + &more;
                    self.notices.raise(Attention::FileDamaged, name, "", &detail);
                }
            }
        }
        Ok(())
    }
}
