//! Reserved zones of a machine: boxes in which no part may be placed.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use solids::Bounds;

use crate::reading::validator::ConfigValidator;

/// A box in which no part may be placed, mm in the machine's frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeepOutZone {
    /// Corner with the smallest coordinates, mm.
    pub min: DVec3,
    /// Corner with the largest coordinates, mm.
    pub max: DVec3,
}

impl KeepOutZone {
    /// The box as bounds in the machine's frame, mm.
    pub fn bounds(&self) -> Bounds {
        Bounds { min: self.min, max: self.max }
    }
}

/// Reports invalid boxes and boxes outside the machine, which have no effect.
pub(crate) fn validate_zones(keep_out: &[KeepOutZone], volume_mm: Option<[f64; 3]>, validator: &mut ConfigValidator) {
    for (number, zone) in (1..).zip(keep_out) {
        let is_box = zone.min.is_finite() && zone.max.is_finite() && zone.min.cmplt(zone.max).all();
        if !is_box {
            let text = format!("keep_out: box {number} from {} to {} is not a box", zone.min, zone.max);
            validator.report_problem(
                "keep_out",
                text,
                "give each box a min and a max in mm, every number of min below that of max",
            );
        } else if let Some(edges_mm) = volume_mm
            && (zone.max.cmple(DVec3::ZERO).any() || zone.min.cmpge(edges_mm.into()).any())
        {
            let text = format!("keep_out: box {number} from {} to {} lies outside volume_mm", zone.min, zone.max);
            validator.report_problem(
                "keep_out",
                text,
                "give it in the machine's frame, whose origin is its lower front left corner",
            );
        }
    }
}
