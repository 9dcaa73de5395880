//! Decisions on parts (refused, cancelled, taken back, changed) as counted in the notes beside their stored files: with an
//! outdated ledger, cancelled parts would be printed and retried parts would be forgotten.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;
use intake::{ContentStore, StoredContent};
use ledger::{ClaimDecisions, Ledger, PartId, PartRow, PartState};
use settings::Settings;

use super::reconcile_report::ReconcileReport;
use crate::files::claim_note::ClaimNote;

/// Claims whose notes count more decisions than the ledger.
#[derive(Debug, Default)]
pub(crate) struct NewerDecisions {
    claims: BTreeMap<String, ClaimDecisions>,
    /// Copies wanted of each solid of them at the last decision, as their notes say.
    wanted: BTreeMap<String, BTreeMap<u32, u32>>,
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
    since.retain(|claim| settings.profiles.contains_key(&claim.machine));
    Ok(since)
}

/// Describes a decision that the ledger does not know.
pub fn describe_decision(claim: &ClaimDecisions) -> String {
    let order = if claim.order_name.is_empty() { String::new() } else { format!("{}/", claim.order_name) };
    format!(
        "the last decision about {order}{} for {} (refused, cancelled, taken back or changed)",
        claim.name, claim.machine
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
        let mut since = Self { claims: claims.collect(), ..Self::default() };
        let store = ContentStore::from_dir(settings.state_dir.join("store"));
        let noted = kept.iter().flat_map(|(hash, kept)| kept.claims.keys().map(move |claim| (hash, claim)));
        for (hash, claim) in noted.filter(|(_, claim)| since.claims.contains_key(*claim)) {
            let Some(note) = ClaimNote::read(&store, hash, claim) else { continue };
            if let Some(asked) = &note.asked {
                ledger.take_noted_terms(claim, asked).await?;
            }
            since.wanted.insert(claim.clone(), note.wanted);
        }
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

    /// How many copies of a part were wanted at the last decision, where its note says another number than the ledger.
    pub fn wanted_since(&self, part: &PartRow) -> Option<u32> {
        let wanted = *self.wanted.get(&part.file.claim)?.get(&part.solid.object_index)?;
        (wanted != part.wanted_copies()).then_some(wanted)
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
                let wanted = self.wanted_since(part);
                format!(
                    "part {} ({}) is {}: it was refused, cancelled, taken back or changed after the backup was made{}. {}",
                    part.id,
                    part.name,
                    part.state,
                    wanted_then(wanted),
                    remedy(part, wanted)
                )
            }));
        }
        Ok(())
    }
}

/// How many copies were wanted, where it is another number, as the end of a sentence.
pub(super) fn wanted_then(wanted: Option<u32>) -> String {
    match wanted {
        Some(1) => ", and 1 copy of it was wanted then".to_owned(),
        Some(copies) => format!(", and {copies} copies of it were wanted then"),
        None => String::new(),
    }
}

/// How a part comes back that was taken out, with as many copies as were wanted.
pub(super) fn how_to_take_back(part: PartId, wanted: Option<u32>) -> String {
    let edit = wanted.map(|copies| format!(", and then `nestd edit {part} --copies {copies}` wants as many"));
    format!("`nestd retry {part}` takes it back{}", edit.unwrap_or_default())
}

/// What helps where a part should be otherwise.
fn remedy(part: &PartRow, wanted: Option<u32>) -> String {
    let (id, copies) = (part.id, wanted.map_or_else(|| "N".to_owned(), |copies| copies.to_string()));
    match part.state {
        PartState::Refused => how_to_take_back(id, wanted),
        PartState::Claimed | PartState::Waiting => {
            format!(
                "`nestd edit {id} --copies {copies}` wants as many, and `nestd cancel {id}` takes it out, where it should be otherwise"
            )
        }
        PartState::Batched | PartState::Built => {
            format!(
                "`nestd reprint {id}=N` prints copies of it again, and `nestd edit {id} --copies {copies}` wants as many in all, where it should be otherwise"
            )
        }
    }
}
