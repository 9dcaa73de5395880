//! How long a print occupies a printer: from the machine's settings, and from the prints whose begin and end are known. The
//! slope over the height is the median of all slopes between two prints (P. K. Sen, "Estimates of the regression
//! coefficient based on Kendall's tau", 1968), so that one print that lay over a weekend does not count much.

use jiff::{SignedDuration, Timestamp};
use ledger::ToldPrint;
use settings::MachineProfile;

/// With fewer prints, the settings count.
const MIN_PRINTS: usize = 5;
/// Heights that differ by less, mm, say nothing of the time per mm.
const MIN_HEIGHT_SPREAD_MM: f64 = 20.0;
/// What is learned differs from the settings by this factor at most, if these give a time at all.
const MAX_FACTOR: f64 = 5.0;

/// How long prints of a machine take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrintTimes {
    /// Hours per mm of build height.
    pub hours_per_mm: f64,
    /// Hours beside that, until the next print can begin: cooling, unpacking, and until somebody comes.
    pub cool_down_hours: f64,
    /// Number of prints that this was learned from; 0 = these are the settings.
    pub learned_from: usize,
}

impl PrintTimes {
    /// The times of the settings.
    pub fn of_settings(profile: &MachineProfile) -> Self {
        let (hours_per_mm, cool_down_hours) = (profile.space.print_hours_per_mm, profile.printing.cool_down_hours);
        Self { hours_per_mm, cool_down_hours, learned_from: 0 }
    }

    /// The times that prints took, the newest first.
    pub fn learn(profile: &MachineProfile, prints: &[ToldPrint]) -> Self {
        let given = Self::of_settings(profile);
        let took: Vec<(f64, f64)> = occupied_hours(prints);
        if took.len() < MIN_PRINTS {
            return given;
        }
        let slopes = took.iter().enumerate().flat_map(|(at, one)| took[..at].iter().map(move |other| (one, other)));
        let slopes = slopes.filter(|(one, other)| (one.0 - other.0).abs() >= MIN_HEIGHT_SPREAD_MM);
        let slopes: Vec<f64> = slopes.map(|(one, other)| (one.1 - other.1) / (one.0 - other.0)).collect();
        let slope = if slopes.len() < MIN_PRINTS { None } else { median(slopes) };
        let within = |slope: f64| slope.clamp(given.hours_per_mm / MAX_FACTOR, given.hours_per_mm * MAX_FACTOR);
        let hours_per_mm = slope.map_or(given.hours_per_mm, within);
        let rest = median(took.iter().map(|(height_mm, hours)| hours - hours_per_mm * height_mm).collect());
        let cool_down_hours = rest.unwrap_or(given.cool_down_hours).max(0.0);
        Self { hours_per_mm, cool_down_hours, learned_from: took.len() }
    }

    /// How long a build of this height is printed, hours.
    pub fn print_hours(&self, height_mm: f64) -> f64 {
        self.hours_per_mm * height_mm
    }

    /// How long the print of a build of this height takes, without cooling.
    pub fn printed(&self, height_mm: f64) -> SignedDuration {
        SignedDuration::try_from_secs_f64(3600.0 * self.print_hours(height_mm)).unwrap_or(SignedDuration::MAX)
    }

    /// How long a build of this height occupies its printer.
    pub fn occupied(&self, height_mm: f64) -> SignedDuration {
        let hours = self.print_hours(height_mm) + self.cool_down_hours;
        SignedDuration::try_from_secs_f64(3600.0 * hours).unwrap_or(SignedDuration::MAX)
    }
}

/// Height, mm, and hours of each print. One whose file was taken while the printer was occupied began when that ended.
fn occupied_hours(prints: &[ToldPrint]) -> Vec<(f64, f64)> {
    let began = |print: &ToldPrint| -> Timestamp {
        let before = prints.iter().filter(|other| other.printer == print.printer && other.told_at < print.told_at);
        before.map(|other| other.told_at.0).fold(print.begun_at.0, Timestamp::max)
    };
    let hours = |print: &ToldPrint| print.told_at.0.duration_since(began(print)).as_secs_f64() / 3600.0;
    prints.iter().map(|print| (print.height_mm, hours(print))).filter(|(_, hours)| *hours > 0.0).collect()
}

/// Hours by which each print took longer than these times say; less than 0 = shorter.
pub fn print_excess_hours(times: &PrintTimes, prints: &[ToldPrint]) -> Vec<f64> {
    let expected = |height_mm: f64| times.print_hours(height_mm) + times.cool_down_hours;
    occupied_hours(prints).into_iter().map(|(height_mm, hours)| hours - expected(height_mm)).collect()
}

/// The middle of values; `None` = there are none.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        odd if odd % 2 == 1 => Some(values[middle]),
        _ => Some(0.5 * (values[middle - 1] + values[middle])),
    }
}

#[cfg(test)]
mod tests {
    use super::{super::trigger::tests::machine_with_triggers, *};

    /// Prints one after the other; each is told `delay` hours after its end and the next one's file is taken at once.
    fn prints(takes: &[(f64, f64)]) -> Vec<ToldPrint> {
        let mut at = Timestamp::UNIX_EPOCH;
        let mut told = |&(height_mm, hours): &(f64, f64)| {
            let begun_at = Timestamp::UNIX_EPOCH.into();
            at = at.checked_add(SignedDuration::from_secs_f64(3600.0 * hours)).unwrap();
            ToldPrint { printer: None, height_mm, begun_at, told_at: at.into() }
        };
        let mut all: Vec<ToldPrint> = takes.iter().map(&mut told).collect();
        all.reverse();
        all
    }

    #[test]
    fn times_are_learned_from_prints_and_one_that_lay_over_a_weekend_does_not_count_much() {
        let mut profile = machine_with_triggers("");
        (profile.space.print_hours_per_mm, profile.printing.cool_down_hours) = (0.1, 0.0);
        // 0.05 h per mm and 4 h beside that, although all files were taken on the first day.
        let mut takes: Vec<(f64, f64)> =
            (0..9).map(|n| 40.0 + 25.0 * f64::from(n)).map(|mm| (mm, 0.05 * mm + 4.0)).collect();
        takes[3].1 += 60.0;
        let learned = PrintTimes::learn(&profile, &prints(&takes));
        assert_eq!(learned.learned_from, 9);
        assert!((learned.hours_per_mm - 0.05).abs() < 1e-6, "{learned:?}");
        assert!((learned.cool_down_hours - 4.0).abs() < 1e-6, "{learned:?}");
        assert!((learned.occupied(100.0).as_secs_f64() - 9.0 * 3600.0).abs() < 1.0);
    }

    #[test]
    fn few_prints_and_those_of_one_height_teach_no_time_per_mm() {
        let mut profile = machine_with_triggers("");
        (profile.space.print_hours_per_mm, profile.printing.cool_down_hours) = (0.1, 2.0);
        let given = PrintTimes::of_settings(&profile);
        assert_eq!(PrintTimes::learn(&profile, &prints(&[(100.0, 30.0); 4])), given);
        let learned = PrintTimes::learn(&profile, &prints(&[(100.0, 13.0); 5]));
        assert_eq!((learned.hours_per_mm, learned.cool_down_hours.round()), (0.1, 3.0));
        // What cannot be is not learned.
        let wild: Vec<(f64, f64)> = (1..9).map(|n| (50.0 * f64::from(n), 1000.0 * f64::from(n))).collect();
        assert_eq!(PrintTimes::learn(&profile, &prints(&wild)).hours_per_mm, 0.5);
    }
}
