//! How times are shown to people: in the time zone of the farm, with the mark of the zone, and with durations beside due
//! dates.

use farm::{OrderFact, delay_text};
use jiff::{
    SignedDuration, Timestamp,
    civil::{Date, DateTime},
};
use language::say;
use ledger::{PartTerms, UtcTimestamp};
use settings::FarmZone;

/// How times are shown to people.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimeView {
    zone: FarmZone,
    now: Option<Timestamp>,
}

/// A due date: the instant, and the date as it was given.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GivenDate {
    /// When it is due.
    pub due_at: UtcTimestamp,
    /// The date as it was given, "" = not known.
    pub text: String,
}

impl GivenDate {
    /// The due date, if there is one.
    pub fn new(due_at: Option<UtcTimestamp>, text: &str) -> Option<Self> {
        due_at.map(|due_at| Self { due_at, text: text.to_owned() })
    }

    /// The due date of a part, if it has one.
    pub fn of_terms(terms: &PartTerms) -> Option<Self> {
        Self::new(terms.due_at, &terms.due_text)
    }
}

/// When something will be done, or was, and by how much that is late.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PromisedDate {
    /// When.
    pub done_at: UtcTimestamp,
    /// By how much it is late; `None` = it is not.
    pub late: Option<SignedDuration>,
    /// Whether nobody told that: it goes by the plan.
    pub is_estimated: bool,
}

impl PromisedDate {
    /// That of an order, as far as it is known.
    pub fn of_order(fact: &OrderFact) -> Option<Self> {
        Some(Self { done_at: fact.done_at?, late: fact.lateness(), is_estimated: fact.is_estimated })
    }

    /// By how much it is late: `28 h late`.
    pub fn late_text(&self) -> Option<String> {
        self.late.map(|late| say!("late-by", delay = delay_text(late)))
    }
}

impl TimeView {
    /// For a text that is read now.
    pub fn current(zone: &FarmZone) -> Self {
        Self::at(zone, Timestamp::now())
    }

    /// For a text that is read at this time.
    pub fn at(zone: &FarmZone, now: Timestamp) -> Self {
        Self { zone: zone.clone(), now: Some(now) }
    }

    /// For a text that is kept: it tells no durations.
    pub fn kept(zone: &FarmZone) -> Self {
        Self { zone: zone.clone(), now: None }
    }

    /// The current time; `None` for a text that is kept.
    pub fn now(&self) -> Option<Timestamp> {
        self.now
    }

    /// A time with its zone: `2026-11-20 05:49:00 CET`.
    pub fn time_text(&self, at: UtcTimestamp) -> String {
        self.zone.format_time(at.0)
    }

    /// A time as people say it: `today 05:49`.
    pub fn near_text(&self, at: UtcTimestamp) -> String {
        self.now.map_or_else(|| self.zone.format_minute(at.0), |now| self.zone.format_near(at.0, now))
    }

    /// A time that nobody told, as people say it: `about today 05:49`.
    pub fn estimate_text(&self, at: UtcTimestamp) -> String {
        say!("about-time", time = self.near_text(at))
    }

    /// A text with each exact time of the farm in it as people say it: `before 2026-11-30 06:00 CET` becomes `before tomorrow 06:00`.
    pub fn near_times(&self, text: &str) -> String {
        let mut said = String::new();
        let mut rest = text;
        while let Some(letter) = rest.chars().next() {
            let (near, length) = match self.exact_time_at(rest) {
                Some((at, length)) => (self.near_text(at), length),
                None => (letter.to_string(), letter.len_utf8()),
            };
            said.push_str(&near);
            rest = &rest[length..];
        }
        said
    }

    /// The time that a text begins with, as this zone writes it, and how many bytes that are.
    fn exact_time_at(&self, text: &str) -> Option<(UtcTimestamp, usize)> {
        let civil = |length: usize, format: &str| DateTime::strptime(format, text.get(..length)?).ok();
        let zoned = |civil: DateTime| civil.to_zoned(self.zone.time_zone().clone()).ok().map(|zoned| zoned.timestamp());
        let written =
            |at: Timestamp, exact: String| text.starts_with(&exact).then_some((UtcTimestamp(at), exact.len()));
        let minute = || zoned(civil(16, "%Y-%m-%d %H:%M")?).and_then(|at| written(at, self.zone.format_minute(at)));
        let second = || zoned(civil(19, "%Y-%m-%d %H:%M:%S")?).and_then(|at| written(at, self.zone.format_time(at)));
        second().or_else(minute)
    }

    /// A date as it was given, or an exact time, as people say it; another text as it is.
    pub fn near_date(&self, given: &str) -> String {
        let noon = given
            .parse::<Date>()
            .ok()
            .filter(|_| self.zone.is_day(given))
            .and_then(|day| Some(day.at(12, 0, 0, 0).to_zoned(self.zone.time_zone().clone()).ok()?.timestamp()));
        match (noon, self.now) {
            (Some(noon), Some(now)) => self.zone.format_near_day(noon, now),
            _ => self.near_times(given),
        }
    }

    /// A due date as people say it: `tomorrow`, `Fri 4 Dec`.
    pub fn near_due_text(&self, due: &GivenDate) -> String {
        match self.now {
            Some(now) if self.zone.is_day(&due.text) => self.zone.format_near_day(due.due_at.0, now),
            Some(_) => self.near_text(due.due_at),
            None => self.due_text(due),
        }
    }

    /// When something will be done, with its delay: `about tomorrow 03:45, 28 h late`.
    pub fn promise_text(&self, promise: &PromisedDate) -> String {
        let done = match promise.is_estimated {
            true => self.estimate_text(promise.done_at),
            false => self.near_text(promise.done_at),
        };
        language::join_names([Some(done), promise.late_text()].into_iter().flatten())
    }

    /// A due date with the time that is left: `2026-12-24, in 32d 4h`.
    pub fn due_text(&self, due: &GivenDate) -> String {
        let date = self.zone.format_due(due.due_at.0, &due.text);
        match self.now.and_then(|now| due.due_at.distance_text(now)) {
            Some(distance) => language::join_names([date, distance]),
            None => date,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_times_in_a_text_are_said_as_people_say_them_and_nothing_else_is_touched() {
        let now: Timestamp = "2026-11-29T00:00:00Z".parse().unwrap();
        let view = TimeView::at(&FarmZone::default(), now);
        let exact = |text: &str| view.zone.format_minute(text.parse().unwrap());
        let reason = format!("the printer begins no print before {}; b_2026-11-30.stl", exact("2026-11-30T05:00:00Z"));
        assert_eq!(view.near_times(&reason), "the printer begins no print before tomorrow 05:00; b_2026-11-30.stl");
        assert_eq!(view.near_times(&view.time_text(UtcTimestamp(now))), "today 00:00");
        for text in ["", "2026-11-30", "2026-13-30 06:00 UTC", "schön 2026-11-30 06:00 XYZ"] {
            assert_eq!(view.near_times(text), text);
        }
        assert_eq!(view.near_date("2026-12-02"), "Wed 2 Dec");
        assert_eq!(view.near_date("soon"), "soon");
    }
}
