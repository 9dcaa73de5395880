//! Timestamps of the ledger: UTC, RFC 3339 with milliseconds, so that they sort as text.

use std::{borrow::Cow, fmt, ops::Deref};

use jiff::{SpanRound, Timestamp, Unit};
use language::say;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Serialize, Serializer};

use super::sql::{bind_as_text, read_text_by};

/// A timestamp in a row; prints as '2026-11-20T04:49:00.000Z'.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct UtcTimestamp(pub Timestamp);

impl UtcTimestamp {
    /// Time since this timestamp, in two units: '3h 5m'. `None` = too long to express.
    pub fn age_text(self, now: Timestamp) -> Option<String> {
        let days = now.since(self.0).and_then(|span| span.round(day_rounding())).ok()?;
        let smallest = match (days.get_days(), days.get_hours(), days.get_minutes()) {
            (0, 0, 0) => Unit::Second,
            (0, _, _) => Unit::Minute,
            _ => Unit::Hour,
        };
        let rounded = now.since(self.0).and_then(|span| span.round(day_rounding().smallest(smallest)));
        rounded.ok().map(|span| format!("{span:#}"))
    }
}

impl UtcTimestamp {
    /// How far away this timestamp is: `in 3h 5m`, or `2d 2h overdue`. `None` = too far to express.
    pub fn distance_text(self, now: Timestamp) -> Option<String> {
        match self.0 >= now {
            true => Some(say!("due-in", span = Self(now).age_text(self.0)?)),
            false => Some(say!("due-overdue", span = self.age_text(now)?)),
        }
    }
}

fn day_rounding() -> SpanRound<'static> {
    SpanRound::new().largest(Unit::Day).days_are_24_hours()
}

impl From<Timestamp> for UtcTimestamp {
    fn from(time: Timestamp) -> Self {
        Self(time)
    }
}

impl Deref for UtcTimestamp {
    type Target = Timestamp;

    fn deref(&self) -> &Timestamp {
        &self.0
    }
}

impl fmt::Display for UtcTimestamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.0.strftime("%Y-%m-%dT%H:%M:%S%.3fZ").to_string())
    }
}

impl fmt::Debug for UtcTimestamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl Serialize for UtcTimestamp {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl JsonSchema for UtcTimestamp {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Utc".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "format": "date-time" })
    }
}

bind_as_text!(UtcTimestamp);
read_text_by!(UtcTimestamp, |text: &str| text.parse().map(UtcTimestamp));

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_written_with_milliseconds_and_z_so_that_it_sorts_as_text() {
        let early = UtcTimestamp("2026-11-20T04:49:00Z".parse().unwrap());
        let late = UtcTimestamp("2026-11-20T06:49:00.0019+02:00".parse().unwrap());
        assert_eq!(early.to_string(), "2026-11-20T04:49:00.000Z");
        assert_eq!(late.to_string(), "2026-11-20T04:49:00.001Z");
        assert!(early.to_string() < late.to_string());
    }

    #[test]
    fn how_far_a_due_date_is_away_is_said_in_two_units() {
        let due = UtcTimestamp("2026-12-24T22:59:59Z".parse().unwrap());
        let at = |text: &str| due.distance_text(text.parse().unwrap()).unwrap();
        assert_eq!(at("2026-12-24T19:54:59Z"), "in 3h 5m");
        assert_eq!(at("2026-11-22T18:59:59Z"), "in 32d 4h");
        assert_eq!(at("2026-12-27T00:59:59Z"), "2d 2h overdue");
    }
}
