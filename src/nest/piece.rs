//! What is nested and how a layout is judged while it is built: exactly, on the triangles.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::{
    Instance, OrientationRule, Placement, Solution, fit, fit::WALL_SPARE_MM, shape, shape::Detail, shape::Shape,
};
use crate::geometry::{Bounds, Pose};

/// What two placements keep beyond their clearance, mm, so that rounding in a written file never breaks it.
pub(crate) const CLEARANCE_SPARE_MM: f64 = 1e-4;

/// An item that fits the volume, prepared.
#[derive(Debug, Clone)]
pub(crate) struct Kind {
    pub(crate) shape: Arc<Shape>,
    pub(crate) rule: OrientationRule,
    /// Clearance asked for it, mm; between two parts the greater holds.
    pub(crate) clearance_mm: f64,
    /// A rotation in which it stands in the volume.
    pub(crate) fitting: DQuat,
}

/// The instance, prepared. `kinds` has one entry per item; `None` for those that fit in no allowed orientation.
#[derive(Debug, Clone)]
pub(crate) struct Task {
    pub(crate) kinds: Vec<Option<Kind>>,
    /// All copies that fit alone, in order of precedence.
    pub(crate) copies: Vec<(usize, u32)>,
    pub(crate) room: DVec3,
    /// The greatest clearance of any item, mm.
    pub(crate) reach_mm: f64,
    /// Whether a layout counts only when no part is locked into others.
    pub(crate) separable: bool,
}

impl Task {
    /// Prepares every distinct mesh that fits. Locked parts are let be.
    pub(crate) fn new(instance: &Instance, nodes: usize, points: usize) -> Self {
        let own = |item: &super::Item| item.clearance_mm.unwrap_or(0.0).max(instance.clearance_mm());
        let reach_mm = instance.items().iter().map(own).fold(0.0, f64::max);
        let detail = Detail { nodes, points, reach_mm: reach_mm + 0.5 };
        let kinds: Vec<Option<Kind>> = (instance.items().iter())
            .map(|item| {
                let fitting = fit::fits(&item.mesh, item.orientation, &instance.volume()).ok()?;
                let shape = shape::prepare(&item.mesh, detail);
                Some(Kind { shape, rule: item.orientation, clearance_mm: own(item), fitting })
            })
            .collect();
        let copies = (instance.items().iter().enumerate())
            .filter(|&(at, _)| kinds[at].is_some())
            .flat_map(|(at, item)| (0..item.copies).map(move |copy| (at, copy)))
            .collect();
        Self { kinds, copies, room: instance.volume().size_mm, reach_mm, separable: false }
    }

    /// The prepared item of a copy that is being nested.
    pub(crate) fn kind(&self, item: usize) -> &Kind {
        self.kinds[item].as_ref().expect("only items that fit are nested")
    }

    /// Clearance between two items, mm.
    pub(crate) fn clearance_mm(&self, item1: usize, item2: usize) -> f64 {
        self.kind(item1).clearance_mm.max(self.kind(item2).clearance_mm)
    }

    /// A copy at a rotation and a place of its center.
    pub(crate) fn piece(&self, (item, copy): (usize, u32), turn: DQuat, place: DVec3) -> Piece {
        let shape = &self.kind(item).shape;
        let pose = shape.pose(turn, place);
        Piece { item, copy, turn, place, pose, bounds: shape.tree.bounds_at(&pose) }
    }

    /// Whether a piece stands inside the walls.
    pub(crate) fn is_inside(&self, piece: &Piece, lid_mm: f64) -> bool {
        let room = Bounds { min: DVec3::ZERO, max: self.room.with_z(lid_mm.min(self.room.z)) };
        room.holds(&piece.bounds, WALL_SPARE_MM - 1e-7)
    }

    /// Whether two pieces keep their clearance and none is inside the other. Exact.
    pub(crate) fn is_clear(&self, one: &Piece, other: &Piece) -> bool {
        self.gap_mm(one, other) >= self.clearance_mm(one.item, other.item) + CLEARANCE_SPARE_MM
    }

    /// Distance between two pieces, exact up to a little more than their clearance; negative when one is inside the other.
    pub(crate) fn gap_mm(&self, one: &Piece, other: &Piece) -> f64 {
        let cap = self.clearance_mm(one.item, other.item) + 2.0 * CLEARANCE_SPARE_MM;
        if one.bounds.distance(&other.bounds) >= cap {
            return cap;
        }
        let (tree1, tree2) = (&self.kind(one.item).shape.tree, &self.kind(other.item).shape.tree);
        let pose12 = one.pose.seen(&other.pose);
        let gap = tree1.distance_capped_mm(tree2, &pose12, cap);
        if gap > 0.0 && one.bounds.holds(&other.bounds, 0.0) && tree1.holds_part(tree2, &pose12) {
            return -1.0;
        }
        let pose21 = pose12.inverse();
        if gap > 0.0 && other.bounds.holds(&one.bounds, 0.0) && tree2.holds_part(tree1, &pose21) {
            return -1.0;
        }
        gap
    }

    /// The solution that pieces make.
    pub(crate) fn solution(&self, instance: &Instance, pieces: &[Piece], evaluations: u64) -> Solution {
        let mut placements: Vec<Placement> =
            pieces.iter().map(|p| Placement { item: p.item, copy: p.copy, pose: p.pose }).collect();
        placements.sort_by_key(|p| (p.item, p.copy));
        let placed = |copy: (usize, u32)| placements.binary_search_by_key(&copy, |p| (p.item, p.copy)).is_ok();
        let all = (instance.items().iter().enumerate()).flat_map(|(i, item)| (0..item.copies).map(move |c| (i, c)));
        let unplaced = all.filter(|&copy| !placed(copy)).collect();
        Solution { unplaced, height_mm: height_mm(pieces), evaluations, placements }
    }
}

/// One placed copy.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub(crate) item: usize,
    pub(crate) copy: u32,
    pub(crate) turn: DQuat,
    /// Where the shape's center stands.
    pub(crate) place: DVec3,
    pub(crate) pose: Pose,
    /// Exact bounds.
    pub(crate) bounds: Bounds,
}

/// Top of the highest piece, mm.
pub(crate) fn height_mm(pieces: &[Piece]) -> f64 {
    pieces.iter().map(|p| p.bounds.max.z).fold(0.0, f64::max)
}
