//! Parameters of the search, each with its default; `settings` reads them from TOML.

use serde::{Deserialize, Serialize};

use super::Organs;
#[cfg(feature = "paper")]
use super::PaperConfig;

/// Which search nests a build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Our own search, the default.
    #[default]
    Nestd,
    /// The published method, faithful: FPA one part after the other with OBB trees as collision test. Its parameters and where
    /// it was published: [`PaperConfig`].
    #[cfg(feature = "paper")]
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
///
/// ```
/// use nester::{Config, Interlock};
///
/// let config = Config { seed: 7, threads: 2, interlock: Interlock::Warn, ..Config::default() };
/// assert_eq!(config.interlock().word(), "warn");
/// ```
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
    #[cfg(feature = "paper")]
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
            #[cfg(feature = "paper")]
            paper: PaperConfig::default(),
            organs: Organs::default(),
        }
    }
}

impl Config {
    /// What becomes of locked parts when all is said: the published method cannot forbid them, so there they are told.
    pub fn interlock(&self) -> Interlock {
        match (self.method, self.interlock) {
            #[cfg(feature = "paper")]
            (Method::Paper, Interlock::Forbid) => Interlock::Warn,
            (_, interlock) => interlock,
        }
    }
}
