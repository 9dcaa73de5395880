//! The time budget of a section.

use std::time::Instant;

/// The time of one section.
#[derive(Debug)]
pub struct SectionBudget {
    /// Wall seconds for the section; it may end earlier, and should not end much later.
    pub secs: f64,
    /// A long run tries as much as its time allows; a short one only shows within seconds that the section works.
    pub is_long: bool,
    began: Instant,
}

#[allow(dead_code)] // no section uses all of it
impl SectionBudget {
    /// A budget of a run inside `cargo test`.
    pub fn short(secs: f64) -> Self {
        Self { secs, is_long: false, began: Instant::now() }
    }

    /// A budget of a run of its own.
    pub fn long(secs: f64) -> Self {
        Self { secs, is_long: true, began: Instant::now() }
    }

    /// The same budget with at least `secs` seconds.
    pub fn at_least(&self, secs: f64) -> Self {
        Self { secs: self.secs.max(secs), ..*self }
    }

    /// Remaining seconds; never below zero.
    pub fn left_secs(&self) -> f64 {
        (self.secs - self.began.elapsed().as_secs_f64()).max(0.0)
    }

    /// Whether the time is over.
    pub fn is_spent(&self) -> bool {
        self.left_secs() <= 0.0
    }

    /// `short` in a short run, `long` in a long one.
    pub fn pick<T>(&self, short: T, long: T) -> T {
        if self.is_long { long } else { short }
    }
}
