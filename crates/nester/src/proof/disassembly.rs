//! The independent proof of separability: can the bodies of a finished layout be removed one after the other? It tests
//! every relevant pair itself and relies on no result of the search.

use std::ops::Range;

use glam::{DVec3, IVec3};
use solids::Bounds;

use super::{LayoutProver, placed_solid::PlacedSolid};
use crate::separation::disassembly::removal_gap_mm;

/// The order in which a layout comes apart.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Disassembly {
    /// Bodies in the order in which they can be removed, each with its direction: a unit vector in the build's frame.
    /// During removal a body keeps [`removal_gap_mm`] from all bodies that come later. A direction points downwards
    /// only if none of the remaining bodies can be removed upwards or sideways.
    pub order: Vec<(usize, DVec3)>,
    /// Interlocked bodies, in rising order.
    pub locked: Vec<usize>,
}

/// Removes bodies along straight lines in the 26 directions of a cube's faces, edges and corners; walls are no
/// obstacle. For bodies whose surfaces meet, or which are nearer to each other than their drawing gap, the result is
/// undefined: such a layout does not pass the proof anyway. A body inside another one is locked.
///
/// ```
/// use std::sync::Arc;
/// use glam::{DQuat, DVec3};
/// use nester::{PlacedSolid, find_removal_order};
/// use solids::{Mesh, Pose};
///
/// let body = |mesh, x: f64| PlacedSolid {
///     name: String::new(),
///     mesh: Arc::new(mesh),
///     pose: Pose::new(DQuat::IDENTITY, DVec3::X * x),
///     clearance_mm: 2.0,
/// };
/// let apart = find_removal_order(&[body(Mesh::tube(30.0, 20.0, 6.0)?, 0.0), body(Mesh::tube(30.0, 20.0, 6.0)?, 40.0)]);
/// assert!(apart.locked.is_empty());
/// assert_eq!(apart.order[0], (0, DVec3::Z)); // removed straight up
/// # Ok::<(), solids::MeshError>(())
/// ```
pub fn find_removal_order(bodies: &[PlacedSolid]) -> Disassembly {
    LayoutProver::new(bodies, 1).find_removal_order()
}

impl LayoutProver<'_> {
    /// Like [`find_removal_order`].
    pub fn find_removal_order(&self) -> Disassembly {
        let mut prover = DisassemblyProver::new(self);
        let mut order = Vec::new();
        while let Some((at, direction)) = prover.next_removal() {
            let body = prover.remaining.remove(at);
            order.push((body, prover.directions[direction]));
        }
        let mut locked = prover.remaining;
        locked.sort_unstable();
        Disassembly { order, locked }
    }
}

/// The first of [`removal_directions`] that points downwards.
const FIRST_FALLING: usize = 17;

/// All directions: upward ones first, straight up before all others, then horizontal ones, then downward ones; simple
/// directions before slanted ones.
fn removal_directions() -> Vec<DVec3> {
    let range = || -1..=1;
    let all = range().flat_map(move |x| range().flat_map(move |y| range().map(move |z| IVec3::new(x, y, z))));
    let mut directions: Vec<IVec3> = all.filter(|&direction| direction != IVec3::ZERO).collect();
    directions.sort_by_key(|direction| (-direction.z, direction.length_squared()));
    directions.into_iter().map(|direction| direction.as_dvec3().normalize()).collect()
}

struct DisassemblyProver<'a> {
    layout: &'a LayoutProver<'a>,
    directions: Vec<DVec3>,
    /// Bodies that remain, from the highest top to the lowest.
    remaining: Vec<usize>,
    /// For every body and direction, the bodies known to block it and those known not to.
    known: Vec<Vec<KnownObstacles>>,
}

#[derive(Debug, Clone, Default)]
struct KnownObstacles {
    blocked_by: Option<usize>,
    /// Sorted.
    harmless: Vec<usize>,
}

impl<'a> DisassemblyProver<'a> {
    fn new(layout: &'a LayoutProver<'a>) -> Self {
        let bounds = &layout.bounds;
        let mut left: Vec<usize> = (0..bounds.len()).collect();
        left.sort_by(|&a, &b| bounds[b].max.z.total_cmp(&bounds[a].max.z));
        let directions = removal_directions();
        let known = vec![vec![KnownObstacles::default(); directions.len()]; bounds.len()];
        Self { layout, directions, remaining: left, known }
    }

    /// The next body that can be removed, as its index among the remaining bodies, and its direction.
    fn next_removal(&mut self) -> Option<(usize, usize)> {
        // The highest body that has a direction which is not downwards, so that whoever unpacks works from the top down. The
        // cake lies on a floor: bodies that can only move down wait until the cake is lifted.
        [0..FIRST_FALLING, FIRST_FALLING..self.directions.len()]
            .into_iter()
            .find_map(|directions| self.next_removal_along(directions))
    }

    fn next_removal_along(&mut self, directions: Range<usize>) -> Option<(usize, usize)> {
        let mut tries =
            (0..self.remaining.len()).flat_map(|at| directions.clone().map(move |direction| (at, direction)));
        tries.find(|&(at, direction)| !self.is_blocked(self.remaining[at], direction))
    }

    /// Whether any remaining body blocks the removal of a body.
    fn is_blocked(&mut self, body: usize, direction: usize) -> bool {
        let mut known = std::mem::take(&mut self.known[body][direction]);
        if known.blocked_by.is_none_or(|by| !self.remaining.contains(&by)) {
            known.blocked_by = None;
            for &other in &self.remaining {
                let place = known.harmless.binary_search(&other);
                if let (Err(place), true) = (place, other != body) {
                    if self.blocks_removal(other, body, self.directions[direction]) {
                        known.blocked_by = Some(other);
                        break;
                    }
                    known.harmless.insert(place, other);
                }
            }
        }
        let barred = known.blocked_by.is_some();
        self.known[body][direction] = known;
        barred
    }

    fn blocks_removal(&self, standing: usize, moving: usize, direction: DVec3) -> bool {
        let (one, other) = (&self.layout.bodies[moving], &self.layout.bodies[standing]);
        let gap_mm = removal_gap_mm(one.clearance_mm.max(other.clearance_mm));
        if !sweep_may_meet(&self.layout.bounds[moving], &self.layout.bounds[standing], direction, gap_mm) {
            return false;
        }
        if self.contains_body(standing, moving) || self.contains_body(moving, standing) {
            return true;
        }
        let direction1 = one.pose.rotation.conjugate() * direction;
        let trees = &self.layout.trees;
        !trees.tree(moving).is_free_along(
            trees.tree(standing),
            &one.pose.relative_pose_of(&other.pose),
            direction1,
            gap_mm,
        )
    }

    /// Whether one body lies inside the other's solid or in a sealed cavity of it.
    fn contains_body(&self, outer: usize, inner: usize) -> bool {
        let pose12 = || self.layout.bodies[outer].pose.relative_pose_of(&self.layout.bodies[inner].pose);
        let trees = &self.layout.trees;
        self.layout.bounds[outer].contains_bounds(&self.layout.bounds[inner], 0.0)
            && trees.tree(outer).contains_part(trees.tree(inner), &pose12())
    }
}

/// Whether a box moved without limit along `way` comes nearer to another box than a gap along every axis at once.
fn sweep_may_meet(moving: &Bounds, standing: &Bounds, way: DVec3, gap_mm: f64) -> bool {
    const ROUNDING_MM: f64 = 1e-6;
    let (mut begin, mut end) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let low = standing.min[axis] - moving.max[axis] - gap_mm - ROUNDING_MM;
        let high = standing.max[axis] - moving.min[axis] + gap_mm + ROUNDING_MM;
        if way[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return false;
            }
        } else {
            let (one, two) = (low / way[axis], high / way[axis]);
            (begin, end) = (begin.max(one.min(two)), end.min(one.max(two)));
        }
    }
    // Bounds that are no numbers are never out of reach.
    begin.partial_cmp(&end) != Some(std::cmp::Ordering::Greater)
}

#[cfg(test)]
#[path = "disassembly_tests.rs"]
mod tests;
