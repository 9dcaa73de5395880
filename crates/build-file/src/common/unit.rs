//! Units of length of a file.

use serde::{Deserialize, Serialize};

/// A unit of length; the names are those of 3MF.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LengthUnit {
    /// 0.001 mm.
    Micron,
    /// 1 mm.
    #[default]
    #[serde(alias = "mm")]
    Millimeter,
    /// 10 mm.
    #[serde(alias = "cm")]
    Centimeter,
    /// 25.4 mm.
    #[serde(alias = "in")]
    Inch,
    /// 304.8 mm.
    #[serde(alias = "ft")]
    Foot,
    /// 1000 mm.
    #[serde(alias = "m")]
    Meter,
}

impl LengthUnit {
    /// Millimetres in one unit.
    pub fn mm_per_unit(self) -> f64 {
        match self {
            Self::Micron => 0.001,
            Self::Millimeter => 1.0,
            Self::Centimeter => 10.0,
            Self::Inch => 25.4,
            Self::Foot => 304.8,
            Self::Meter => 1000.0,
        }
    }
}
