//! Reserved zones of a machine: boxes in which nothing may stand.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use solids::Bounds;

use super::judge::Judge;

/// A box of the machine in which nothing may stand, mm in the machine's frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeepOut {
    /// Least corner, mm.
    pub min: DVec3,
    /// Greatest corner, mm.
    pub max: DVec3,
}

impl KeepOut {
    /// As bounds in the machine's frame, mm.
    pub fn bounds(&self) -> Bounds {
        Bounds { min: self.min, max: self.max }
    }
}

/// Objects to boxes that are none, and to those that keep nothing free because they lie outside the machine.
pub(super) fn judge(keep_out: &[KeepOut], volume_mm: Option<[f64; 3]>, judge: &mut Judge) {
    for (number, zone) in (1..).zip(keep_out) {
        let is_box = zone.min.is_finite() && zone.max.is_finite() && zone.min.cmplt(zone.max).all();
        if !is_box {
            let text = format!("keep_out: box {number} from {} to {} is not a box", zone.min, zone.max);
            judge.object(
                "keep_out",
                text,
                "give each box a min and a max in mm, every number of min below that of max",
            );
        } else if let Some(edges_mm) = volume_mm
            && (zone.max.cmple(DVec3::ZERO).any() || zone.min.cmpge(edges_mm.into()).any())
        {
            let text = format!("keep_out: box {number} from {} to {} lies outside volume_mm", zone.min, zone.max);
            judge.object(
                "keep_out",
                text,
                "give it in the machine's frame, whose origin is its lower front left corner",
            );
        }
    }
}
