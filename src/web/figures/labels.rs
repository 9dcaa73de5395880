//! Places the numbers on a plan. A number that would overlap another one, or be cut off at the edge, is moved aside.

use glam::DVec2;

/// Width of a digit as a share of its height.
const DIGIT_WIDTH: f64 = 0.6;
/// Rings of candidate positions around the original position of a number.
const MAX_RINGS: u32 = 14;

/// A short text on a plan, with the position of what it names.
#[derive(Debug, Clone)]
pub(crate) struct PlanLabel {
    /// The text.
    pub(crate) text: String,
    /// The center of what it names.
    pub(crate) target: DVec2,
    /// The center of the text itself.
    pub(crate) center: DVec2,
    half_size: DVec2,
}

impl PlanLabel {
    /// A text of a given height, centered on what it names.
    pub(crate) fn new(text: String, of: DVec2, height: f64) -> Self {
        let half = 0.5 * height * DVec2::new(DIGIT_WIDTH * text.len() as f64, 0.8);
        Self { text, target: of, center: of, half_size: half }
    }

    /// Whether the text was moved away from what it names.
    pub(super) fn is_shifted(&self) -> bool {
        self.center.distance(self.target) > self.half_size.y
    }

    fn overlaps(&self, other: &Self) -> bool {
        (self.center - other.center).abs().cmplt(self.half_size + other.half_size).all()
    }
}

/// Moves labels until none overlaps another, each to the nearest free position within a plan of this size.
pub(super) fn separate_labels(labels: Vec<PlanLabel>, size: DVec2) -> Vec<PlanLabel> {
    let mut placed: Vec<PlanLabel> = Vec::with_capacity(labels.len());
    for label in labels {
        let put = |offset: DVec2| {
            let at = (label.center + offset)
                .clamp(label.half_size.min(size * 0.5), (size - label.half_size).max(size * 0.5));
            PlanLabel { center: at, ..label.clone() }
        };
        let rings = (0..=MAX_RINGS).flat_map(|ring| {
            let steps = (6 * ring).max(1);
            (0..steps).map(move |step| (ring, f64::from(step) / f64::from(steps) * std::f64::consts::TAU))
        });
        let mut tried =
            rings.map(|(ring, angle)| put(f64::from(ring) * 1.3 * label.half_size.y * DVec2::from_angle(angle)));
        let free = tried.find(|one| !placed.iter().any(|other| one.overlaps(other)));
        placed.push(free.unwrap_or_else(|| put(DVec2::ZERO)));
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_would_cover_each_other_stand_side_by_side_and_inside() {
        let size = DVec2::splat(100.0);
        let middles = [DVec2::ZERO, DVec2::splat(50.0), DVec2::splat(100.0)];
        let labels = (0..24).map(|n| PlanLabel::new((n + 1).to_string(), middles[n % 3], 4.5)).collect();
        let placed = separate_labels(labels, size);
        for (at, one) in placed.iter().enumerate() {
            assert!(one.center.cmpge(one.half_size).all() && one.center.cmple(size - one.half_size).all(), "{one:?}");
            assert!(one.center.distance(one.target) < 25.0, "{one:?}");
            assert!(placed[..at].iter().all(|other| !one.overlaps(other)), "{one:?}");
        }
        let alone = separate_labels(vec![PlanLabel::new("7".to_owned(), DVec2::splat(30.0), 4.5)], size);
        assert!(!alone[0].is_shifted());
    }
}
