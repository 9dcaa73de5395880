//! The result of the search.

use serde::{Deserialize, Serialize};

use crate::{ItemPlacement, NestingInstance};

/// A layout that is no more than this above the lower bound is as low as any, mm.
pub(crate) const BOUND_TOLERANCE_MM: f64 = 0.01;

/// A layout in which every placement keeps its clearance, and the copies that found no place.
///
/// ```
/// use nester::NestingSolution;
///
/// let text = r#"{"placements": [], "unplaced": [[0, 0], [0, 1]], "height_mm": 0.0, "evaluations": 12}"#;
/// let nothing_placed: NestingSolution = serde_json::from_str(text)?;
/// assert_eq!(nothing_placed.unplaced, [(0, 0), (0, 1)]);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NestingSolution {
    /// Placed copies.
    pub placements: Vec<ItemPlacement>,
    /// (item, copy) of the copies that could not be placed, in order of precedence.
    pub unplaced: Vec<(usize, u32)>,
    /// Top of the highest placement, mm; 0 when nothing is placed.
    pub height_mm: f64,
    /// Number of evaluations made until this layout was found.
    pub evaluations: u64,
}

impl NestingSolution {
    /// Whether no lower layout exists: all copies are placed, at the height of the [`lower_bound_mm`](crate::lower_bound_mm).
    pub fn is_lowest(&self, lower_bound_mm: f64) -> bool {
        self.unplaced.is_empty() && self.height_mm <= lower_bound_mm + BOUND_TOLERANCE_MM
    }

    /// Part volume / (base area x build height), 0 when nothing is placed.
    pub fn density(&self, instance: &NestingInstance) -> f64 {
        let base = instance.volume().size_mm;
        let filled = base.x * base.y * self.height_mm;
        if filled > 0.0 { self.part_volume_mm3(instance) / filled } else { 0.0 }
    }

    /// Volume of the placed copies, mm3.
    pub fn part_volume_mm3(&self, instance: &NestingInstance) -> f64 {
        self.placements.iter().map(|p| instance.items()[p.item].mesh.volume_mm3()).sum()
    }
}
