//! How often copies have to be printed again until all of an order are good. Pure functions of what earlier builds teach.

use ledger::{BuildState, PublishedExperience};

use super::packing_experience::upper_end;
use crate::decisions::print_times::median;

/// A date that is promised is kept with this probability, as far as reprints go.
const KEPT: f64 = 0.95;
/// More rounds than these are not counted.
const MAX_ROUNDS: u32 = 8;
/// More copies than these are counted as so many: some of them is bad in any case.
const MAX_COPIES: usize = 400;
/// What is assumed before anything was told: one of 20 builds fails, ...
const USUAL_FAILED: (f64, f64) = (1.0, 20.0);
/// ... and one of 50 copies is bad.
const USUAL_BAD: (f64, f64) = (2.0, 100.0);
/// With fewer prints, it is not learned how long it takes from the queue to the outcome.
const MIN_TOLD: usize = 5;

/// How prints of a machine turn out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReprintOdds {
    /// Share of builds whose print fails, 0..1.
    pub failed_share: f64,
    /// Share of copies of the other builds that are bad, 0..1.
    pub bad_share: f64,
    /// Hours from the queue to the outcome that 95 % of builds keep to; `None` = too few were told.
    pub turnaround_hours: Option<f64>,
    /// Height of the middle one of the builds, mm; `None` = there is none.
    pub usual_height_mm: Option<f64>,
}

impl ReprintOdds {
    /// What told builds teach, together with what is assumed of a new farm.
    pub fn learn(builds: &[PublishedExperience]) -> Self {
        let is_failed =
            |build: &&PublishedExperience| matches!(build.state, BuildState::Failed | BuildState::Interrupted);
        let complete: Vec<&PublishedExperience> =
            builds.iter().filter(|build| build.state == BuildState::Complete).collect();
        let failed = builds.iter().filter(is_failed).count() as f64;
        let bad: f64 = complete.iter().map(|build| f64::from(build.bad_copies)).sum();
        let copies: f64 = complete.iter().map(|build| f64::from(build.copies)).sum();
        let took =
            |build: &&PublishedExperience| build.state_at.0.duration_since(build.published_at.0).as_secs_f64() / 3600.0;
        let took: Vec<f64> = complete.iter().map(took).collect();
        Self {
            failed_share: (failed + USUAL_FAILED.0) / (failed + complete.len() as f64 + USUAL_FAILED.1),
            bad_share: (bad + USUAL_BAD.0) / (copies + USUAL_BAD.1),
            turnaround_hours: (took.len() >= MIN_TOLD).then(|| upper_end(took)),
            usual_height_mm: median(builds.iter().map(|build| build.height_mm).collect()),
        }
    }

    /// The number of rounds of printing after which all copies are good with 95 %, if each round prints those again that
    /// were bad in the one before.
    pub fn rounds_needed(&self, copies: u32) -> u32 {
        let copies = (copies as usize).min(MAX_COPIES);
        // Probability that so many copies are all good after the rounds so far.
        let mut done = vec![0.0; copies + 1];
        done[0] = 1.0;
        for round in 1..MAX_ROUNDS {
            done = (0..=copies).map(|n| self.after_round(n, &done)).collect();
            if done[copies] >= KEPT {
                return round;
            }
        }
        MAX_ROUNDS
    }

    /// The probability that `n` copies are all good after one more round than those that `done` is for.
    fn after_round(&self, n: usize, done: &[f64]) -> f64 {
        let (good, bad) = (1.0 - self.bad_share, self.bad_share);
        // Probability that exactly `k` of them are bad, from k = 0 on.
        let (mut exactly, mut sum) = (good.powi(i32::try_from(n).unwrap_or(i32::MAX)), 0.0);
        for (k, after) in done.iter().enumerate().take(n + 1) {
            sum += exactly * after;
            exactly *= (n - k) as f64 / (k + 1) as f64 * bad / good;
        }
        (1.0 - self.failed_share) * sum + self.failed_share * done[n]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn odds(failed_share: f64, bad_share: f64) -> ReprintOdds {
        ReprintOdds { failed_share, bad_share, turnaround_hours: None, usual_height_mm: None }
    }

    #[test]
    fn the_more_copies_and_the_more_failures_the_more_rounds() {
        assert_eq!(odds(0.0, 0.0).rounds_needed(100), 1);
        assert_eq!(odds(0.04, 0.0).rounds_needed(100), 1);
        assert_eq!(odds(0.1, 0.0).rounds_needed(1), 2);
        // 0.98 ^ 2 = 0.96, 0.98 ^ 3 = 0.94.
        assert_eq!((odds(0.0, 0.02).rounds_needed(2), odds(0.0, 0.02).rounds_needed(3)), (1, 2));
        // Of 100 copies, 2 are bad on average: the second round prints them well with 96 %.
        assert_eq!(odds(0.0, 0.02).rounds_needed(100), 2);
        assert_eq!(odds(0.05, 0.02).rounds_needed(100), 3);
        assert_eq!(odds(0.9, 0.5).rounds_needed(1000), MAX_ROUNDS);
    }

    #[test]
    fn two_rounds_of_two_copies_as_counted_by_hand() {
        let (failed, bad) = (0.1_f64, 0.2_f64);
        let one_round = |n: i32| (1.0 - failed) * (1.0 - bad).powi(n);
        let by_hand = (1.0 - failed)
            * ((1.0 - bad).powi(2) + 2.0 * bad * (1.0 - bad) * one_round(1) + bad * bad * one_round(2))
            + failed * one_round(2);
        let odds = odds(failed, bad);
        let first: Vec<f64> = [1.0, one_round(1), one_round(2)].to_vec();
        assert!((odds.after_round(2, &first) - by_hand).abs() < 1e-12);
        assert!((odds.after_round(2, &[1.0, 0.0, 0.0]) - first[2]).abs() < 1e-12);
    }
}
