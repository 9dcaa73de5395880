//! A written build file is read back, compared with a second reader and proved on its triangles against what was to be
//! written. Nothing is published that has not been through here.

use std::{collections::BTreeSet, path::Path};

use build_file::{Limits, PlacedMesh, ReadError};
use glam::DVec3;
use nester::{Body, Proof, Separability};
use solids::Mesh;

use super::SolvedBuild;

/// A mesh that is read back may differ from the one that was nested by this share: rounding of decimal digits.
const SAME_MESH: f64 = 1e-9;
/// Faults that are named in one message.
const NAMED_FAULTS: usize = 5;

/// A written build is not what it should be, or could not be looked at.
#[derive(Debug, thiserror::Error)]
pub enum ProveError {
    /// Our own reader.
    #[error("reading the written build back")]
    Read(#[source] ReadError),
    /// Somebody else's reader.
    #[error("comparing with a second reader")]
    SecondReader(#[source] ReadError),
    /// It is not what was to be written, or not proved.
    #[error("the written build {0}")]
    Wrong(String),
}

/// What was found out about a written and proved file.
#[derive(Debug)]
pub struct ProvedBuild {
    /// Walls, clearance, containment and keep-out boxes.
    pub proof: Proof,
    /// How it comes apart; `None` where locked parts are allowed and nobody looked.
    pub separable: Option<Separability>,
    /// Part, copy and straight line of the copies that can be drawn out of the cake, in this order.
    pub drawn: Vec<(usize, u32, DVec3)>,
}

/// Index of a part and number of its copy.
type PartCopy = (usize, u32);

impl SolvedBuild {
    /// Proves what was written of it: every copy once and with its mesh, orientation, walls, clearance, containment, keep-out
    /// boxes, layers, and that it comes apart.
    ///
    /// # Errors
    /// The file cannot be read, a second reader reads it differently, or it is not proved.
    pub fn prove(&self, written: &Path, limits: &Limits) -> Result<ProvedBuild, ProveError> {
        let read = build_file::read_build(written, limits).map_err(ProveError::Read)?;
        let (copies, bodies) = self.compare(&read)?;
        build_file::cross_check(written, &read, limits).map_err(ProveError::SecondReader)?;
        let judged = self.machine.judge(&bodies);
        if !judged.proof.is_proved() {
            let mut faults = judged.placement_faults(|i| bodies[i].name.clone());
            faults.truncate(NAMED_FAULTS);
            return wrong(format!("is not proved: {}", faults.join("; ")));
        }
        if let Some(fault) = judged.layer_fault() {
            return wrong(format!("fills a layer beyond its cap: {fault}"));
        }
        let name = |at: usize| (self.parts[copies[at].0].name.clone(), copies[at].1);
        let separable = judged.apart.as_ref().map(|apart| Separability::new(apart, self.machine.clearance_mm, name));
        if let Some(found) = separable.as_ref().filter(|found| !found.obeys(self.machine.interlock)) {
            return wrong(format!("is not proved: {}", found.in_words()));
        }
        let order = judged.apart.iter().flat_map(|apart| &apart.order);
        let drawn = order.map(|&(at, way)| (copies[at].0, copies[at].1, way)).collect();
        Ok(ProvedBuild { proof: judged.proof, separable, drawn })
    }

    /// Part and copy of everything that was read, and it as it is judged; each has to be what was placed.
    fn compare(&self, read: &[PlacedMesh]) -> Result<(Vec<PartCopy>, Vec<Body>), ProveError> {
        if read.len() != self.placed.len() {
            return wrong(format!("holds {} placements instead of {}", read.len(), self.placed.len()));
        }
        let asked: BTreeSet<PartCopy> = self.placed.iter().map(|p| (p.part, p.copy)).collect();
        let mut seen = BTreeSet::new();
        let (mut copies, mut bodies) = (Vec::with_capacity(read.len()), Vec::with_capacity(read.len()));
        for item in read {
            let (copy, body) = self.body_of(item)?;
            if !seen.insert(copy) {
                return wrong(format!("holds copy {} of {} twice", copy.1 + 1, body.name));
            }
            copies.push(copy);
            bodies.push(body);
        }
        if seen == asked { Ok((copies, bodies)) } else { wrong("holds other copies than were placed".to_owned()) }
    }

    /// A read-back item as it is judged, compared with the part that it should be.
    fn body_of(&self, item: &PlacedMesh) -> Result<(PartCopy, Body), ProveError> {
        let number = item.part_number.as_deref().unwrap_or_default();
        let Some(at) = self.parts.iter().position(|part| part.part_number == number) else {
            return wrong(format!("holds {} (part {number}), which was not asked for", item.name));
        };
        let part = &self.parts[at];
        let Some(copy) = item.copy.and_then(|copy| copy.checked_sub(1)) else {
            return wrong(format!("holds {} without the number of its copy", part.name));
        };
        if !is_same_mesh(&item.mesh, &part.mesh) {
            return wrong(format!("holds part {number} ({}) with another mesh", part.name));
        }
        if !nester::rotation_obeys(&part.orientation, &item.pose) {
            return wrong(format!("holds part {number} ({}) turned against its orientation rule", part.name));
        }
        let body = self.machine.body(part.name.clone(), item.mesh.clone(), &item.pose, part.clearance_mm);
        Ok(((at, copy), body))
    }
}

fn wrong<T>(how: String) -> Result<T, ProveError> {
    Err(ProveError::Wrong(how))
}

fn is_same_mesh(read: &Mesh, nested: &Mesh) -> bool {
    let is_close = |a: DVec3, b: DVec3| (a - b).abs().max_element() <= SAME_MESH * (1.0 + b.abs().max_element());
    read.triangles().len() == nested.triangles().len()
        && (read.volume_mm3() - nested.volume_mm3()).abs() <= SAME_MESH * (1.0 + nested.volume_mm3())
        && is_close(read.bounds().min, nested.bounds().min)
        && is_close(read.bounds().max, nested.bounds().max)
}
