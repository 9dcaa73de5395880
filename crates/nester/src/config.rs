//! Parameters of the search, each with its default; `settings` reads them from TOML.

use serde::{Deserialize, Serialize};

use super::Organs;

/// Which search nests a build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Our own search, the default.
    #[default]
    Nestd,
    /// The published method, faithful: FPA one part after the other with OBB trees as collision test.
    Paper,
}

/// What becomes of parts that are locked into each other: that cannot be drawn out of the finished build one after the other
/// along straight lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Interlock {
    /// No layout with a locked part counts; the search keeps clear of them. The published method knows nothing of it and
    /// only warns.
    #[default]
    Forbid,
    /// Locked parts are told.
    Warn,
    /// Nobody looks.
    Allow,
}

impl Interlock {
    /// As settings and build files spell it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Forbid => "forbid",
            Self::Warn => "warn",
            Self::Allow => "allow",
        }
    }
}

/// Everything that steers the search but the instance and the budget.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Which search.
    pub method: Method,
    /// Seed of every random choice: same seed, threads and evaluation budget give the same build.
    pub seed: u64,
    /// Threads to search with; part of what makes a build repeatable. 0 = one per core.
    pub threads: usize,
    /// What becomes of parts that are locked into each other.
    pub interlock: Interlock,
    /// Parameters of the paper's method.
    pub paper: PaperConfig,
    /// Which organs of our own search take part; for benches, not for configuration files.
    #[serde(skip)]
    pub organs: Organs,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            method: Method::Nestd,
            seed: 1,
            threads: 1,
            interlock: Interlock::default(),
            paper: PaperConfig::default(),
            organs: Organs::default(),
        }
    }
}

impl Config {
    /// What becomes of locked parts when all is said: the published method cannot forbid them, so there they are told.
    pub fn interlock(&self) -> Interlock {
        match (self.method, self.interlock) {
            (Method::Paper, Interlock::Forbid) => Interlock::Warn,
            (_, interlock) => interlock,
        }
    }
}

/// Parameters of the paper's method (its sections 2.1, 2.3 and 3.1).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PaperConfig {
    /// Flowers per part (the paper leaves it open; 200 was the strongest of those tried).
    pub population: usize,
    /// FPA iterations per part (the paper leaves it open).
    pub iterations: usize,
    /// Switching probability p between global and local pollination.
    pub switch_probability: f64,
    /// Scaling factor gamma of a global step, equation (1).
    pub scale: f64,
    /// Exponent lambda of the Levy flight, equation (2).
    pub levy_exponent: f64,
    /// Whether leaves stop subdividing at the clearance (section 2.2.4).
    pub reduce_tree: bool,
    /// Stop when the print height is at most this, mm; 0 = off.
    pub target_height_mm: f64,
    /// Stop after so many outer iterations (whole layouts); 0 = off.
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
