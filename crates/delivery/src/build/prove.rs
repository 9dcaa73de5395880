//! Proves a written build file: reads it back, compares the result with a second reader, and proves it on its triangles
//! against what should have been written. No build is published without this.

use std::{collections::BTreeSet, path::Path};

use build_file::{FileReadError, PlacedMesh, ReadLimits};
use glam::DVec3;
use nester::{LayoutProof, PlacedSolid, Separability};
use solids::Mesh;

use super::SolvedBuild;

/// Allowed relative difference between a mesh that was read back and the nested one, from rounding of decimal digits.
const SAME_MESH: f64 = 1e-9;
/// Maximum number of faults named in one message.
const NAMED_FAULTS: usize = 5;

/// Why a written build is not proved.
#[derive(Debug, thiserror::Error)]
pub enum BuildProofError {
    /// Our own reader cannot read it.
    #[error("reading the written build back")]
    ReadBack(#[source] FileReadError),
    /// The second reader cannot read it, or reads something else.
    #[error("comparing with a second reader")]
    SecondReader(#[source] FileReadError),
    /// It is not what should have been written, or the proof found faults.
    #[error("the written build {0}")]
    NotProved(String),
}

/// Results of the proof of a written file.
#[derive(Debug)]
pub struct ProvedBuild {
    /// Walls, clearance, containment and keep-out boxes.
    pub proof: LayoutProof,
    /// How the build can be taken apart; `None` = locked parts are allowed, so this was not checked.
    pub separability: Option<Separability>,
    /// Part, copy and direction of the copies that can be removed from the cake, in this order.
    pub removal_order: Vec<(usize, u32, DVec3)>,
}

/// Index of a part and number of the copy.
type PartCopyIndex = (usize, u32);

impl SolvedBuild {
    /// Proves the written file: each copy is there once, with its mesh and an allowed orientation; walls, clearance,
    /// containment, keep-out boxes and layers are correct; and the parts can be taken apart.
    ///
    /// # Errors
    /// The file cannot be read, the second reader reads it differently, or it is not proved. `table` is that of a whole build as STL.
    pub fn prove_written_file(
        &self,
        written: &Path,
        table: Option<&Path>,
        limits: &ReadLimits,
    ) -> Result<ProvedBuild, BuildProofError> {
        let read = build_file::read_build_with_table(written, table, limits).map_err(BuildProofError::ReadBack)?.1;
        let (copies, bodies) = self.match_placed_copies(&read)?;
        let second = match self.machine.delivery.is_rounded() {
            true => build_file::cross_check_stl(written, &self.describe(), limits),
            false => build_file::cross_check(written, &read, limits),
        };
        second.map_err(BuildProofError::SecondReader)?;
        let verification = self.machine.as_proved().verify_placements(&bodies);
        if !verification.proof.is_proved() {
            let mut faults = verification.placement_faults(|i| bodies[i].name.clone());
            faults.truncate(NAMED_FAULTS);
            return not_proved(format!("is not proved: {}", faults.join("; ")));
        }
        if let Some(fault) = verification.layer_fault() {
            return not_proved(format!("fills a layer beyond its cap: {fault}"));
        }
        let name = |at: usize| (self.parts[copies[at].0].name.clone(), copies[at].1);
        let separable =
            verification.disassembly.as_ref().map(|apart| Separability::new(apart, self.machine.clearance_mm, name));
        if let Some(found) = separable.as_ref().filter(|found| !found.obeys_rule(self.machine.interlock)) {
            return not_proved(format!("is not proved: {}", found.in_words()));
        }
        let order = verification.disassembly.iter().flat_map(|apart| &apart.order);
        let removal_order = order.map(|&(at, direction)| (copies[at].0, copies[at].1, direction)).collect();
        Ok(ProvedBuild { proof: verification.proof, separability: separable, removal_order })
    }

    /// Matches the items that were read with the placed copies. Returns part, copy and body of each item.
    fn match_placed_copies(
        &self,
        read: &[PlacedMesh],
    ) -> Result<(Vec<PartCopyIndex>, Vec<PlacedSolid>), BuildProofError> {
        if read.len() != self.placed.len() {
            return not_proved(format!("holds {} placements instead of {}", read.len(), self.placed.len()));
        }
        let asked: BTreeSet<PartCopyIndex> = self.placed.iter().map(|p| (p.part, p.copy)).collect();
        let mut seen = BTreeSet::new();
        let (mut copies, mut bodies) = (Vec::with_capacity(read.len()), Vec::with_capacity(read.len()));
        for item in read {
            let (copy, body) = self.check_read_item(item)?;
            if !seen.insert(copy) {
                return not_proved(format!("holds copy {} of {} twice", copy.1 + 1, body.name));
            }
            copies.push(copy);
            bodies.push(body);
        }
        if seen == asked { Ok((copies, bodies)) } else { not_proved("holds other copies than were placed".to_owned()) }
    }

    /// Compares an item that was read back with its part. Returns its copy and its body.
    fn check_read_item(&self, item: &PlacedMesh) -> Result<(PartCopyIndex, PlacedSolid), BuildProofError> {
        let number = item.part_number.as_deref().unwrap_or_default();
        let Some(at) = self.parts.iter().position(|part| part.part_number == number) else {
            return not_proved(format!("holds {} (part {number}), which was not asked for", item.name));
        };
        let part = &self.parts[at];
        let Some(copy) = item.copy.and_then(|copy| copy.checked_sub(1)) else {
            return not_proved(format!("holds {} without the number of its copy", part.name));
        };
        let rounding_mm = self.machine.delivery.rounding_mm(self.machine.volume_mm);
        // Each corner of an STL is compared by the second reader.
        if !is_same_mesh(&item.mesh, &part.mesh, rounding_mm) {
            return not_proved(format!("holds part {number} ({}) with another mesh", part.name));
        }
        if !nester::obeys_orientation(&part.orientation, &item.pose) {
            return not_proved(format!("holds part {number} ({}) turned against its orientation rule", part.name));
        }
        let body =
            self.machine.as_proved().placed_body(part.name.clone(), item.mesh.clone(), &item.pose, part.clearance_mm);
        Ok(((at, copy), body))
    }
}

fn not_proved<T>(how: String) -> Result<T, BuildProofError> {
    Err(BuildProofError::NotProved(how))
}

/// Whether a mesh that was read is the nested one, of which rounding has moved no corner farther than `rounding_mm`. Where corners that are so
/// near are one, triangles between them are gone.
fn is_same_mesh(read: &Mesh, nested: &Mesh, rounding_mm: f64) -> bool {
    let is_close =
        |a: DVec3, b: DVec3| (a - b).abs().max_element() <= rounding_mm + SAME_MESH * (1.0 + b.abs().max_element());
    if rounding_mm > 0.0 {
        return read.triangles().len() <= nested.triangles().len()
            && is_close(read.bounds().min, nested.bounds().min)
            && is_close(read.bounds().max, nested.bounds().max);
    }
    read.triangles().len() == nested.triangles().len()
        && (read.volume_mm3() - nested.volume_mm3()).abs() <= SAME_MESH * (1.0 + nested.volume_mm3())
        && is_close(read.bounds().min, nested.bounds().min)
        && is_close(read.bounds().max, nested.bounds().max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_of_the_same_shape_with_another_number_of_triangles_is_another_one() {
        let block = sample_parts::fixtures::block(10.0, 8.0, 6.0);
        assert!(is_same_mesh(&block, &block, 0.0));
        let mut triangles = block.triangles().to_vec();
        let Some([a, b, c]) = triangles.pop() else { panic!("a block has triangles") };
        let mut corners = block.vertices().to_vec();
        let middle = corners.len() as u32;
        corners.push((corners[a as usize] + corners[b as usize]) / 2.0);
        triangles.extend([[a, middle, c], [middle, b, c]]);
        let divided = Mesh::new(corners, triangles).unwrap();
        assert_eq!((divided.volume_mm3().round(), divided.bounds()), (480.0, block.bounds()));
        assert!(!is_same_mesh(&divided, &block, 0.0));
    }
}
