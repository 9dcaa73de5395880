//! Decisions on parts (refused, cancelled, taken back, changed) as counted in the notes beside their stored files: with an
//! outdated ledger, cancelled parts would be printed and retried parts would be forgotten.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;

use super::reconcile_report::ReconcileReport;
use crate::{
    intake::StoredContent,
    ledger::{ClaimDecisions, Ledger, PartId, PartRow},
    settings::Settings,
};

/// Claims whose notes count more decisions than the ledger.
#[derive(Debug, Default)]
pub(super) struct NewerDecisions {
    claims: BTreeMap<String, ClaimDecisions>,
    /// Parts that were reported to a person.
    reported: BTreeSet<PartId>,
}

/// The claims whose last decision the ledger does not know. Claims of machines that are not configured are left out
/// until those come back.
///
/// # Errors
/// The ledger cannot be read.
pub async fn find_newer_decisions(
    settings: &Settings,
    ledger: &Ledger,
    kept: &BTreeMap<String, StoredContent>,
) -> Result<Vec<ClaimDecisions>> {
    let marked = kept.values().flat_map(|kept| &kept.claims).filter(|(_, decisions)| **decisions > 0);
    let marked = marked.map(|(claim, decisions)| (claim.clone(), *decisions)).collect();
    let mut since = ledger.claims_with_more_decisions(&marked).await?;
    since.retain(|claim| settings.profiles.contains_key(&claim.profile));
    Ok(since)
}

/// Describes a decision that the ledger does not know.
pub fn describe_decision(claim: &ClaimDecisions) -> String {
    let order = if claim.order_name.is_empty() { String::new() } else { format!("{}/", claim.order_name) };
    format!(
        "the last decision about {order}{} for {} (refused, cancelled, taken back or changed)",
        claim.name, claim.profile
    )
}

impl NewerDecisions {
    /// Collects the decisions for a ledger that is not in use yet. Builds of these claims that were being nested when
    /// the backup was made are given up.
    pub async fn load_for_reconcile(
        settings: &Settings,
        ledger: &Ledger,
        kept: &BTreeMap<String, StoredContent>,
        found: &mut ReconcileReport,
    ) -> Result<Self> {
        let claims =
            find_newer_decisions(settings, ledger, kept).await?.into_iter().map(|claim| (claim.claim.clone(), claim));
        let since = Self { claims: claims.collect(), reported: BTreeSet::new() };
        let ids: Vec<String> = since.claims.keys().cloned().collect();
        for build in ledger.nesting_builds_of_claims(&ids).await? {
            ledger.fail_build(build, "the ledger was put back from a backup").await?;
            found.done.push(format!("build {build} was being nested and is given up; its copies wait"));
        }
        Ok(since)
    }

    /// Whether a newer decision concerns this part or another one of its file.
    pub fn contains_part(&self, part: &PartRow) -> bool {
        self.claims.contains_key(&part.file.claim)
    }

    /// Reports the result for a part to a person.
    pub fn report_doubt(&mut self, part: &PartRow, found: &mut ReconcileReport, doubt: String) {
        self.reported.insert(part.id);
        found.doubts.push(doubt);
    }

    /// Whether a part was reported to a person.
    pub fn is_reported(&self, part: &PartRow) -> bool {
        self.reported.contains(&part.id)
    }

    /// Raises the ledger's counts to those of the notes, and reports each claim to a person.
    pub async fn apply_to_ledger(self, ledger: &Ledger, found: &mut ReconcileReport) -> Result<()> {
        for claim in self.claims.values() {
            ledger.raise_decision_count(&claim.claim, claim.decisions).await?;
            let parts = ledger.parts_of_claim(&claim.claim).await?;
            if parts.iter().any(|part| self.is_reported(part)) {
                continue;
            }
            found.doubts.extend(parts.first().map(|part| {
                format!(
                    "part {} ({}) is {}: it was refused, cancelled, taken back or changed after the backup was made. `nestd retry {0}` \
                     takes it back, `nestd cancel {0}` cancels it and `nestd edit {0}` changes it, where it should be otherwise",
                    part.id, part.name, part.state
                )
            }));
        }
        Ok(())
    }
}
