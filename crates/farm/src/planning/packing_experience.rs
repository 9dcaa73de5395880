//! How high parts stand that are not nested yet: from the volume of the parts, as earlier builds of the machine teach. The slope
//! is the median of all slopes between two builds (P. K. Sen, "Estimates of the regression coefficient based on Kendall's
//! tau", 1968).

use ledger::PublishedExperience;
use settings::MachineProfile;

use crate::decisions::print_times::median;

/// Newest builds that are learned from.
pub const LEARN_FROM: u32 = 60;
/// With fewer builds, the usual density counts.
const MIN_BUILDS: usize = 5;
/// Density of a build of which nothing is known: what powder-bed builds of mixed parts usually have.
const USUAL_DENSITY: f64 = 0.1;
/// No slope is learned that means a density outside of these.
const DENSITIES: (f64, f64) = (0.01, 0.6);
/// Builds whose heights would differ by less at the usual density, mm, say nothing of the slope.
const MIN_SPREAD_MM: f64 = 10.0;
/// A height that is not learned yet may be exceeded by this share.
const USUAL_SPREAD: f64 = 0.15;

/// The height of builds by the volume of their parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PackingExperience {
    /// Height of a build of very little volume, mm.
    pub base_mm: f64,
    /// Height per volume of the parts, mm per mm3.
    pub mm_per_mm3: f64,
    /// 95 % of builds exceed their estimate by this share at most.
    pub spread: f64,
    /// Number of builds that this was learned from; 0 = it is the usual density.
    pub learned_from: usize,
}

impl PackingExperience {
    /// What the builds of a machine teach, the newest first.
    pub fn learn(profile: &MachineProfile, builds: &[PublishedExperience]) -> Self {
        let size_mm = profile.build_volume().size_mm;
        let area_mm2 = size_mm.x * size_mm.y;
        let slope_at = |density: f64| 1.0 / (area_mm2 * density);
        let usual = slope_at(USUAL_DENSITY);
        if builds.len() < MIN_BUILDS {
            return Self { base_mm: 0.0, mm_per_mm3: usual, spread: USUAL_SPREAD, learned_from: 0 };
        }
        let pairs = builds.iter().enumerate().flat_map(|(at, one)| builds[..at].iter().map(move |other| (one, other)));
        let rise = |(one, other): (&PublishedExperience, &PublishedExperience)| {
            (one.part_volume_mm3 - other.part_volume_mm3, one.height_mm - other.height_mm)
        };
        let slopes = pairs.map(rise).filter(|(volume_mm3, _)| volume_mm3.abs() * usual >= MIN_SPREAD_MM);
        let slopes: Vec<f64> = slopes.map(|(volume_mm3, height_mm)| height_mm / volume_mm3).collect();
        let share = |build: &PublishedExperience| build.height_mm / build.part_volume_mm3.max(1e-9);
        let slope = if slopes.len() < MIN_BUILDS { None } else { median(slopes) };
        let slope = slope.or_else(|| median(builds.iter().map(share).collect())).unwrap_or(usual);
        let mm_per_mm3 = slope.clamp(slope_at(DENSITIES.1), slope_at(DENSITIES.0));
        let rest = builds.iter().map(|build| build.height_mm - mm_per_mm3 * build.part_volume_mm3).collect();
        let base_mm = median(rest).unwrap_or(0.0).max(0.0);
        let guess = Self { base_mm, mm_per_mm3, spread: 0.0, learned_from: builds.len() };
        let over = builds.iter().map(|build| build.height_mm / guess.height_mm(build.part_volume_mm3, 0.0) - 1.0);
        Self { spread: upper_end(over.collect()).max(0.0), ..guess }
    }

    /// Height of a build of parts of this volume, of which the largest needs this height at least, mm.
    pub fn height_mm(&self, volume_mm3: f64, least_mm: f64) -> f64 {
        (self.base_mm + self.mm_per_mm3 * volume_mm3).max(least_mm)
    }

    /// The same for what is added to a layout of this volume that stands this high.
    #[must_use]
    pub fn through(&self, volume_mm3: f64, height_mm: f64) -> Self {
        let factor = height_mm / self.height_mm(volume_mm3, 1e-9).max(1e-9);
        Self { base_mm: factor * self.base_mm, mm_per_mm3: factor * self.mm_per_mm3, ..*self }
    }
}

/// The value that 95 % of values do not exceed; 0 for none.
pub fn upper_end(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let place = (0.95 * values.len() as f64).ceil() as usize;
    values.get(place.saturating_sub(1)).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use ledger::{BuildId, BuildState};

    use super::*;
    use crate::decisions::trigger::tests::machine_with_triggers;

    fn builds(measures: &[(f64, f64)]) -> Vec<PublishedExperience> {
        let build = |&(part_volume_mm3, height_mm): &(f64, f64)| PublishedExperience {
            build: BuildId(1),
            state: BuildState::Complete,
            height_mm,
            part_volume_mm3,
            copies: 1,
            bad_copies: 0,
            published_at: jiff::Timestamp::UNIX_EPOCH.into(),
            state_at: jiff::Timestamp::UNIX_EPOCH.into(),
        };
        measures.iter().map(build).collect()
    }

    #[test]
    fn the_height_of_a_volume_is_learned_from_builds_and_one_of_tall_parts_does_not_count_much() {
        // 100 x 100 mm: 1e5 mm3 at a fifth of the volume stand 50 mm high.
        let profile = machine_with_triggers("");
        let few = PackingExperience::learn(&profile, &builds(&[(1e5, 50.0); 4]));
        assert_eq!((few.learned_from, few.height_mm(1e5, 0.0).round()), (0, 100.0));
        let mut measured: Vec<(f64, f64)> = (1..10).map(|n| (2e4 * f64::from(n), 10.0 + 10.0 * f64::from(n))).collect();
        measured.push((1e4, 95.0));
        let learned = PackingExperience::learn(&profile, &builds(&measured));
        assert!(
            (learned.base_mm - 10.0).abs() < 1e-6 && (learned.height_mm(1e5, 0.0) - 60.0).abs() < 1e-6,
            "{learned:?}"
        );
        assert_eq!(learned.height_mm(1e3, 70.0), 70.0, "the largest part needs that");
        assert!(learned.spread > 1.0, "one of ten was far off: {learned:?}");
        // Builds of one volume teach a density.
        let alike = PackingExperience::learn(&profile, &builds(&[(1e5, 50.0); 8]));
        assert!((alike.height_mm(1e5, 0.0) - 50.0).abs() < 1e-6 && alike.spread < 1e-6, "{alike:?}");
    }

    #[test]
    fn what_is_added_to_a_layout_goes_on_from_its_height() {
        let profile = machine_with_triggers("");
        let through = PackingExperience::learn(&profile, &[]).through(1e5, 40.0);
        assert!((through.height_mm(1e5, 0.0) - 40.0).abs() < 1e-9 && (through.height_mm(2e5, 0.0) - 80.0).abs() < 1e-9);
    }
}
