//! Checks files that were dropped before. Such a file orders more copies, or has another size because of another unit.

use anyhow::Result;

use super::machine_state::MachineStates;
use crate::{
    ledger::Ledger,
    ledger::{PartRow, SolidFacts},
    settings::DuplicatePolicy,
};

/// The consequence of an earlier part with the same bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum DuplicateDecision {
    /// No consequence.
    None,
    /// The part is accepted with this warning.
    Warn(String),
    /// The part is refused. The reason is in whole sentences.
    Refuse(String),
}

impl DuplicateDecision {
    /// The consequence for a part that was read, according to the duplicate policy of its profile.
    fn of(part: &PartRow, solids: &[SolidFacts], earlier: &PartRow, duplicates: DuplicatePolicy) -> Self {
        if is_in_another_unit(part, solids, earlier) {
            return Self::Warn(format!(
                "The same file as part {}, but in another unit: it is a part of another size.",
                earlier.id
            ));
        }
        match duplicates {
            DuplicatePolicy::Accept => Self::None,
            DuplicatePolicy::Warn => Self::Warn(format!("The same file as part {}: taken as more copies.", earlier.id)),
            DuplicatePolicy::Reject => Self::Refuse(format!(
                "It is the same file as part {}, and this profile takes no file twice. Where more copies are meant, set \
                 duplicates = \"warn\" in the profile {}, reload nestd and take it back.",
                earlier.id, part.profile
            )),
        }
    }
}

/// The consequence of an earlier part with the same bytes, if there is one.
pub(super) async fn decide_on_duplicate(
    ledger: &Ledger,
    machines: &MachineStates,
    part: &PartRow,
    solids: &[SolidFacts],
) -> Result<DuplicateDecision> {
    let Some(machine) = machines.get(&part.profile) else { return Ok(DuplicateDecision::None) };
    let Some(earlier) = ledger.find_earlier_part(&part.profile, &part.file.content_hash, part.id).await? else {
        return Ok(DuplicateDecision::None);
    };
    let earlier = ledger.find_part(earlier).await?;
    Ok(earlier.map_or(DuplicateDecision::None, |earlier| {
        DuplicateDecision::of(part, solids, &earlier, machine.profile.intake.duplicates)
    }))
}

/// Whether the same bytes now have another size, because the ticket or the profile specifies another unit.
fn is_in_another_unit(part: &PartRow, solids: &[SolidFacts], earlier: &PartRow) -> bool {
    let now = solids.iter().find(|solid| solid.object_index == earlier.solid.object_index).map(|solid| solid.size_mm);
    match (earlier.size_mm(), now) {
        (Some(then), Some(now)) => then.iter().zip(now).any(|(then, now)| (then - now).abs() > 1e-6 * now),
        // The size is not known yet: compare the units of the tickets.
        _ => earlier.terms.unit != part.terms.unit,
    }
}
