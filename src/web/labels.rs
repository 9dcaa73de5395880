//! Numbers on a plan: where they would cover each other, or be cut off at the rim, they are put beside.

use glam::DVec2;

/// Width of a digit, of its height.
const DIGIT: f64 = 0.6;
/// Rings of places that are tried around the place of a number.
const RINGS: u32 = 14;

/// A short text on a plan, and what it stands for.
#[derive(Debug, Clone)]
pub(super) struct Label {
    /// The text.
    pub(super) text: String,
    /// The middle of what it names.
    pub(super) of: DVec2,
    /// Its own middle.
    pub(super) at: DVec2,
    half: DVec2,
}

impl Label {
    /// A text in the middle of what it names, so high.
    pub(super) fn new(text: String, of: DVec2, height: f64) -> Self {
        let half = 0.5 * height * DVec2::new(DIGIT * text.len() as f64, 0.8);
        Self { text, of, at: of, half }
    }

    /// Whether it stands beside what it names.
    pub(super) fn is_shifted(&self) -> bool {
        self.at.distance(self.of) > self.half.y
    }

    fn covers(&self, other: &Self) -> bool {
        (self.at - other.at).abs().cmplt(self.half + other.half).all()
    }
}

/// Moves labels until none covers another, as near to their places as can be found, within a plan of this size.
pub(super) fn apart(labels: Vec<Label>, size: DVec2) -> Vec<Label> {
    let mut placed: Vec<Label> = Vec::with_capacity(labels.len());
    for label in labels {
        let put = |offset: DVec2| {
            let at = (label.at + offset).clamp(label.half.min(size * 0.5), (size - label.half).max(size * 0.5));
            Label { at, ..label.clone() }
        };
        let rings = (0..=RINGS).flat_map(|ring| {
            let steps = (6 * ring).max(1);
            (0..steps).map(move |step| (ring, f64::from(step) / f64::from(steps) * std::f64::consts::TAU))
        });
        let mut tried = rings.map(|(ring, angle)| put(f64::from(ring) * 1.3 * label.half.y * DVec2::from_angle(angle)));
        let free = tried.find(|one| !placed.iter().any(|other| one.covers(other)));
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
        let labels = (0..24).map(|n| Label::new((n + 1).to_string(), middles[n % 3], 4.5)).collect();
        let placed = apart(labels, size);
        for (at, one) in placed.iter().enumerate() {
            assert!(one.at.cmpge(one.half).all() && one.at.cmple(size - one.half).all(), "{one:?}");
            assert!(one.at.distance(one.of) < 25.0, "{one:?}");
            assert!(placed[..at].iter().all(|other| !one.covers(other)), "{one:?}");
        }
        let alone = apart(vec![Label::new("7".to_owned(), DVec2::splat(30.0), 4.5)], size);
        assert!(!alone[0].is_shifted());
    }
}
