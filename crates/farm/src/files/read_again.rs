//! A part's file is read again: in the unit that its row fixed when it was read first, whatever its machine's file says today. Its solid
//! has the size that it had then, or it is not printed.

use std::path::Path;

use build_file::{LengthUnit, PartFileContents, ReadLimits};
use ledger::{PartRow, is_same_size};
use solids::Mesh;

use super::isolated_read::{PartReadRequest, READS_IN_THE_DAEMON};
use crate::alerts::failure::{PartReadError, SizeDiffersError};

/// Units that a file of an earlier nestd may have been read in, the likely ones first.
const UNITS: [LengthUnit; 6] = [
    LengthUnit::Millimeter,
    LengthUnit::Inch,
    LengthUnit::Centimeter,
    LengthUnit::Meter,
    LengthUnit::Foot,
    LengthUnit::Micron,
];

/// Refuses a mesh that has another size than the solid of the part had when it was read first.
pub fn ensure_same_size(part: &PartRow, mesh: &Mesh) -> Result<(), SizeDiffersError> {
    let found_mm = mesh.bounds().size().to_array();
    match part.size_mm() {
        Some(told_mm) if !is_same_size(told_mm, found_mm) => {
            Err(SizeDiffersError { part: part.id, name: part.name.clone(), told_mm, found_mm })
        }
        _ => Ok(()),
    }
}

/// Reads the file of a part in the unit of its row; returns that unit. A part that an earlier nestd read has none there: it is the one in
/// which its solid has the size of then. `at_first` = the unit of a part that was never read.
pub fn read_in_fixed_unit(
    file: &Path,
    part: &PartRow,
    at_first: LengthUnit,
    limits: &ReadLimits,
) -> Result<(LengthUnit, PartFileContents), PartReadError> {
    let read = |fixed_unit: LengthUnit| {
        let (name, unit) = (part.name.clone(), part.terms.unit);
        let request = PartReadRequest { file: file.to_owned(), name, unit, fixed_unit, limits: limits.clone() };
        // If reading it has ended the process before, it is read in a separate process.
        let is_alone = part.file.reads > READS_IN_THE_DAEMON;
        Ok((fixed_unit, if is_alone { request.read_isolated() } else { request.read_in_process() }?))
    };
    let is_of_then = |contents: &PartFileContents| {
        let solid = contents.solids.get(part.solid.object_index as usize);
        solid.is_some_and(|solid| ensure_same_size(part, &solid.mesh).is_ok())
    };
    if part.size_mm().is_none() || part.measures.read_unit.is_some() {
        return read(part.measures.read_unit.unwrap_or(at_first));
    }
    for unit in UNITS {
        let (unit, contents) = read(unit)?;
        if is_of_then(&contents) {
            return Ok((unit, contents));
        }
    }
    read(at_first)
}

#[cfg(test)]
mod tests {
    use jiff::Timestamp;
    use ledger::PartId;
    use ledger_fixtures::part_row;
    use sample_parts::fixtures::block;

    use super::*;

    #[test]
    fn a_mesh_of_another_size_than_the_first_one_is_refused_and_one_of_a_part_that_was_never_read_is_not() {
        let mut part = part_row(PartId(1), 1, Timestamp::UNIX_EPOCH);
        let mesh = block(10.0, 8.0, 6.0);
        assert!(ensure_same_size(&part, &mesh).is_ok());
        let measures = &mut part.measures;
        (measures.size_x_mm, measures.size_y_mm, measures.size_z_mm) = (Some(10.0), Some(8.0), Some(6.0));
        assert!(ensure_same_size(&part, &mesh).is_ok());
        let differs = ensure_same_size(&part, &block(10.0, 8.0, 152.4)).unwrap_err();
        assert_eq!(
            (differs.part, differs.told_mm, differs.found_mm),
            (PartId(1), [10.0, 8.0, 6.0], [10.0, 8.0, 152.4])
        );
    }
}
