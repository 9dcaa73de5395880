//! Layer thickness of a machine, and the greatest area that a layer may fill.

use serde::{Deserialize, Serialize};

use crate::BuildVolume;

/// Layer thickness where none is configured, mm.
pub const DEFAULT_LAYER_MM: f64 = 0.1;

/// Layer thickness, and the greatest area that a layer may fill.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "WrittenCap", into = "WrittenCap")]
pub struct LayerAreaCap {
    /// Thickness of a layer, mm; layers are counted from the floor of the build volume.
    pub layer_mm: f64,
    /// Greatest filled area of any layer, mm2; infinite = no cap.
    pub area_mm2: f64,
}

impl LayerAreaCap {
    /// A cap given as a share of the base area of a build volume; `None` = no cap.
    pub fn from_share(layer_mm: f64, share: Option<f64>, volume: &BuildVolume) -> Self {
        let base_mm2 = volume.size_mm.x * volume.size_mm.y;
        Self { layer_mm, area_mm2: share.map_or(f64::INFINITY, |share| share * base_mm2) }
    }

    /// Greatest filled area of a layer, mm2; `None` = no limit.
    pub fn cap_mm2(&self) -> Option<f64> {
        self.area_mm2.is_finite().then_some(self.area_mm2)
    }
}

impl Default for LayerAreaCap {
    fn default() -> Self {
        Self { layer_mm: DEFAULT_LAYER_MM, area_mm2: f64::INFINITY }
    }
}

/// As files hold it: there is no infinite number in JSON.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenCap {
    layer_mm: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    area_mm2: Option<f64>,
}

impl From<WrittenCap> for LayerAreaCap {
    fn from(written: WrittenCap) -> Self {
        Self { layer_mm: written.layer_mm, area_mm2: written.area_mm2.unwrap_or(f64::INFINITY) }
    }
}

impl From<LayerAreaCap> for WrittenCap {
    fn from(cap: LayerAreaCap) -> Self {
        Self { layer_mm: cap.layer_mm, area_mm2: cap.cap_mm2() }
    }
}
