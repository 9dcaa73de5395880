//! What is proved: solids at their poses.

use std::sync::Arc;

use solids::{Mesh, Pose};

use crate::{ItemPlacement, NestingInstance};

/// One placed solid, as input of the proof.
#[derive(Debug, Clone)]
pub struct PlacedSolid {
    /// Name for reports.
    pub name: String,
    /// The solid. Equal meshes should share one `Arc`, so that their preparation is shared.
    pub mesh: Arc<Mesh>,
    /// Mesh frame -> build frame.
    pub pose: Pose,
    /// Clearance required for this body, mm. Between two bodies the greater one applies.
    pub clearance_mm: f64,
}

impl PlacedSolid {
    /// The placed copies of an instance, in the order of the placements, named `part #1`, `part #2`, ..
    pub fn of_layout(instance: &NestingInstance, placements: &[ItemPlacement]) -> Vec<Self> {
        let body = |placement: &ItemPlacement| {
            let item = &instance.items()[placement.item];
            Self {
                name: format!("{} #{}", item.name, placement.copy + 1),
                mesh: item.mesh.clone(),
                pose: placement.pose,
                clearance_mm: instance.clearance_between_mm(placement.item, placement.item),
            }
        };
        placements.iter().map(body).collect()
    }
}
