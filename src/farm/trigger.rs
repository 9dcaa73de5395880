//! When a batch fires: a pure function of what waits, what the open build looks like, and the time.

use std::fmt;

use jiff::{Timestamp, Zoned, tz::TimeZone};

use crate::settings::Profile;

/// Why a batch fired.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FiredBy {
    /// An operator said so.
    Flush,
    /// A waiting copy was tried and found no place.
    Full,
    /// The open build has reached its share of the volume.
    Fill,
    /// Enough copies wait.
    Copies,
    /// The oldest part has waited long enough.
    MaxWait,
    /// A due date comes near.
    Due,
    /// A time of day has come.
    At,
}

impl fmt::Display for FiredBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Flush => "flush",
            Self::Full => "full",
            Self::Fill => "fill",
            Self::Copies => "copies",
            Self::MaxWait => "max_wait",
            Self::Due => "due",
            Self::At => "at",
        })
    }
}

/// What a trigger looks at.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Copies that wait.
    pub copies: usize,
    /// When the oldest waiting part was claimed.
    pub oldest: Timestamp,
    /// The earliest due date among the waiting parts.
    pub due: Option<Timestamp>,
    /// Height of the open build, mm; 0 when there is no layout yet.
    pub height_mm: f64,
    /// Part volume of the open build / volume of the whole build volume.
    pub density: f64,
    /// Whether a layout of all waiting copies was tried to the end of its budget and a copy found no place.
    pub full: bool,
    /// Whether an operator wants it now.
    pub flush: bool,
    /// Whether the clock was not set a moment ago, so that dates may be acted on.
    pub knows_the_date: bool,
}

/// The first trigger that holds, if any.
pub fn fired_by(profile: &Profile, facts: &Facts, now: Timestamp) -> Option<FiredBy> {
    if facts.copies == 0 {
        return None;
    }
    let trigger = &profile.trigger;
    let share = |limit: Option<f64>, value: f64| limit.is_some_and(|limit| value >= limit);
    let height_share = facts.height_mm / profile.build_volume().size_mm.z;
    let holds = [
        (facts.flush, FiredBy::Flush),
        (facts.full, FiredBy::Full),
        (share(trigger.fill_height, height_share) || share(trigger.fill_density, facts.density), FiredBy::Fill),
        (trigger.copies.is_some_and(|n| facts.copies >= n as usize), FiredBy::Copies),
        // When the clock is set, the times of the waiting parts are set with it: this is how long it really waits.
        (secs_between(facts.oldest, now) >= trigger.max_wait_secs, FiredBy::MaxWait),
        (facts.knows_the_date && is_due(profile, facts, now), FiredBy::Due),
        (facts.knows_the_date && a_time_has_come(&trigger.at, facts.oldest, now), FiredBy::At),
    ];
    holds.into_iter().find(|(holds, _)| *holds).map(|(_, by)| by)
}

/// Seconds from `earlier` to `later`.
pub fn secs_between(earlier: Timestamp, later: Timestamp) -> f64 {
    later.duration_since(earlier).as_secs_f64()
}

/// Whether printing must begin now for the earliest due date to be met.
fn is_due(profile: &Profile, facts: &Facts, now: Timestamp) -> bool {
    let (Some(margin_secs), Some(due)) = (profile.trigger.due_margin_secs, facts.due) else { return false };
    let print_secs = facts.height_mm * profile.print_hours_per_mm * 3600.0;
    secs_between(now, due) <= print_secs + margin_secs
}

/// Whether one of the times of day lies between the oldest part's arrival and now; so a time that passed while the
/// daemon was down still counts.
fn a_time_has_come(at: &[jiff::civil::Time], oldest: Timestamp, now: Timestamp) -> bool {
    if at.is_empty() || now <= oldest {
        return false;
    }
    let zone = TimeZone::system();
    let now_local = now.to_zoned(zone.clone());
    let today_or_yesterday = |time: &jiff::civil::Time| -> Option<Zoned> {
        let today = now_local.date().to_datetime(*time).to_zoned(zone.clone()).ok()?;
        if today <= now_local {
            return Some(today);
        }
        now_local.date().yesterday().ok()?.to_datetime(*time).to_zoned(zone.clone()).ok()
    };
    at.iter().filter_map(today_or_yesterday).any(|last| last.timestamp() > oldest)
}

#[cfg(test)]
mod tests {
    use jiff::{SignedDuration, ToSpan};

    use super::*;
    use crate::ledger::fixtures::{fresh, waiting};

    /// A machine that fires after a day, an hour before a due date, and at five o'clock.
    fn machine() -> Profile {
        let folder = tempfile::tempdir().unwrap();
        let profile = "volume_mm = [100, 100, 100]\n[trigger]\nmax_wait_secs = \"24h\"\nat = [\"17:00\"]\n";
        std::fs::create_dir(folder.path().join("profiles")).unwrap();
        std::fs::write(folder.path().join("profiles/m.toml"), profile).unwrap();
        std::fs::write(folder.path().join("nestd.toml"), "").unwrap();
        let mut settings = crate::settings::load(Some(&folder.path().join("nestd.toml")), None).unwrap();
        settings.profiles.remove("m").unwrap()
    }

    fn facts(oldest: Timestamp, due: Option<Timestamp>, knows_the_date: bool) -> Facts {
        Facts { copies: 1, oldest, due, height_mm: 0.0, density: 0.0, full: false, flush: false, knows_the_date }
    }

    fn at(hour: i8, minute: i8) -> Timestamp {
        jiff::civil::date(2026, 11, 20).at(hour, minute, 0, 0).to_zoned(TimeZone::system()).unwrap().timestamp()
    }

    #[tokio::test]
    async fn a_clock_that_is_set_by_a_day_neither_fires_nor_forgets_a_wait() {
        let (machine, day) = (machine(), SignedDuration::from_hours(24));
        for jump in [day, -day, SignedDuration::from_hours(24 * 365), SignedDuration::from_mins(-90)] {
            let ledger = fresh().await;
            let claimed = at(8, 0);
            let ledger = ledger.ledger.clone().with_clock(move || claimed);
            let part = waiting(&ledger, "a", 1).await;
            let oldest = async || ledger.part(part).await.unwrap().unwrap().claimed_at.0;
            // Twenty minutes later the clock is set.
            ledger.keep_ages(jump).await.unwrap();
            let now = at(8, 20).checked_add(jump).unwrap();
            assert_eq!(fired_by(&machine, &facts(oldest().await, None, false), now), None, "set by {jump:#}");
            let just_before = now.checked_add((23.hours()).minutes(39)).unwrap();
            assert_eq!(fired_by(&machine, &facts(oldest().await, None, false), just_before), None, "set by {jump:#}");
            let then = now.checked_add((23.hours()).minutes(41)).unwrap();
            assert_eq!(fired_by(&machine, &facts(oldest().await, None, false), then), Some(FiredBy::MaxWait));
        }
    }

    #[test]
    fn dates_wait_while_the_clock_is_not_sure_and_are_not_forgotten() {
        let machine = machine();
        let due = Some(at(12, 0));
        assert_eq!(fired_by(&machine, &facts(at(8, 0), due, true), at(10, 30)), None);
        assert_eq!(fired_by(&machine, &facts(at(8, 0), due, true), at(11, 30)), Some(FiredBy::Due));
        assert_eq!(fired_by(&machine, &facts(at(8, 0), due, false), at(11, 30)), None);
        assert_eq!(fired_by(&machine, &facts(at(8, 0), None, false), at(17, 1)), None);
        assert_eq!(fired_by(&machine, &facts(at(8, 0), None, true), at(17, 6)), Some(FiredBy::At));
    }
}
