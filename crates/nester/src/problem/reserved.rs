//! What never moves: zones of the machine in which no part may be placed, and copies with fixed poses.

use std::{collections::BTreeSet, sync::Arc};

use glam::DVec3;
use solids::{Bounds, Mesh};

use crate::ItemPlacement;

/// A zone of the build volume in which no part may be placed.
#[derive(Debug, Clone)]
pub(crate) struct ReservedZone {
    /// The part of it inside the volume, mm.
    pub(crate) bounds: Bounds,
    /// The same as a solid.
    pub(crate) mesh: Arc<Mesh>,
}

/// Zones and fixed copies, in the build volume's frame.
#[derive(Debug, Clone, Default)]
pub(crate) struct ReservedSpace {
    pub(crate) zones: Vec<ReservedZone>,
    pub(crate) pinned: Vec<ItemPlacement>,
}

impl ReservedSpace {
    /// The copies that are fixed at a pose.
    pub(crate) fn pinned_copies(&self) -> BTreeSet<(usize, u32)> {
        self.pinned.iter().map(|p| (p.item, p.copy)).collect()
    }
}

/// A box as a solid.
pub(crate) fn box_mesh(bounds: &Bounds) -> Option<Mesh> {
    let size = bounds.size();
    let corner = |n: usize| bounds.min + size * DVec3::new((n & 1) as f64, (n >> 1 & 1) as f64, (n >> 2 & 1) as f64);
    let triangles = vec![
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    Mesh::new((0..8).map(corner).collect(), triangles).ok()
}
