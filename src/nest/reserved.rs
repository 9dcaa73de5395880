//! What never moves: zones of the machine in which nothing may stand, and copies that are promised where they stand.

use std::{collections::BTreeSet, sync::Arc};

use glam::DVec3;

use super::{Instance, InstanceError, Placement};
use crate::geometry::{Bounds, Mesh};

/// Slices of a zone thinner than this inside the volume keep nothing out, mm.
const THINNEST_MM: f64 = 1e-6;

/// A zone of the build volume in which nothing may stand.
#[derive(Debug, Clone)]
pub(crate) struct Zone {
    /// The part of it inside the volume, mm.
    pub(crate) bounds: Bounds,
    /// The same as a solid.
    pub(crate) mesh: Arc<Mesh>,
}

/// What never moves, in the build volume's frame.
#[derive(Debug, Clone, Default)]
pub(crate) struct Reserved {
    pub(crate) zones: Vec<Zone>,
    pub(crate) pinned: Vec<Placement>,
}

impl Reserved {
    /// Whether a copy is promised where it stands.
    pub(crate) fn pins(&self) -> BTreeSet<(usize, u32)> {
        self.pinned.iter().map(|p| (p.item, p.copy)).collect()
    }
}

impl Instance {
    /// Keeps boxes of the build volume free, mm in its frame: nothing touches them, but nothing keeps a clearance from
    /// them either. What of a box lies outside the volume is of no matter.
    pub fn with_keep_out(mut self, boxes: &[Bounds]) -> Result<Self, InstanceError> {
        let room = Bounds { min: DVec3::ZERO, max: self.volume().size_mm };
        let mut zones = Vec::new();
        for keep_out in boxes {
            let is_box = keep_out.min.is_finite() && keep_out.max.is_finite() && keep_out.min.cmplt(keep_out.max).all();
            let inside = Bounds { min: keep_out.min.max(room.min), max: keep_out.max.min(room.max) };
            let solid = if is_box { Ok(()) } else { Err(InstanceError::BadKeepOut(keep_out.min, keep_out.max)) };
            solid?;
            if inside.size().min_element() > THINNEST_MM {
                let mesh = block(&inside).ok_or(InstanceError::BadKeepOut(keep_out.min, keep_out.max))?;
                zones.push(Zone { bounds: inside, mesh: Arc::new(mesh) });
            }
        }
        self.reserved_mut().zones = zones;
        Ok(self)
    }

    /// Promises copies where they stand: they are part of every layout and never move. A copy whose pose breaks a rule, or
    /// comes too near to one promised before it, is placed nowhere rather than elsewhere.
    #[must_use]
    pub fn with_pinned(mut self, pinned: Vec<Placement>) -> Self {
        self.reserved_mut().pinned = pinned;
        self
    }

    /// The boxes that are kept free, as far as they lie in the volume, mm.
    pub fn keep_out(&self) -> Vec<Bounds> {
        self.reserved().zones.iter().map(|zone| zone.bounds).collect()
    }

    /// The copies that never move.
    pub fn pinned(&self) -> &[Placement] {
        &self.reserved().pinned
    }
}

/// A box as a solid.
pub(crate) fn block(bounds: &Bounds) -> Option<Mesh> {
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
