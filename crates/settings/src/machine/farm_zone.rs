//! The time zone of the farm. Dates that people write mean days there, and times that people see are shown there.
//! Programs (JSON, CSV, SQL, the log) get UTC.

use jiff::{Timestamp, civil, tz::TimeZone};
use language::{Language, say};

use crate::reading::validator::ConfigValidator;

/// The value of `time_zone` that stands for the zone of the system.
const SYSTEM: &str = "system";
/// A day so many days away is said without its year.
const NEAR_DAYS: i32 = 200;

/// The time zone of the farm.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FarmZone(TimeZone);

impl Default for FarmZone {
    /// The zone of the system; UTC where the system names none that it knows.
    fn default() -> Self {
        Self(TimeZone::try_system().unwrap_or(TimeZone::UTC))
    }
}

impl From<TimeZone> for FarmZone {
    fn from(zone: TimeZone) -> Self {
        Self(zone)
    }
}

impl FarmZone {
    /// The zone with its rules.
    pub fn time_zone(&self) -> &TimeZone {
        &self.0
    }

    /// Its name: `Europe/Berlin`; "local time" for a zone of the system without a name.
    pub fn name(&self) -> &str {
        self.0.iana_name().unwrap_or("local time")
    }

    /// A time with its zone, to the second: `2026-11-20 05:49:00 CET`.
    pub fn format_time(&self, at: Timestamp) -> String {
        at.to_zoned(self.0.clone()).strftime("%Y-%m-%d %H:%M:%S %Z").to_string()
    }

    /// A time with its zone, to the minute: `2026-11-20 05:49 CET`.
    pub fn format_minute(&self, at: Timestamp) -> String {
        at.to_zoned(self.0.clone()).strftime("%Y-%m-%d %H:%M %Z").to_string()
    }

    /// A time of day with its zone, `05:49 CET`; with its date unless it is on the day of `now`.
    pub fn format_clock(&self, at: Timestamp, now: Timestamp) -> String {
        let day = |time: Timestamp| time.to_zoned(self.0.clone()).date();
        match day(at) == day(now) {
            true => at.to_zoned(self.0.clone()).strftime("%H:%M %Z").to_string(),
            false => self.format_minute(at),
        }
    }

    /// A time as people say it: `today 05:49`, `Fri 4 Dec 05:49`; with its year where it is far from `now`.
    pub fn format_near(&self, at: Timestamp, now: Timestamp) -> String {
        let clock = at.to_zoned(self.0.clone()).strftime("%H:%M").to_string();
        language::clock_text(self.format_near_day(at, now), clock)
    }

    /// A day as people say it: `today`, `Fri 4 Dec`.
    pub fn format_near_day(&self, at: Timestamp, now: Timestamp) -> String {
        let [at, now] = [at, now].map(|time| time.to_zoned(self.0.clone()).date());
        match now.until(at).map_or(i32::MAX, |span| span.get_days()) {
            -1 => say!("date-yesterday"),
            0 => say!("date-today"),
            1 => say!("date-tomorrow"),
            days if days.abs() <= NEAR_DAYS => {
                language::day_text(at.weekday().to_monday_one_offset(), at.day(), at.month())
            }
            _ => language::year_text(at.day(), at.month(), at.year()),
        }
    }

    /// Whether a due date, as it was given, is a day without a time.
    pub fn is_day(&self, text: &str) -> bool {
        text.parse::<civil::Date>().is_ok_and(|day| text == day.to_string())
    }

    /// A due date: the day that was given, else the time with its zone. `text` is the date as it was given, "" = not known.
    pub fn format_due(&self, at: Timestamp, text: &str) -> String {
        if self.is_day(text) { text.to_owned() } else { self.format_minute(at) }
    }
}

/// Zone and language of the farm file.
pub(crate) fn validate_place(zone: &str, language: &str, validator: &mut ConfigValidator) -> (FarmZone, Language) {
    (validate_time_zone(zone, validator), validate_language(language, validator))
}

/// The zone of a `time_zone` of the farm file. Reports a zone that is not known.
fn validate_time_zone(name: &str, validator: &mut ConfigValidator) -> FarmZone {
    if name == SYSTEM {
        return FarmZone::default();
    }
    match TimeZone::get(name) {
        Ok(zone) if !zone.is_unknown() => FarmZone(zone),
        _ => {
            let text = format!("time_zone = \"{}\" is no time zone that this system knows", name.escape_debug());
            let remedy = match TimeZone::get("Europe/Berlin").is_ok() {
                true => {
                    "name a zone as in \"Europe/Berlin\" (`timedatectl list-timezones` lists them), \"UTC\" or \"system\""
                }
                false => {
                    "this system has no time zone database: install its package tzdata, or write \"UTC\" or \"system\""
                }
            };
            validator.report_problem("time_zone", text, remedy);
            FarmZone::default()
        }
    }
}

/// The language of a `language` of the farm file. Reports one that is not known.
fn validate_language(tag: &str, validator: &mut ConfigValidator) -> Language {
    match Language::ALL.into_iter().find(|language| language.tag() == tag) {
        Some(language) => language,
        None => {
            let text = format!("language = \"{}\" is no language of nestd", tag.escape_debug());
            validator.report_problem("language", text, "say \"en\", \"de\", \"fr\" or \"ja\"");
            Language::English
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_shown_in_the_zone_on_both_sides_of_a_change_of_the_clocks() {
        let berlin = FarmZone(TimeZone::get("Europe/Berlin").unwrap());
        let at = |text: &str| text.parse::<Timestamp>().unwrap();
        assert_eq!(berlin.format_time(at("2026-10-25T00:59:59Z")), "2026-10-25 02:59:59 CEST");
        assert_eq!(berlin.format_time(at("2026-10-25T01:00:00Z")), "2026-10-25 02:00:00 CET");
        assert_eq!(berlin.format_clock(at("2026-10-25T13:20:00Z"), at("2026-10-25T00:10:00Z")), "14:20 CET");
        assert_eq!(berlin.format_clock(at("2026-10-25T23:20:00Z"), at("2026-10-25T00:10:00Z")), "2026-10-26 00:20 CET");
        let near = |text: &str| berlin.format_near(at(text), at("2026-10-25T00:10:00Z"));
        assert_eq!([near("2026-10-25T13:20:00Z"), near("2026-10-25T23:20:00Z")], ["today 14:20", "tomorrow 00:20"]);
        assert_eq!(
            ["2026-10-24T21:00:00Z", "2026-10-27T09:00:00Z", "2026-12-04T07:00:00Z", "2027-12-04T07:00:00Z"].map(near),
            ["yesterday 23:00", "Tue 27 Oct 10:00", "Fri 4 Dec 08:00", "4 Dec 2027 08:00"]
        );
        assert_eq!(FarmZone(TimeZone::UTC).format_minute(at("2026-10-25T00:59:59Z")), "2026-10-25 00:59 UTC");
    }

    #[test]
    fn a_day_stays_that_day_in_every_zone_and_a_time_is_shown_in_the_zone() {
        let zone = |name: &str| FarmZone(TimeZone::get(name).unwrap());
        let end_in_berlin: Timestamp = "2026-12-24T22:59:59Z".parse().unwrap();
        for name in ["Europe/Berlin", "UTC", "Pacific/Kiritimati", "America/Los_Angeles"] {
            assert_eq!(zone(name).format_due(end_in_berlin, "2026-12-24"), "2026-12-24", "{name}");
        }
        assert_eq!(zone("Europe/Berlin").format_due(end_in_berlin, ""), "2026-12-24 23:59 CET");
        assert_eq!(zone("Asia/Tokyo").format_due(end_in_berlin, "2026-12-24 23:59"), "2026-12-25 07:59 JST");
    }
}
