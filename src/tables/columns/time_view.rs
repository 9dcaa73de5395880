//! How times are shown to people: in the time zone of the farm, with the mark of the zone, and with durations beside due
//! dates.

use jiff::{SignedDuration, Timestamp};
use language::say;
use ledger::{PartTerms, UtcTimestamp};

use crate::{
    farm::{OrderFact, delay_text},
    settings::FarmZone,
};

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
}

impl PromisedDate {
    /// That of an order, as far as it is known.
    pub fn of_order(fact: &OrderFact) -> Option<Self> {
        Some(Self { done_at: fact.done_at?, late: fact.lateness() })
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

    /// A due date as people say it: `tomorrow`, `Fri 4 Dec`.
    pub fn near_due_text(&self, due: &GivenDate) -> String {
        match self.now {
            Some(now) if self.zone.is_day(&due.text) => self.zone.format_near_day(due.due_at.0, now),
            Some(_) => self.near_text(due.due_at),
            None => self.due_text(due),
        }
    }

    /// When something will be done, with its delay: `tomorrow 03:45, 28 h late`.
    pub fn promise_text(&self, promise: &PromisedDate) -> String {
        language::join_names([Some(self.near_text(promise.done_at)), promise.late_text()].into_iter().flatten())
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
