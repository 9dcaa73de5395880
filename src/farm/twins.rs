//! The same bytes dropped again: more copies, or another size for the unit that was said.

use anyhow::Result;

use super::farm::Farm;
use crate::{
    ledger::{PartId, PartRow, SolidFacts},
    settings::Duplicates,
};

impl Farm {
    /// The part that has the same bytes, and what the profile says of that.
    pub(super) async fn duplicate_of(&self, part: &PartRow) -> Result<Option<(PartId, Duplicates)>> {
        let Some(station) = self.stations.get(&part.profile) else { return Ok(None) };
        let earlier = self.ledger.earlier_with_hash(&part.profile, &part.file.content_hash, part.id).await?;
        Ok(earlier.map(|earlier| (earlier, station.profile.intake.duplicates)))
    }

    /// Whether the same bytes give another size than they gave before, for the unit that a ticket or the profile says.
    pub(super) async fn is_in_another_unit(
        &self,
        part: &PartRow,
        earlier: PartId,
        solids: &[SolidFacts],
    ) -> Result<bool> {
        let Some(earlier) = self.ledger.part(earlier).await? else { return Ok(false) };
        let now =
            solids.iter().find(|solid| solid.object_index == earlier.solid.object_index).map(|solid| solid.size_mm);
        Ok(match (earlier.size_mm(), now) {
            (Some(then), Some(now)) => then.iter().zip(now).any(|(then, now)| (then - now).abs() > 1e-6 * now),
            // Not read yet: what the tickets say is all that is known.
            _ => earlier.terms.unit != part.terms.unit,
        })
    }
}
