//! Disassembly of a layout: the order and the straight lines along which parts can be removed one after the other, and
//! the parts that are interlocked. Removing a part never makes another removal harder, so always removing the first
//! possible part is exact for a fixed set of directions.

use std::collections::HashMap;

use glam::DVec3;
use solids::{Bounds, ClearanceTree, Pose};

use crate::prepare::prepared_instance::{PlacedItem, PreparedInstance};

/// Greatest distance that a part keeps from all others during removal, mm: needed for loose powder and warped parts.
const MAX_GAP_MM: f64 = 0.5;
/// The least distance, used at clearance 0, where parts are at least twice this far apart.
const MIN_GAP_MM: f64 = 5e-5;
/// Distance that the search keeps beyond the gap, mm, so that rounding in a written file never locks a part.
const GAP_SPARE_MM: f64 = 2e-5;

/// Number of removal directions.
pub(crate) const DIRECTION_COUNT: usize = 26;

/// Number of directions along the axes, which come first.
const AXIS_DIRECTION_COUNT: usize = 6;

/// The removal directions, unit vectors: up first, then along the other axes, the edges and the corners of a cube.
pub(crate) fn removal_directions() -> [DVec3; DIRECTION_COUNT] {
    let mut directions = [DVec3::Z; DIRECTION_COUNT];
    let mut at = 1;
    for axes in 1..=3 {
        for code in 0..27 {
            let direction = DVec3::new(f64::from(code % 3 - 1), f64::from(code / 3 % 3 - 1), f64::from(code / 9 - 1));
            if direction.length_squared() as i32 == axes && direction != DVec3::Z {
                directions[at] = direction.normalize();
                at += 1;
            }
        }
    }
    directions
}

/// Distance that two parts keep while one of them is removed, mm: half of their clearance, at most half a millimetre.
///
/// ```
/// assert_eq!((nester::removal_gap_mm(0.6), nester::removal_gap_mm(3.0)), (0.3, 0.5));
/// ```
pub fn removal_gap_mm(clearance_mm: f64) -> f64 {
    (0.5 * clearance_mm).clamp(MIN_GAP_MM, MAX_GAP_MM)
}

/// A placed part, as a removal test sees it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RemovablePart<'a> {
    tree: &'a ClearanceTree,
    pose: &'a Pose,
    bounds: &'a Bounds,
    clearance_mm: f64,
}

impl<'a> RemovablePart<'a> {
    fn new(prepared: &'a PreparedInstance, piece: &'a PlacedItem) -> Self {
        let kind = prepared.prepared_item(piece.item);
        Self { tree: &kind.shape.tree, pose: &piece.pose, bounds: &piece.bounds, clearance_mm: kind.clearance_mm }
    }

    fn gap_mm(&self, other: &Self) -> f64 {
        removal_gap_mm(self.clearance_mm.max(other.clearance_mm)) + GAP_SPARE_MM
    }

    /// Whether the bounding boxes allow a collision of this part with the other one during removal.
    fn may_collide(&self, other: &Self, direction: DVec3) -> bool {
        let gap = self.gap_mm(other);
        let (low, high) = (other.bounds.min - self.bounds.max - gap, other.bounds.max - self.bounds.min + gap);
        let (mut begin, mut end) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if low[axis] > 0.0 || high[axis] < 0.0 {
                    return false;
                }
                continue;
            }
            let (one, two) = (low[axis] / direction[axis], high[axis] / direction[axis]);
            (begin, end) = (begin.max(one.min(two)), end.min(one.max(two)));
        }
        begin <= end
    }

    fn is_free(&self, other: &Self, direction: DVec3) -> bool {
        let direction1 = self.pose.rotation.conjugate() * direction;
        self.tree.is_free_along(other.tree, &self.pose.relative_pose_of(other.pose), direction1, self.gap_mm(other))
    }
}

/// Whether a piece that is not among `others` can be removed from among them along an axis. Slanted directions cost
/// more to test than they gain.
pub(crate) fn can_be_removed(prepared: &PreparedInstance, piece: &PlacedItem, others: &[PlacedItem]) -> bool {
    let solid = RemovablePart::new(prepared, piece);
    // The nearest pieces are the likeliest to block.
    let mut nearest: Vec<(f64, RemovablePart<'_>)> = others
        .iter()
        .map(|other| (piece.bounds.distance(&other.bounds), RemovablePart::new(prepared, other)))
        .collect();
    nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
    let is_free = |direction: DVec3| {
        nearest.iter().all(|(_, other)| !solid.may_collide(other, direction) || solid.is_free(other, direction))
    };
    removal_directions().into_iter().take(AXIS_DIRECTION_COUNT).any(is_free)
}

/// The removal of one part in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PartRemoval {
    pub(crate) part: usize,
    pub(crate) direction: usize,
}

/// The result of taking a layout apart.
#[derive(Debug, Clone, Default)]
pub(crate) struct DisassemblyPlan {
    /// Locked parts, in rising order.
    pub(crate) locked: Vec<usize>,
    /// Number of sweep tests of one part against another.
    pub(crate) sweeps: u64,
}

/// What is known from an earlier disassembly of the same parts, which may have moved since.
#[derive(Debug, Clone, Default)]
pub(crate) struct KnownDisassembly {
    /// The removed parts, in order of removal: they are tried first.
    pub(crate) removals: Vec<PartRemoval>,
    /// Part, other part and direction of the sweep tests that found nothing, with the move counts of both parts then.
    free: HashMap<(usize, usize, usize), (u32, u32)>,
}

/// Takes pieces apart. `move_counts` tells how often each of them has moved (and more parts perhaps): a sweep that was free is
/// not tested again while both parts stay. Leaves in `known` what was found.
pub(crate) fn plan_disassembly(
    prepared: &PreparedInstance,
    pieces: &[PlacedItem],
    move_counts: &[u32],
    known: &mut KnownDisassembly,
) -> DisassemblyPlan {
    let solids = pieces.iter().map(|piece| RemovablePart::new(prepared, piece)).collect();
    let mut work = DisassemblySearch::new(solids);
    work.free = std::mem::take(&mut known.free);
    work.free.retain(|&(part, other, _), then| (move_counts[part], move_counts[other]) == *then);
    work.move_counts = move_counts.to_vec();
    for leave in &known.removals {
        work.try_remove(leave.part, leave.direction);
    }
    while work.remove_upwards() || work.remove_any_direction() {}
    let locked = (0..pieces.len()).filter(|&part| !work.removed[part]).collect();
    *known = KnownDisassembly { removals: work.removals, free: work.free };
    DisassemblyPlan { locked, sweeps: work.sweeps }
}

/// The pieces that must be dropped so that all others can be taken apart: repeatedly the smallest of the locked pieces.
/// In rising order.
pub(crate) fn items_blocking_disassembly(prepared: &PreparedInstance, pieces: &[PlacedItem]) -> Vec<usize> {
    let volume = |part: usize| prepared.prepared_item(pieces[part].item).shape.tree.mesh().volume_mm3();
    let mut work = DisassemblySearch::new(pieces.iter().map(|piece| RemovablePart::new(prepared, piece)).collect());
    let mut dropped = Vec::new();
    loop {
        while work.remove_upwards() || work.remove_any_direction() {}
        let locked = (0..pieces.len()).filter(|&part| !work.removed[part]);
        let Some(smallest) = locked.min_by(|&a, &b| volume(a).total_cmp(&volume(b))) else { break };
        work.removed[smallest] = true;
        dropped.push(smallest);
    }
    dropped.sort_unstable();
    dropped
}

/// Pairs of locked parts that lock each other: neither can be removed from the other, whichever other parts are gone.
pub(crate) fn locked_pairs(
    prepared: &PreparedInstance,
    pieces: &[PlacedItem],
    locked: &[usize],
) -> Vec<(usize, usize)> {
    let directions = removal_directions();
    let mut pairs = Vec::new();
    for (at, &one) in locked.iter().enumerate() {
        let solid1 = RemovablePart::new(prepared, &pieces[one]);
        for &other in &locked[at + 1..] {
            let solid2 = RemovablePart::new(prepared, &pieces[other]);
            if directions
                .into_iter()
                .all(|direction| solid1.may_collide(&solid2, direction) && !solid1.is_free(&solid2, direction))
            {
                pairs.push((one, other));
            }
        }
    }
    pairs
}

/// Progress of the obstacle test for one part and direction, in the order from the top.
#[derive(Debug, Clone, Copy, Default)]
struct ObstacleScan {
    /// All parts before this index do not block, or are removed.
    next: u32,
    /// Whether the part at this index blocks.
    blocked: bool,
}

/// A layout while it is being taken apart.
struct DisassemblySearch<'a> {
    solids: Vec<RemovablePart<'a>>,
    directions: [DVec3; DIRECTION_COUNT],
    /// The progress for every part and direction: no pair is tested twice for the same direction.
    scans: Vec<[ObstacleScan; DIRECTION_COUNT]>,
    /// Parts from the highest top to the lowest.
    from_top: Vec<usize>,
    removed: Vec<bool>,
    removals: Vec<PartRemoval>,
    sweeps: u64,
    /// As in [`KnownDisassembly`].
    free: HashMap<(usize, usize, usize), (u32, u32)>,
    /// Number of moves of each part.
    move_counts: Vec<u32>,
}

impl<'a> DisassemblySearch<'a> {
    fn new(solids: Vec<RemovablePart<'a>>) -> Self {
        let mut from_top: Vec<usize> = (0..solids.len()).collect();
        from_top.sort_by(|&a, &b| solids[b].bounds.max.z.total_cmp(&solids[a].bounds.max.z));
        let (asked, gone) = (vec![[ObstacleScan::default(); DIRECTION_COUNT]; solids.len()], vec![false; solids.len()]);
        Self {
            move_counts: vec![0; solids.len()],
            free: HashMap::new(),
            solids,
            directions: removal_directions(),
            scans: asked,
            from_top,
            removed: gone,
            removals: Vec::new(),
            sweeps: 0,
        }
    }

    /// Removes a part if nothing blocks it.
    fn try_remove(&mut self, part: usize, direction: usize) -> bool {
        if self.removed[part] || self.is_blocked(part, direction) {
            return false;
        }
        self.removed[part] = true;
        self.removals.push(PartRemoval { part, direction });
        true
    }

    fn is_blocked(&mut self, part: usize, direction: usize) -> bool {
        let (solid, line) = (&self.solids[part], self.directions[direction]);
        let asked = &mut self.scans[part][direction];
        while let Some(other) = self.from_top.get(asked.next as usize).copied() {
            if other != part && !self.removed[other] {
                let key = (part, other, direction);
                if !asked.blocked && solid.may_collide(&self.solids[other], line) && !self.free.contains_key(&key) {
                    self.sweeps += 1;
                    asked.blocked = !solid.is_free(&self.solids[other], line);
                    if !asked.blocked {
                        self.free.insert(key, (self.move_counts[part], self.move_counts[other]));
                    }
                }
                if asked.blocked {
                    return true;
                }
            }
            *asked = ObstacleScan { next: asked.next + 1, blocked: false };
        }
        false
    }

    /// Removes all parts that can be removed upwards, the highest first. Returns whether any was removed.
    fn remove_upwards(&mut self) -> bool {
        let before = self.removals.len();
        for at in 0..self.from_top.len() {
            self.try_remove(self.from_top[at], 0);
        }
        self.removals.len() > before
    }

    /// Removes the highest part that can be removed in any direction. Returns whether there was one.
    fn remove_any_direction(&mut self) -> bool {
        (0..self.from_top.len())
            .any(|at| (1..DIRECTION_COUNT).any(|direction| self.try_remove(self.from_top[at], direction)))
    }
}
