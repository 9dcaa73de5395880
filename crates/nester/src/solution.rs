//! What the nester found, frozen.

use super::{Instance, Placement};

/// A layout in which every placement keeps its clearance, and the copies that found no place.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Placed copies.
    pub placements: Vec<Placement>,
    /// (item, copy) of the copies that found no place, in order of precedence.
    pub unplaced: Vec<(usize, u32)>,
    /// Top of the highest placement, mm; 0 when nothing is placed.
    pub height_mm: f64,
    /// Evaluations made until it was found.
    pub evaluations: u64,
}

impl Solution {
    /// Part volume / (base area x build height), 0 when nothing is placed.
    pub fn density(&self, instance: &Instance) -> f64 {
        let base = instance.volume().size_mm;
        let filled = base.x * base.y * self.height_mm;
        if filled > 0.0 { self.part_volume_mm3(instance) / filled } else { 0.0 }
    }

    /// Volume of the placed copies, mm3.
    pub fn part_volume_mm3(&self, instance: &Instance) -> f64 {
        self.placements.iter().map(|p| instance.items()[p.item].mesh.volume_mm3()).sum()
    }
}
