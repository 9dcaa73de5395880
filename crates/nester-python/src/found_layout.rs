//! What a search leaves: the layout, and what it was made of.

use nester::{NestingConfig, NestingInstance, NestingSolution};

use crate::request::ItemSource;

/// A layout with all that is needed to prove, draw and write it.
pub(crate) struct FoundLayout {
    pub(crate) instance: NestingInstance,
    pub(crate) config: NestingConfig,
    pub(crate) solution: NestingSolution,
    /// Where each item comes from.
    pub(crate) sources: Vec<ItemSource>,
    /// A height that no layout of all copies can beat, mm.
    pub(crate) lower_bound_mm: f64,
    /// (wall seconds, height in mm) of every better layout with as many copies as this one.
    pub(crate) heights: Vec<(f64, f64)>,
    /// Wall seconds of the search.
    pub(crate) secs: f64,
    /// Why the search ended, in words.
    pub(crate) ended: String,
}
