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
        // A part from the future was claimed before the clock was set right: it has waited long enough.
        (secs_between(facts.oldest, now).abs() >= trigger.max_wait_secs, FiredBy::MaxWait),
        (is_due(profile, facts, now), FiredBy::Due),
        (a_time_has_come(&trigger.at, facts.oldest, now), FiredBy::At),
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
