//! Who was locked into whom: such pairs keep their convex hulls apart for the next lids, since parts whose hulls stand apart are
//! never locked into each other.

use std::collections::BTreeMap;

use glam::Vec3;

use super::{
    hulls::{self, Overlap},
    push::{Guide, Push},
    separable::Leave,
};

/// Lids for which a pair is remembered: parts of rods and rings stand well in each other's hulls, only not locked.
const LIDS: u8 = 2;
/// Hulls are pushed so much further apart than they must be, mm.
const OVERSHOOT_MM: f32 = 0.03;

/// What is remembered of the layouts that could not be taken apart, and of the last that could.
#[derive(Debug, Clone)]
pub(crate) struct Locks {
    /// Directions along which hulls are looked at.
    spread: Vec<Vec3>,
    /// Pairs, the lesser number first, and for how many lids more they keep their hulls apart.
    pairs: BTreeMap<(usize, usize), u8>,
    /// How the last layout that was looked at came apart.
    pub(crate) leaves: Vec<Leave>,
}

impl Locks {
    /// Nobody was locked yet.
    pub(crate) fn new() -> Self {
        Self { spread: hulls::tried_directions(), pairs: BTreeMap::new(), leaves: Vec::new() }
    }

    /// From now on and for some lids two parts keep their hulls apart. Whether that is new.
    pub(crate) fn keep_apart(&mut self, one: usize, other: usize) -> bool {
        self.pairs.insert((one.min(other), one.max(other)), LIDS).is_none()
    }

    /// A lid has passed.
    pub(crate) fn forget(&mut self) {
        self.pairs.values_mut().for_each(|lids| *lids -= 1);
        self.pairs.retain(|_, lids| *lids > 0);
    }

    fn overlap(&self, (part, guide): (usize, &Guide), (other, there): (usize, &Guide)) -> Option<Overlap> {
        if self.pairs.is_empty() || !self.pairs.contains_key(&(part.min(other), part.max(other))) {
            return None;
        }
        hulls::overlap(guide, there, &self.spread)
    }

    /// The overlap of two hulls that must not, weighed like overlap of the parts, mm3; 0 for all other pairs.
    pub(crate) fn energy(&self, one: (usize, &Guide), other: (usize, &Guide)) -> f32 {
        self.overlap(one, other).map_or(0.0, |hulls| hulls.depth * hulls.area)
    }

    /// Adds to `push` what brings the first part's hull out of the other's.
    pub(crate) fn push(&self, one: (usize, &Guide), other: (usize, &Guide), weight: f32, push: &mut Push) {
        if let Some(hulls) = self.overlap(one, other) {
            push.add(Vec3::ZERO, hulls.way, hulls.depth + OVERSHOOT_MM, weight * hulls.area);
        }
    }
}
