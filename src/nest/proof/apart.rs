//! The independent judge of separability: can the bodies of a finished layout be drawn out one after the other? It counts
//! for every body how many others bar each of its ways, and lets go whoever has a way that nobody bars.

use std::{collections::BTreeSet, sync::Arc};

use glam::{DVec3, IVec3};

use super::{Body, trees};
use crate::{
    geometry::{Bounds, ClearanceTree},
    nest::separable::drawing_gap_mm,
};

/// How a layout comes apart.
#[derive(Debug, Clone, PartialEq)]
pub struct TakenApart {
    /// Bodies in the order in which they can be drawn out, each with the way that it takes: a unit vector in the build's
    /// frame. On its way a body keeps [`drawing_gap_mm`] from all bodies that come later.
    pub order: Vec<(usize, DVec3)>,
    /// Bodies that are locked into each other, in order.
    pub locked: Vec<usize>,
}

/// Takes bodies apart along straight lines in the 26 directions of a cube's faces, edges and corners; walls are no
/// obstacle. Of bodies whose surfaces meet, or are nearer to each other than their drawing gap, nothing certain is said: they
/// are no proved layout anyway. A body inside another one is locked.
pub fn take_apart(bodies: &[Body]) -> TakenApart {
    let bounds: Vec<Bounds> = bodies.iter().map(|body| body.mesh.bounds_at(&body.pose)).collect();
    let mut from_top: Vec<usize> = (0..bodies.len()).collect();
    from_top.sort_by(|&a, &b| bounds[b].max.z.total_cmp(&bounds[a].max.z));
    let judge = Judge { bodies, trees: trees(bodies), bounds };
    let mut left: BTreeSet<usize> = (0..bodies.len()).collect();
    let mut order = Vec::new();
    // Nearly all leave upwards; the other ways are only asked for those who cannot.
    let up = vec![Barred::new(&judge, DVec3::Z, &left)];
    let mut known = up;
    loop {
        let free = |known: &[Barred]| {
            let free =
                |&body: &usize| known.iter().find(|barred| barred.by[body] == 0).map(|barred| (body, barred.way));
            from_top.iter().filter(|body| left.contains(body)).find_map(free)
        };
        match free(&known) {
            Some((body, way)) => {
                left.remove(&body);
                known.iter_mut().for_each(|barred| barred.release(body));
                order.push((body, way));
            }
            None if known.len() == 1 && !left.is_empty() => {
                known.extend(other_ways().map(|way| Barred::new(&judge, way, &left)));
            }
            None => return TakenApart { order, locked: left.into_iter().collect() },
        }
    }
}

/// All directions but straight up.
fn other_ways() -> impl Iterator<Item = DVec3> {
    let range = || -1..=1;
    let all = range().flat_map(move |x| range().flat_map(move |y| range().map(move |z| IVec3::new(x, y, z))));
    all.filter(|&way| way != IVec3::ZERO && way != IVec3::Z).map(|way| way.as_dvec3().normalize())
}

struct Judge<'a> {
    bodies: &'a [Body],
    trees: Vec<Arc<ClearanceTree>>,
    bounds: Vec<Bounds>,
}

impl Judge<'_> {
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

/// Who is barred along one way.
struct Barred {
    way: DVec3,
    /// How many of those who are left bar each body.
    by: Vec<usize>,
    /// Whom each body bars.
    bars: Vec<Vec<usize>>,
}

impl Barred {
    fn new(judge: &Judge<'_>, way: DVec3, left: &BTreeSet<usize>) -> Self {
        let count = judge.bodies.len();
        let mut barred = Self { way, by: vec![0; count], bars: vec![Vec::new(); count] };
        for &standing in left {
            for &moving in left {
                if standing != moving && judge.bars(standing, moving, way) {
                    barred.by[moving] += 1;
                    barred.bars[standing].push(moving);
                }
            }
        }
        barred
    }

    /// A body is gone.
    fn release(&mut self, gone: usize) {
        for moving in std::mem::take(&mut self.bars[gone]) {
            self.by[moving] -= 1;
        }
    }
}

#[cfg(test)]
#[path = "apart_tests.rs"]
mod tests;
