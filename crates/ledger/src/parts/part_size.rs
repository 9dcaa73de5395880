//! The size of a part, and how its mesh was mended: neither changes unless a person says so.

use build_file::LengthUnit;

use crate::{
    EventKind, Ledger, PartId, PartRow,
    base::{error::Result, sql},
    store::change::LedgerChange,
};

/// What is said in numbers that were written and read again may differ by this much, mm.
const SIZE_TOLERANCE_MM: f64 = 1e-3;
/// The same, as a share of the size.
const SIZE_TOLERANCE: f64 = 1e-6;

/// Whether two sizes are the same, mm.
pub fn is_same_size(one: [f64; 3], other: [f64; 3]) -> bool {
    let is_same = |(one, other): (f64, f64)| (one - other).abs() <= SIZE_TOLERANCE_MM.max(SIZE_TOLERANCE * one.abs());
    one.into_iter().zip(other).all(is_same)
}

impl Ledger {
    /// The file of a waiting part was read in another size than the first time: it waits for a person.
    pub async fn hold_other_size(&self, id: PartId, found_mm: [f64; 3]) -> Result<()> {
        let mut change = self.begin_change().await?;
        let part = change.require_part(id).await?;
        let Some(told_mm) = part.size_mm().filter(|_| !part.owed.size_differs) else { return Ok(()) };
        let unit = part.measures.read_unit.unwrap_or_default();
        change.hold_other_size(&part, told_mm, found_mm, unit).await?;
        change.commit().await
    }

    /// The file of a waiting part was mended otherwise than the first time: it waits for a person.
    pub async fn hold_other_mending(&self, id: PartId) -> Result<()> {
        let mut change = self.begin_change().await?;
        let part = change.require_part(id).await?;
        if !part.owed.size_differs {
            change.hold_other_mending(&part).await?;
        }
        change.commit().await
    }
}

impl LedgerChange {
    /// A part waits for a person, because its mesh was mended otherwise than the first time.
    pub(crate) async fn hold_other_mending(&mut self, part: &PartRow) -> Result<()> {
        let question = format!(
            "its mesh is not mended now as it was when it was first read. `nestd confirm {}` has it read and mended anew.",
            part.id
        );
        let hold = sql::query("UPDATE part SET question = $1, size_differs = TRUE WHERE id = $2");
        hold.bind(&question).bind(part.id).execute(self.db()).await?;
        self.write_event(EventKind::SizeDiffers, &part.machine, Some(part.id), None, &question).await
    }

    /// A part waits for a person, because its file was read in another size than the first time.
    pub(crate) async fn hold_other_size(
        &mut self,
        part: &PartRow,
        told_mm: [f64; 3],
        found_mm: [f64; 3],
        unit: LengthUnit,
    ) -> Result<()> {
        let text = |[x, y, z]: [f64; 3]| format!("{x:.2} x {y:.2} x {z:.2} mm");
        let question = format!(
            "its file is {} now, and was {} when it was first read. Where its unit is wrong, `nestd edit {} --unit UNIT` says it.",
            text(found_mm),
            text(told_mm),
            part.id
        );
        let hold = sql::query(
            "UPDATE part SET question = $1, size_differs = TRUE, read_unit = coalesce(read_unit, $2) WHERE id = $3",
        );
        hold.bind(&question).bind(unit).bind(part.id).execute(self.db()).await?;
        self.write_event(EventKind::SizeDiffers, &part.machine, Some(part.id), None, &question).await
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_the_same_within_the_rounding_of_written_numbers_and_no_further() {
        let size = [5.0, 20.0, 3000.0];
        for (other, is_same) in [
            ([5.0, 20.0, 3000.0], true),
            ([5.0009, 20.0, 3000.0], true),
            ([5.0, 19.9991, 3000.0], true),
            ([5.0, 20.0, 3000.0029], true),
            ([5.0011, 20.0, 3000.0], false),
            ([5.0, 19.9989, 3000.0], false),
            ([5.0, 20.0, 3000.0031], false),
            ([127.0, 508.0, 76_200.0], false),
        ] {
            assert_eq!(is_same_size(size, other), is_same, "{other:?}");
        }
    }
}
