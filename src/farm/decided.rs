//! What was decided of parts (refused, cancelled, taken back), as the notes beside their stored files tell it: a ledger that
//! went back in time would print what was cancelled, and hide what was taken back.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;

use super::reconciled::Reconciled;
use crate::{
    intake::Kept,
    ledger::{Decided, Ledger, PartId, PartRow},
    settings::Settings,
};

/// Claims of which more was decided than the ledger knows.
#[derive(Debug, Default)]
pub(super) struct Since {
    claims: BTreeMap<String, Decided>,
    /// Parts that a person was told of.
    told: BTreeSet<PartId>,
}

/// Of which of these claims the ledger does not know the last decision; those of machines that are not configured wait until
/// these come back.
///
/// # Errors
/// The ledger cannot be read.
pub async fn since(settings: &Settings, ledger: &Ledger, kept: &BTreeMap<String, Kept>) -> Result<Vec<Decided>> {
    let marked = kept.values().flat_map(|kept| &kept.claims).filter(|(_, decisions)| **decisions > 0);
    let marked = marked.map(|(claim, decisions)| (claim.clone(), *decisions)).collect();
    let mut since = ledger.decided_since(&marked).await?;
    since.retain(|claim| settings.profiles.contains_key(&claim.profile));
    Ok(since)
}

/// What the folders tell of a claim and the ledger does not know, in words.
pub fn name(claim: &Decided) -> String {
    let order = if claim.order_name.is_empty() { String::new() } else { format!("{}/", claim.order_name) };
    format!("the last decision about {order}{} for {} (refused, cancelled or taken back)", claim.name, claim.profile)
}

impl Since {
    /// Of a ledger that nobody uses yet; what was being nested of these claims when it was made is given up.
    pub async fn of(
        settings: &Settings,
        ledger: &Ledger,
        kept: &BTreeMap<String, Kept>,
        found: &mut Reconciled,
    ) -> Result<Self> {
        let claims = since(settings, ledger, kept).await?.into_iter().map(|claim| (claim.claim.clone(), claim));
        let since = Self { claims: claims.collect(), told: BTreeSet::new() };
        let ids: Vec<String> = since.claims.keys().cloned().collect();
        for build in ledger.nesting_builds_of_claims(&ids).await? {
            ledger.fail_build(build, "the ledger was put back from a backup").await?;
            found.done.push(format!("build {build} was being nested and is given up; its copies wait"));
        }
        Ok(since)
    }

    /// Whether something was decided of a part, or of another one of its file.
    pub fn has(&self, part: &PartRow) -> bool {
        self.claims.contains_key(&part.file.claim)
    }

    /// A person is told what came of a part.
    pub fn tell(&mut self, part: &PartRow, found: &mut Reconciled, doubt: String) {
        self.told.insert(part.id);
        found.doubts.push(doubt);
    }

    /// Whether a person was told of a part.
    pub fn is_told(&self, part: &PartRow) -> bool {
        self.told.contains(&part.id)
    }

    /// The ledger counts what the notes count from now on, and a person is told of each claim.
    pub async fn agree(self, ledger: &Ledger, found: &mut Reconciled) -> Result<()> {
        for claim in self.claims.values() {
            ledger.raise_decisions(&claim.claim, claim.decisions).await?;
            let parts = ledger.parts_of_claim(&claim.claim).await?;
            if parts.iter().any(|part| self.is_told(part)) {
                continue;
            }
            found.doubts.extend(parts.first().map(|part| {
                format!(
                    "part {} ({}) is {}: it was refused, cancelled or taken back after the backup was made. `nestd retry {0}` \
                     takes it back and `nestd cancel {0}` cancels it, where it should be otherwise",
                    part.id, part.name, part.state
                )
            }));
        }
        Ok(())
    }
}
