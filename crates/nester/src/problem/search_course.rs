//! The course of a search, for people and programs: the height over time, and why it ended.

use crate::NestingSolution;

/// Seconds without a gain that are worth a word.
const LONG_IDLE_SECS: f64 = 10.0;

/// Why a search ended.
///
/// ```
/// use nester::{SearchBudget, SearchEnd};
///
/// let budget = SearchBudget::of_secs(60.0);
/// budget.cancel();
/// assert_eq!(budget.why_ended(false), SearchEnd::Stopped);
/// assert_eq!(budget.why_ended(true).in_words(), "no lower layout exists");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SearchEnd {
    /// The layout has the height of the lower bound.
    Lowest,
    /// Nothing was gained for as long as the budget's patience.
    Stalled {
        /// The patience, seconds.
        secs: f64,
    },
    /// The time or the evaluations are used up.
    Used {
        /// Seconds without a gain at the end.
        idle_secs: f64,
    },
    /// It was cancelled.
    Stopped,
    /// It ended long before its budget.
    Exhausted,
}

impl SearchEnd {
    /// The reason as a part of a sentence.
    pub fn in_words(&self) -> String {
        match *self {
            Self::Lowest => "no lower layout exists".to_owned(),
            Self::Stalled { secs } => format!("nothing gained for {secs:.0} s"),
            Self::Used { idle_secs } if idle_secs >= LONG_IDLE_SECS => {
                format!("budget used up, nothing gained for {idle_secs:.0} s")
            }
            Self::Used { .. } => "budget used up".to_owned(),
            Self::Stopped => "stopped".to_owned(),
            Self::Exhausted => "nothing more to try".to_owned(),
        }
    }
}

/// The height over time. Heights of different numbers of copies cannot be compared, so it begins anew when a layout has
/// another number of copies than the one before.
#[derive(Debug, Clone, Default)]
pub struct HeightCurve {
    copies: usize,
    /// (seconds, height in mm) of every improvement with the last number of copies.
    pub points: Vec<(f64, f64)>,
}

impl HeightCurve {
    /// Adds a layout found after `secs`. Returns whether anything was gained: other copies, or a lower height.
    pub fn add(&mut self, solution: &NestingSolution, secs: f64) -> bool {
        if solution.placements.len() != self.copies {
            self.copies = solution.placements.len();
            self.points.clear();
        }
        let is_gain = self.points.last().is_none_or(|(_, height_mm)| solution.height_mm < *height_mm);
        if is_gain {
            self.points.push((secs, solution.height_mm));
        }
        is_gain
    }
}

#[cfg(test)]
mod tests {
    use solids::Pose;

    use super::*;
    use crate::ItemPlacement;

    #[test]
    fn a_curve_is_that_of_one_number_of_copies() {
        let mut curve = HeightCurve::default();
        let mut add = |copies: u32, height_mm: f64, secs: f64| {
            let placements = (0..copies).map(|copy| ItemPlacement { item: 0, copy, pose: Pose::IDENTITY }).collect();
            let gained =
                curve.add(&NestingSolution { placements, unplaced: Vec::new(), height_mm, evaluations: 0 }, secs);
            (gained, curve.points.clone())
        };
        assert_eq!(add(2, 30.0, 1.0), (true, vec![(1.0, 30.0)]));
        assert_eq!(add(2, 30.0, 2.0), (false, vec![(1.0, 30.0)]), "as high as before");
        assert_eq!(add(2, 29.0, 3.0), (true, vec![(1.0, 30.0), (3.0, 29.0)]));
        assert_eq!(add(3, 45.0, 4.0), (true, vec![(4.0, 45.0)]));
        assert_eq!(add(3, 44.0, 5.0), (true, vec![(4.0, 45.0), (5.0, 44.0)]));
    }

    #[test]
    fn a_long_time_without_a_gain_is_told() {
        let used = |idle_secs| SearchEnd::Used { idle_secs }.in_words();
        assert_eq!(
            (used(9.0), used(40.4)),
            ("budget used up".into(), "budget used up, nothing gained for 40 s".into())
        );
        assert_eq!(SearchEnd::Stalled { secs: 40.0 }.in_words(), "nothing gained for 40 s");
    }
}
