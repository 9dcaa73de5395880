//! Checks files that were dropped before. Such a file orders more copies, has another size because of another unit, or was put back
//! by a sync program: its modification time tells the last from a new drop.

use anyhow::Result;
use ledger::{Ledger, PartId, PartRow, SolidFacts};
use settings::DuplicatePolicy;

use super::doubtful_drops::add_question;
use crate::core::machine_state::MachineStates;

/// The consequence of an earlier part with the same bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum DuplicateDecision {
    /// No consequence.
    None,
    /// The part is accepted with this warning.
    Warn(String),
    /// It is asked whether the part is to be printed, for this reason (part of a sentence).
    Ask(String),
    /// The part is refused. The reason is in whole sentences.
    Refuse(String),
}

impl DuplicateDecision {
    /// Notes a warning or a question on the solids of an accepted file.
    pub fn note_on(self, solids: &mut [SolidFacts]) {
        match (self, solids.first_mut()) {
            (Self::Warn(warning), Some(first)) => first.warnings.push(warning),
            (Self::Ask(doubt), _) => add_question(solids, &doubt),
            _ => {}
        }
    }

    /// The consequence for a part that was read, according to the duplicate policy of its profile.
    fn of(
        part: &PartRow,
        solids: &[SolidFacts],
        earlier: &PartRow,
        put_back: Option<PartId>,
        duplicates: DuplicatePolicy,
    ) -> Self {
        if let Some(taken) = put_back.filter(|_| duplicates == DuplicatePolicy::Warn) {
            return Self::Ask(format!(
                "it has the folder, the name, the bytes and the time of part {taken}, so a sync program may have put back what was \
                 taken already"
            ));
        }
        if is_in_another_unit(part, solids, earlier) {
            return Self::Warn(format!(
                "The same file as part {}, but in another unit: it is a part of another size.",
                earlier.id
            ));
        }
        match duplicates {
            DuplicatePolicy::Accept => Self::None,
            DuplicatePolicy::Warn => Self::Warn(format!("The same file as part {}: taken as more copies.", earlier.id)),
            DuplicatePolicy::Refuse => Self::Refuse(format!(
                "It is the same file as part {}, and this machine takes no file twice. Where more copies are meant, set \
                 duplicates = \"warn\" in the profile {}, reload nestd and take it back.",
                earlier.id, part.machine
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
    let Some(machine) = machines.get(&part.machine) else { return Ok(DuplicateDecision::None) };
    if !ledger.has_earlier_content(part).await? {
        return Ok(DuplicateDecision::None);
    }
    let put_back = ledger.find_put_back_part(part.id).await?;
    let earlier = match put_back {
        None => ledger.find_earlier_part(&part.machine, &part.file.content_hash, part.id).await?,
        put_back => put_back,
    };
    let Some(earlier) = earlier else { return Ok(DuplicateDecision::None) };
    let earlier = ledger.find_part(earlier).await?;
    Ok(earlier.map_or(DuplicateDecision::None, |earlier| {
        DuplicateDecision::of(part, solids, &earlier, put_back, machine.profile.intake.duplicates)
    }))
}

/// Whether the same bytes now have another size, because the ticket or the profile specifies another unit.
fn is_in_another_unit(part: &PartRow, solids: &[SolidFacts], earlier: &PartRow) -> bool {
    let now = solids.iter().find(|solid| solid.object_index == earlier.solid.object_index).map(|solid| solid.size_mm);
    match (earlier.size_mm(), now) {
        (Some(then), Some(now)) => then.iter().zip(now).any(|(then, now)| (then - now).abs() > 1e-6 * now),
        // The size is not known yet: compare the units of the tickets.
        _ => (earlier.terms.unit, earlier.measures.read_unit) != (part.terms.unit, part.measures.read_unit),
    }
}
