//! The independent judge of separability: can the bodies of a finished layout be drawn out one after the other? It asks the
//! kernel about every pair that matters itself and takes nothing over from the search.

use std::{ops::Range, sync::Arc};

use glam::{DVec3, IVec3};
use solids::{Bounds, ClearanceTree};

use super::{Body, trees};
use crate::separable::drawing_gap_mm;

/// How a layout comes apart.
#[derive(Debug, Clone, PartialEq)]
pub struct TakenApart {
    /// Bodies in the order in which they can be drawn out, each with the way that it takes: a unit vector in the build's
    /// frame. On its way a body keeps [`drawing_gap_mm`] from all bodies that come later. A way falls only where none of those
    /// who are still there can go up or sideways.
    pub order: Vec<(usize, DVec3)>,
    /// Bodies that are locked into each other, in order.
    pub locked: Vec<usize>,
}

/// Takes bodies apart along straight lines in the 26 directions of a cube's faces, edges and corners; walls are no
/// obstacle. Of bodies whose surfaces meet, or are nearer to each other than their drawing gap, nothing certain is said: they
/// are no proved layout anyway. A body inside another one is locked.
///
/// ```
/// use std::sync::Arc;
/// use glam::{DQuat, DVec3};
/// use nester::{Body, take_apart};
/// use solids::Pose;
///
/// let body = |mesh, x: f64| Body {
///     name: String::new(),
///     mesh: Arc::new(mesh),
///     pose: Pose::new(DQuat::IDENTITY, DVec3::X * x),
///     clearance_mm: 2.0,
/// };
/// let apart = take_apart(&[body(sample_parts::ring(30.0, 20.0, 6.0), 0.0), body(sample_parts::ring(30.0, 20.0, 6.0), 40.0)]);
/// assert!(apart.locked.is_empty());
/// assert_eq!(apart.order[0], (0, DVec3::Z)); // drawn straight up
/// ```
pub fn take_apart(bodies: &[Body]) -> TakenApart {
    let mut judge = Judge::new(bodies);
    let mut order = Vec::new();
    while let Some((at, way)) = judge.next_to_leave() {
        let body = judge.left.remove(at);
        order.push((body, judge.ways[way]));
    }
    let mut locked = judge.left;
    locked.sort_unstable();
    TakenApart { order, locked }
}

/// The first of [`all_ways`] that falls.
const FALLING: usize = 17;

/// All directions: those that rise, straight up first, then those along the floor, then those that fall; simple ones before
/// slanted ones.
fn all_ways() -> Vec<DVec3> {
    let range = || -1..=1;
    let all = range().flat_map(move |x| range().flat_map(move |y| range().map(move |z| IVec3::new(x, y, z))));
    let mut ways: Vec<IVec3> = all.filter(|&way| way != IVec3::ZERO).collect();
    ways.sort_by_key(|way| (-way.z, way.length_squared()));
    ways.into_iter().map(|way| way.as_dvec3().normalize()).collect()
}

struct Judge<'a> {
    bodies: &'a [Body],
    trees: Vec<Arc<ClearanceTree>>,
    bounds: Vec<Bounds>,
    ways: Vec<DVec3>,
    /// Bodies that are still there, from the highest top to the lowest.
    left: Vec<usize>,
    /// For every body and way, who was found to bar it and who was found not to.
    known: Vec<Vec<Known>>,
}

#[derive(Debug, Clone, Default)]
struct Known {
    barred_by: Option<usize>,
    /// Sorted.
    harmless: Vec<usize>,
}

impl<'a> Judge<'a> {
    fn new(bodies: &'a [Body]) -> Self {
        let bounds: Vec<Bounds> = bodies.iter().map(|body| body.mesh.bounds_at(&body.pose)).collect();
        let mut left: Vec<usize> = (0..bodies.len()).collect();
        left.sort_by(|&a, &b| bounds[b].max.z.total_cmp(&bounds[a].max.z));
        let ways = all_ways();
        let known = vec![vec![Known::default(); ways.len()]; bodies.len()];
        Self { bodies, trees: trees(bodies), bounds, ways, left, known }
    }

    /// Who can leave now, as a place among those who are left, and along which way.
    fn next_to_leave(&mut self) -> Option<(usize, usize)> {
        // Whoever can leaves upwards; when nobody can, the highest of those who find a way that does not fall. The cake stands
        // on a floor: what goes down waits until it is lifted.
        [0..1, 1..FALLING, FALLING..self.ways.len()].into_iter().find_map(|ways| self.next_on(ways))
    }

    fn next_on(&mut self, ways: Range<usize>) -> Option<(usize, usize)> {
        let mut tries = (0..self.left.len()).flat_map(|at| ways.clone().map(move |way| (at, way)));
        tries.find(|&(at, way)| !self.is_barred(self.left[at], way))
    }

    /// Whether anybody who is left bars the way of a body.
    fn is_barred(&mut self, body: usize, way: usize) -> bool {
        let mut known = std::mem::take(&mut self.known[body][way]);
        if known.barred_by.is_none_or(|by| !self.left.contains(&by)) {
            known.barred_by = None;
            for &other in &self.left {
                let place = known.harmless.binary_search(&other);
                if let (Err(place), true) = (place, other != body) {
                    if self.bars(other, body, self.ways[way]) {
                        known.barred_by = Some(other);
                        break;
                    }
                    known.harmless.insert(place, other);
                }
            }
        }
        let barred = known.barred_by.is_some();
        self.known[body][way] = known;
        barred
    }

    fn bars(&self, standing: usize, moving: usize, way: DVec3) -> bool {
        let (one, other) = (&self.bodies[moving], &self.bodies[standing]);
        let gap_mm = drawing_gap_mm(one.clearance_mm.max(other.clearance_mm));
        if self.holds(standing, moving) || self.holds(moving, standing) {
            return true;
        }
        let way1 = one.pose.rotation.conjugate() * way;
        !self.trees[moving].is_free_along(&self.trees[standing], &one.pose.seen(&other.pose), way1, gap_mm)
    }

    /// Whether one body lies inside the other's solid or a sealed cavity of it.
    fn holds(&self, outer: usize, inner: usize) -> bool {
        let pose12 = || self.bodies[outer].pose.seen(&self.bodies[inner].pose);
        self.bounds[outer].holds(&self.bounds[inner], 0.0)
            && self.trees[outer].holds_part(&self.trees[inner], &pose12())
    }
}

#[cfg(test)]
#[path = "apart_tests.rs"]
mod tests;
