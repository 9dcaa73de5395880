//! Parameters of the search with their defaults. The `settings` module reads them from TOML.

use serde::{Deserialize, Serialize};

#[cfg(feature = "paper")]
use crate::PaperConfig;
use crate::SearchComponents;

/// The search method that nests a build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NestingMethod {
    /// This project's own search, the default.
    #[default]
    Nestd,
    /// The published method, implemented faithfully: FPA (flower pollination algorithm), one part after the other, with
    /// OBB trees as the collision test. Its parameters and where
    /// it was published: [`PaperConfig`].
    #[cfg(feature = "paper")]
    Paper,
}

/// How to treat interlocked parts: parts that cannot be removed from the finished build one after the other along
/// straight lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InterlockRule {
    /// A layout with a locked part is not valid, and the search avoids such layouts. The published method does not
    /// support this rule and only warns.
    #[default]
    Forbid,
    /// Locked parts are reported.
    Warn,
    /// Interlocking is not checked.
    Allow,
}

impl InterlockRule {
    /// The spelling in settings and build files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Forbid => "forbid",
            Self::Warn => "warn",
            Self::Allow => "allow",
        }
    }
}

/// All search parameters except the instance and the budget.
///
/// ```
/// use nester::{NestingConfig, InterlockRule};
///
/// let config = NestingConfig { seed: 7, threads: 2, interlock: InterlockRule::Warn, ..NestingConfig::default() };
/// assert_eq!(config.effective_interlock().as_str(), "warn");
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NestingConfig {
    /// Search method.
    pub method: NestingMethod,
    /// Seed of every random choice: the same seed, number of lanes and evaluation budget give the same build.
    pub seed: u64,
    /// Number of search threads. 0 = one per core.
    pub threads: usize,
    /// Number of lanes: searches side by side that exchange their layouts; all of them share the budget. It affects the
    /// result; the number of threads does not. 0 = one per thread.
    pub lanes: usize,
    /// How to treat interlocked parts.
    pub interlock: InterlockRule,
    /// Parameters of the paper's method.
    #[cfg(feature = "paper")]
    pub paper: PaperConfig,
    /// Enabled components of our own search. For benches, not for configuration files.
    #[serde(skip)]
    pub components: SearchComponents,
}

impl Default for NestingConfig {
    fn default() -> Self {
        Self {
            method: NestingMethod::Nestd,
            seed: 1,
            threads: 1,
            lanes: 0,
            interlock: InterlockRule::default(),
            #[cfg(feature = "paper")]
            paper: PaperConfig::default(),
            components: SearchComponents::default(),
        }
    }
}

impl NestingConfig {
    /// The number of search threads.
    pub fn thread_count(&self) -> usize {
        match self.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        }
    }

    /// The number of lanes.
    pub fn lane_count(&self) -> usize {
        if self.lanes == 0 { self.thread_count() } else { self.lanes }
    }

    /// The interlock rule that is actually applied: the published method cannot forbid locked parts, so it reports them
    /// instead.
    pub fn effective_interlock(&self) -> InterlockRule {
        match (self.method, self.interlock) {
            #[cfg(feature = "paper")]
            (NestingMethod::Paper, InterlockRule::Forbid) => InterlockRule::Warn,
            (_, interlock) => interlock,
        }
    }
}
