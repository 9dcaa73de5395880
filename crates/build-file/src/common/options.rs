//! Options of the build file, since printers differ.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::decimal::step_of;

/// What a build is delivered as: what the software of printers opens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DeliveryKind {
    /// A 3MF in which all copies of a mesh share one object.
    #[default]
    Shared,
    /// A 3MF in which each copy is an object of its own, in its place: for readers that ignore transforms or shared objects.
    Expanded,
    /// One binary STL with all copies in their places.
    Stl,
    /// A ZIP of one binary STL for each part, with a table of the places of its copies.
    Parts,
}

impl DeliveryKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Shared, Self::Expanded, Self::Stl, Self::Parts];

    /// The ending of the name of such a file.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Shared | Self::Expanded => ".build.3mf",
            Self::Stl => ".build.stl",
            Self::Parts => ".build.zip",
        }
    }

    /// As settings spell it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shared => "shared",
            Self::Expanded => "expanded",
            Self::Stl => "stl",
            Self::Parts => "parts",
        }
    }

    /// What people and programs call the format of such a file: its short name, and its media type.
    pub fn format(self) -> (&'static str, &'static str) {
        match self {
            Self::Shared | Self::Expanded => ("3MF", "model/3mf"),
            Self::Stl => ("STL", "model/stl"),
            Self::Parts => ("ZIP", "application/zip"),
        }
    }

    /// The kind of a build file with this name, as far as its ending tells.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| name.ends_with(kind.ending()))
    }

    /// Whether coordinates are written as 32-bit numbers.
    pub fn is_rounded(self) -> bool {
        matches!(self, Self::Stl | Self::Parts)
    }

    /// Distance that a layout needs beside its clearance, at walls as well, so that it keeps it when it is written and read back: the
    /// farthest that rounding moves two points towards each other. `volume_mm` = the edges of the printable box.
    pub fn rounding_mm(self, volume_mm: DVec3) -> f64 {
        let reach_mm = volume_mm.max_element().max(MAX_PART_REACH_MM);
        if self.is_rounded() { 3_f64.sqrt() * step_of(reach_mm) } else { 0.0 }
    }
}

/// The corners of a part's own STL are at most so far from its origin, mm, unless it is larger.
pub(crate) const MAX_PART_REACH_MM: f64 = 512.0;

/// Whether a consumer may rearrange the placements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Arrangement {
    /// One build item per placement.
    #[default]
    Items,
    /// One object made of components, which a consumer must not move relative to each other.
    Locked,
}
