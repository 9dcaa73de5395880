//! When a part is due, as a ticket or a list says it: a day, a local time or an instant. Days and local times are those of
//! the farm's time zone.

use jiff::{Timestamp, civil, tz::TimeZone};

/// Accepted years of due dates. Times in the ledger sort as text only if years have four digits.
const YEARS: std::ops::RangeInclusive<i16> = 1970..=9998;

/// When a part is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DueDate {
    /// By the end of a day.
    Day(civil::Date),
    /// At a local time.
    Local(civil::DateTime),
    /// At an instant.
    At(Timestamp),
}

impl std::fmt::Display for DueDate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Day(day) => day.fmt(f),
            Self::Local(time) => write!(f, "{} {:02}:{:02}", time.date(), time.hour(), time.minute()),
            Self::At(instant) => instant.fmt(f),
        }
    }
}

impl DueDate {
    /// Converts it to an instant, using the time zone of the farm.
    pub fn to_timestamp(self, zone: &TimeZone) -> Result<Timestamp, jiff::Error> {
        match self {
            Self::At(instant) => Ok(instant),
            Self::Local(time) => Ok(time.to_zoned(zone.clone())?.timestamp()),
            // The last second of the day, so that it is that day for whoever shows only the date of the instant.
            Self::Day(day) => {
                let end = day.to_zoned(zone.clone())?.end_of_day()?.timestamp();
                Timestamp::from_second(end.as_second())
            }
        }
    }

    fn year(self) -> i16 {
        match self {
            Self::Day(day) => day.year(),
            Self::Local(time) => time.year(),
            Self::At(instant) => instant.to_zoned(TimeZone::UTC).year(),
        }
    }
}

/// Parses a date, a local time or an instant.
pub(crate) fn parse_due(text: &str) -> Result<DueDate, String> {
    let text = text.trim();
    let has_time = text.contains(['T', 't', ' ']);
    let parsed = match text.parse::<Timestamp>() {
        Ok(instant) => Ok(DueDate::At(instant)),
        Err(_) if has_time => text.parse().map(DueDate::Local),
        Err(_) => text.parse().map(DueDate::Day),
    };
    parsed.ok().filter(|due| YEARS.contains(&due.year())).ok_or_else(|| {
        format!(
            "due = {text:?}; it must be a date such as 2026-11-25 or a time such as 2026-11-25T17:00:00Z, in the years {} to {}",
            YEARS.start(),
            YEARS.end()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_is_due_at_its_end_and_a_local_time_in_the_zone_of_the_farm() {
        let zone = TimeZone::fixed(jiff::tz::offset(1));
        let at = |text: &str| parse_due(text).unwrap().to_timestamp(&zone).unwrap().to_string();
        assert_eq!(at("2026-11-25"), "2026-11-25T22:59:59Z");
        assert_eq!(at("2026-11-25T17:00"), "2026-11-25T16:00:00Z");
        assert_eq!(at("2026-11-25 17:00:00"), "2026-11-25T16:00:00Z");
        assert_eq!(at("2026-11-25T17:00:00Z"), "2026-11-25T17:00:00Z");
        assert_eq!(at("2026-11-25T17:00:00-05:00"), "2026-11-25T22:00:00Z");
    }

    #[test]
    fn a_day_ends_in_its_own_zone_also_where_the_clocks_change() {
        let berlin = TimeZone::get("Europe/Berlin").unwrap();
        let at = |text: &str| parse_due(text).unwrap().to_timestamp(&berlin).unwrap().to_string();
        assert_eq!(at("2026-12-24"), "2026-12-24T22:59:59Z");
        assert_eq!(
            (at("2026-03-28"), at("2026-03-29")),
            ("2026-03-28T22:59:59Z".into(), "2026-03-29T21:59:59Z".into())
        );
        assert_eq!(
            (at("2026-10-24"), at("2026-10-25")),
            ("2026-10-24T21:59:59Z".into(), "2026-10-25T22:59:59Z".into())
        );
        // A time that the clocks skip, and one that they show twice.
        assert_eq!(at("2026-03-29 02:30"), "2026-03-29T01:30:00Z");
        assert_eq!(at("2026-10-25 02:30"), "2026-10-25T00:30:00Z");
        // Midnight is shown twice there; the day ends at the second one.
        let cuba = TimeZone::get("America/Havana").unwrap();
        assert_eq!(parse_due("2026-10-31").unwrap().to_timestamp(&cuba).unwrap().to_string(), "2026-11-01T03:59:59Z");
    }
}
