//! Remembers pairs of parts that were interlocked, alone or in a group: such a pair keeps its convex hulls apart for the
//! next height limits. Two parts whose hulls do not overlap never lock each other.

use std::collections::BTreeMap;

use glam::Vec3;

use super::{
    disassembly::KnownDisassembly,
    hull_penetration::{self, HullPenetration},
    separation_step::{CollisionProxy, SeparationStep},
};

/// Number of height limits for which a pair is remembered. The hulls of rods and rings may well overlap without
/// interlocking.
const REMEMBERED_LIMITS: u8 = 2;
/// Hulls are pushed further apart than necessary by this, mm.
const OVERSHOOT_MM: f32 = 0.03;

/// Memory of the layouts that could not be taken apart, and of the last one that could.
#[derive(Debug, Clone)]
pub(crate) struct InterlockMemory {
    /// Directions along which hulls are looked at.
    spread: Vec<Vec3>,
    /// Pairs, the lesser number first, with the number of height limits for which they still keep their hulls apart.
    pairs: BTreeMap<(usize, usize), u8>,
    /// What is known from the layouts that were checked so far.
    pub(crate) disassembly: KnownDisassembly,
}

impl InterlockMemory {
    /// Nobody was locked yet.
    pub(crate) fn new() -> Self {
        Self {
            spread: hull_penetration::tried_directions(),
            pairs: BTreeMap::new(),
            disassembly: KnownDisassembly::default(),
        }
    }

    /// Makes two parts keep their hulls apart for the next height limits. Returns whether this is new.
    pub(crate) fn keep_apart(&mut self, one: usize, other: usize) -> bool {
        self.pairs.insert((one.min(other), one.max(other)), REMEMBERED_LIMITS).is_none()
    }

    /// Whether two parts keep their hulls apart now.
    pub(crate) fn keeps_apart(&self, one: usize, other: usize) -> bool {
        self.pairs.contains_key(&(one.min(other), one.max(other)))
    }

    /// Counts down after each height limit.
    pub(crate) fn age_pairs(&mut self) {
        self.pairs.values_mut().for_each(|lids| *lids -= 1);
        self.pairs.retain(|_, lids| *lids > 0);
    }

    fn remembered_penetration(
        &self,
        (part, proxy): (usize, &CollisionProxy),
        (other, there): (usize, &CollisionProxy),
    ) -> Option<HullPenetration> {
        if !self.keeps_apart(part, other) {
            return None;
        }
        hull_penetration::hull_penetration(proxy, there, &self.spread)
    }

    /// The hull overlap of a remembered pair, weighted like overlap of the parts, mm3; 0 for all other pairs.
    pub(crate) fn penetration_energy(&self, one: (usize, &CollisionProxy), other: (usize, &CollisionProxy)) -> f32 {
        self.remembered_penetration(one, other).map_or(0.0, |hulls| hulls.depth * hulls.area)
    }

    /// Adds to `push` the contact that moves the first part's hull out of the other's.
    pub(crate) fn add_hull_contact(
        &self,
        one: (usize, &CollisionProxy),
        other: (usize, &CollisionProxy),
        weight: f32,
        push: &mut SeparationStep,
    ) {
        if let Some(hulls) = self.remembered_penetration(one, other) {
            push.add_contact(Vec3::ZERO, hulls.direction, hulls.depth + OVERSHOOT_MM, weight * hulls.area);
        }
    }
}
