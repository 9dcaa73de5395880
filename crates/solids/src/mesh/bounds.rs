//! Axis-aligned bounds.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// An axis-aligned box, in mm. Empty bounds have `min > max`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Least corner, mm.
    pub min: DVec3,
    /// Greatest corner, mm.
    pub max: DVec3,
}

impl Bounds {
    /// Empty bounds; adding a point makes them that point.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The least bounds around `points`.
    pub fn from_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points
            .into_iter()
            .fold(Self::EMPTY, |bounds, point| Self { min: bounds.min.min(point), max: bounds.max.max(point) })
    }

    /// Edge lengths, mm.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// The middle, mm.
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// Least distance between two boxes, mm; 0 when they touch or overlap.
    pub fn distance(&self, other: &Self) -> f64 {
        (other.min - self.max).max(self.min - other.max).max(DVec3::ZERO).length()
    }

    /// Whether `other` lies wholly inside, with a margin of `slack` mm on every side (negative: it may stand out by
    /// that much).
    pub fn contains_bounds(&self, other: &Self, slack: f64) -> bool {
        other.min.cmpge(self.min + slack).all() && other.max.cmple(self.max - slack).all()
    }
}
