//! Decides what may be taken: what stood still long enough and is there to its end. Pure: seen + now -> ready.

use std::{io, path::Path};

use super::Seen;

/// How long things must stand still.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SettleRules {
    /// A file must be unchanged so long, seconds.
    pub settle_secs: f64,
    /// A file whose end is missing is taken (to be refused with a reason) after it stood unchanged so long, seconds.
    pub unfinished_secs: f64,
    /// A ticket without its part is refused after so long, seconds.
    pub orphan_secs: f64,
}

impl Default for SettleRules {
    fn default() -> Self {
        Self { settle_secs: 5.0, unfinished_secs: 600.0, orphan_secs: 3600.0 }
    }
}

/// What may be taken out of the hot folder now. It is said again at every scan for as long as the thing stands there.
#[derive(Debug, Clone, PartialEq)]
pub enum Ready {
    /// A part, to be claimed with what belongs to it.
    Part {
        /// The part.
        part: Seen,
        /// Its sidecar tickets (`name.toml`, `name.json`): none or one; two are refused when they are read.
        tickets: Vec<Seen>,
        /// The `order.csv` of its folder.
        list: Option<Seen>,
        /// Whether it stood still for [`SettleRules::unfinished_secs`] without its end: probably truncated.
        unfinished: bool,
    },
    /// An `order.csv` that stands still, for [`end_list`](super::end_list).
    List {
        /// The list.
        list: Seen,
        /// So long nothing changed in its folder, seconds.
        quiet_secs: f64,
    },
    /// No part: to be moved to the error folder by [`refuse_path`](super::refuse_path).
    Refuse {
        /// What stands there.
        seen: Seen,
        /// Why, and what to do, in plain words.
        reason: String,
    },
}

/// Remembers since when each thing in one hot folder has been unchanged.
#[derive(Debug)]
pub struct Settler {
    rules: SettleRules,
}

impl Settler {
    /// Knows nothing yet.
    pub fn new(rules: SettleRules) -> Self {
        Self { rules }
    }

    /// Other rules from now on; what is known is kept.
    pub fn set_rules(&mut self, rules: SettleRules) {
        self.rules = rules;
    }

    /// Takes in a scan made at `now_secs` (of any clock that never runs backwards) and says what may be taken.
    /// `has_end(path, display name)` is asked only for files that otherwise have settled; an error counts as "not yet".
    pub fn observe(
        &mut self,
        _seen: &[Seen],
        _now_secs: f64,
        _has_end: impl FnMut(&Path, &str) -> io::Result<bool>,
    ) -> Vec<Ready> {
        Vec::new()
    }

    /// Seconds until something may be ready that is not yet, if anything is on its way: when to scan next.
    pub fn next_secs(&self, _now_secs: f64) -> Option<f64> {
        None
    }
}
