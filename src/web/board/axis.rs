//! The time axis of the board: from three hours ago to three days ahead, in steps of a quarter of an hour. A place on it is a class
//! of the style sheet.

use jiff::{SignedDuration, Timestamp, ToSpan, civil::Date};
use language::say;
use maud::{Markup, html};
use settings::FarmZone;

use crate::web::look::style::AXIS_STEPS;

/// One step, s.
const STEP_SECS: i64 = 15 * 60;
/// What is shown of the past, s.
const BEFORE_SECS: i64 = 3 * 3600;
/// A label of a day needs so many steps.
const LABEL_STEPS: u32 = 24;

/// The axis at one time.
pub(crate) struct TimeAxis {
    start: Timestamp,
    now: Timestamp,
    zone: FarmZone,
}

/// A place on the axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct AxisSpan {
    /// Its first step.
    pub(crate) from: u32,
    /// Its number of steps, at least 1.
    pub(crate) steps: u32,
}

impl AxisSpan {
    /// Its classes.
    pub(crate) fn classes(self) -> String {
        format!("x{} w{}", self.from, self.steps)
    }
}

impl TimeAxis {
    pub(crate) fn new(now: Timestamp, zone: &FarmZone) -> Self {
        let first = (now.as_second() - BEFORE_SECS).div_euclid(STEP_SECS) * STEP_SECS;
        Self { start: Timestamp::from_second(first).unwrap_or(now), now, zone: zone.clone() }
    }

    /// Its two ends.
    pub(crate) fn ends(&self) -> (Timestamp, Timestamp) {
        let length = SignedDuration::from_secs(i64::from(AXIS_STEPS) * STEP_SECS);
        (self.start, self.start.checked_add(length).unwrap_or(Timestamp::MAX))
    }

    /// The step in which a moment is, also one beside the axis.
    fn step(&self, at: Timestamp) -> i64 {
        (at.as_second() - self.start.as_second()).div_euclid(STEP_SECS)
    }

    /// The part of a span that is on the axis; `None` = nothing of it.
    pub(crate) fn span(&self, from: Timestamp, to: Timestamp) -> Option<AxisSpan> {
        let (start, end) = self.ends();
        if to <= start || from >= end || to < from {
            return None;
        }
        let on_axis = |step: i64| u32::try_from(step).unwrap_or(0).min(AXIS_STEPS);
        let from = on_axis(self.step(from)).min(AXIS_STEPS - 1);
        let steps = on_axis(self.step(to)).saturating_sub(from).max(1);
        Some(AxisSpan { from, steps })
    }

    /// The step of now.
    fn now_step(&self) -> u32 {
        u32::try_from(self.step(self.now)).unwrap_or(0)
    }

    /// The steps at which days begin, with their date; the first is that of the begin of the axis.
    fn days(&self) -> Vec<(u32, Date)> {
        let zone = self.zone.time_zone();
        let first = self.start.to_zoned(zone.clone()).date();
        let day = |ahead: i64| {
            let date = first.checked_add(ahead.days()).ok()?;
            let begins = date.to_zoned(zone.clone()).ok()?.timestamp();
            let step = u32::try_from(self.step(begins)).unwrap_or(0);
            (step < AXIS_STEPS).then_some((step, date))
        };
        (0..=4).map_while(day).collect()
    }

    /// Days and hours, for those who see them: screen readers get times in words.
    pub(crate) fn draw(&self) -> Markup {
        let (days, zone) = (self.days(), self.zone.time_zone());
        let today = self.now.to_zoned(zone.clone()).date();
        let ends = days.iter().skip(1).map(|(step, _)| *step).chain([AXIS_STEPS]);
        let hour = |date: Date, hour: i8| {
            let at = date.at(hour, 0, 0, 0).to_zoned(zone.clone()).ok()?.timestamp();
            u32::try_from(self.step(at)).ok().filter(|step| (2..AXIS_STEPS - 6).contains(step)).map(|step| (step, hour))
        };
        html! {
            div.axis aria-hidden="true" {
                @for ((step, date), end) in days.iter().zip(ends) {
                    @if end - step >= LABEL_STEPS {
                        b class=(format!("x{step}")) { @if *date == today { (say!("date-today-alone")) }
                            @else { (language::day_text(date.weekday().to_monday_one_offset(), date.day(), date.month())) } }
                    }
                    @for (step, hour) in [6, 12, 18].into_iter().filter_map(|at| hour(*date, at)) {
                        span class=(format!("x{step}")) { (format!("{hour:02}")) }
                    }
                }
                i class=(format!("now x{}", self.now_step())) {}
            }
        }
    }

    /// The lines of days and of now, behind what is on the axis.
    pub(crate) fn lines(&self) -> Markup {
        html! {
            @for (step, _) in self.days().iter().skip(1) { i class=(format!("day x{step}")) {} }
            i class=(format!("now x{}", self.now_step())) {}
        }
    }
}

#[cfg(test)]
mod tests {
    use jiff::tz::TimeZone;

    use super::*;

    fn at(text: &str) -> Timestamp {
        text.parse().unwrap()
    }

    #[test]
    fn a_span_is_cut_at_the_ends_of_the_axis_and_has_a_step_at_least() {
        let axis = TimeAxis::new(at("2026-11-25T12:07:00Z"), &TimeZone::UTC.into());
        assert_eq!(axis.ends(), (at("2026-11-25T09:00:00Z"), at("2026-11-28T12:00:00Z")));
        let span = |from: &str, to: &str| axis.span(at(from), at(to)).map(|span| (span.from, span.steps));
        assert_eq!(span("2026-11-25T13:00:00Z", "2026-11-25T15:30:00Z"), Some((16, 10)));
        assert_eq!(span("2026-11-24T13:00:00Z", "2026-11-25T10:00:00Z"), Some((0, 4)));
        assert_eq!(span("2026-11-28T10:00:00Z", "2026-12-25T10:00:00Z"), Some((292, 8)));
        assert_eq!(span("2026-11-25T13:00:00Z", "2026-11-25T13:01:00Z"), Some((16, 1)));
        assert_eq!(span("2026-11-20T13:00:00Z", "2026-11-25T09:00:00Z"), None);
        assert_eq!(span("2026-11-28T12:00:00Z", "2026-11-28T13:00:00Z"), None);
    }

    #[test]
    fn days_begin_at_midnight_of_the_farm_also_where_the_clocks_change() {
        let berlin = TimeZone::get("Europe/Berlin").unwrap();
        let axis = TimeAxis::new(at("2026-10-24T10:00:00Z"), &berlin.into());
        // The 25th has 25 hours.
        let steps: Vec<u32> = axis.days().iter().map(|(step, _)| *step).collect();
        assert_eq!(steps, [0, 4 * 15, 4 * 40, 4 * 64]);
        let shown = axis.draw().into_string();
        assert!(shown.contains("Today</b>") && shown.contains("Mon 26 Oct</b>"), "{shown}");
    }
}
