//! Parameters of the published method, each with its default. The settings read them from TOML.

use serde::{Deserialize, Serialize};

/// Parameters of the published method: "Nesting of 3D irregular shaped objects applied to powder-based additive
/// manufacturing" (Springer, 2021), sections 2.1, 2.3 and 3.1. Section and equation numbers are those of the paper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PaperConfig {
    /// Flowers per part (not specified in the paper; 200 was the strongest value tried).
    pub population: usize,
    /// FPA iterations per part (not specified in the paper).
    pub iterations: usize,
    /// Switching probability p between global and local pollination.
    pub switch_probability: f64,
    /// Scaling factor gamma of a global step, equation (1).
    pub scale: f64,
    /// Exponent lambda of the Levy flight, equation (2).
    pub levy_exponent: f64,
    /// Whether the tree stops subdividing boxes at the size of the clearance (section 2.2.4).
    pub reduce_tree: bool,
    /// Stop when the print height is at most this, mm; 0 = off.
    pub target_height_mm: f64,
    /// Stop after this number of outer iterations (whole layouts); 0 = off.
    pub max_layouts: u64,
    /// Stop when the relative height error between two outer iterations, equation (10), is at most this share; 0 = off.
    pub relative_height_error: f64,
}

impl Default for PaperConfig {
    fn default() -> Self {
        Self {
            population: 200,
            iterations: 300,
            switch_probability: 0.2,
            scale: 0.1,
            levy_exponent: 1.5,
            reduce_tree: true,
            target_height_mm: 0.0,
            max_layouts: 0,
            relative_height_error: 0.0,
        }
    }
}
