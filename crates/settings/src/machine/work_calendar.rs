//! When people begin prints at a printer: hours of the week, and days off. Hours are those of the farm's time zone, and
//! stay the same hours of the day where the clocks change.

use std::str::FromStr;

use jiff::{
    Timestamp, ToSpan,
    civil::{Date, Time, Weekday},
    tz::TimeZone,
};

/// After so many days without an hour in which prints begin, none is looked for.
const MAX_DAYS_AHEAD: i32 = 800;

/// When prints begin; a print that has begun goes on at any time.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct WorkCalendar {
    /// The hours of each week; none = always.
    hours: Vec<WorkHours>,
    /// Days on which no print begins: the first and the last of each span.
    days_off: Vec<(Date, Date)>,
}

/// Hours of some days of the week.
#[derive(Debug, Clone, PartialEq, Eq)]
struct WorkHours {
    /// The days on which they begin.
    days: Vec<Weekday>,
    from: Time,
    /// Not later than `from` = of the next day; `None` = the end of the day.
    to: Option<Time>,
}

impl WorkCalendar {
    /// Reads hours such as `Mon-Fri 6-22, Sat 8:30-12`, or `always`. The error says which option is not understood, and what of it.
    pub(crate) fn parse(hours: &str, days_off: &[String]) -> Result<Self, (&'static str, String)> {
        let hours: Result<_, _> = match hours.trim() {
            "always" => Ok(Vec::new()),
            hours => hours.split(',').map(|entry| parse_hours(entry.trim())).collect(),
        };
        let days_off: Result<_, _> = days_off.iter().map(|text| parse_days_off(text)).collect();
        Ok(Self { hours: hours.map_err(|why| ("hours", why))?, days_off: days_off.map_err(|why| ("days_off", why))? })
    }

    /// The first moment from `at` on in which a print may begin; `None` = there is none within two years.
    pub fn next_open(&self, at: Timestamp, zone: &TimeZone) -> Option<Timestamp> {
        let today = at.to_zoned(zone.clone()).date();
        // Hours of the day before may last into today.
        (-1..MAX_DAYS_AHEAD).find_map(|ahead| {
            let day = today.checked_add(ahead.days()).ok()?;
            let spans = self.spans_of(day, zone).into_iter().filter(|(_, end)| *end > at);
            spans.map(|(start, _)| start.max(at)).min()
        })
    }

    /// The last moment up to `at`, to the second, in which a print may begin; `None` = there is none in the two years before.
    pub fn last_open(&self, at: Timestamp, zone: &TimeZone) -> Option<Timestamp> {
        let today = at.to_zoned(zone.clone()).date();
        (0..MAX_DAYS_AHEAD).find_map(|back| {
            let day = today.checked_sub(back.days()).ok()?;
            let spans = self.spans_of(day, zone).into_iter().filter(|(start, _)| *start <= at);
            spans.filter_map(|(_, end)| Some(end.checked_sub(1.second()).ok()?.min(at))).max()
        })
    }

    /// The spans between two moments in which no print may begin.
    pub fn closed_spans(&self, from: Timestamp, to: Timestamp, zone: &TimeZone) -> Vec<(Timestamp, Timestamp)> {
        let (first, last) = (from.to_zoned(zone.clone()).date(), to.to_zoned(zone.clone()).date());
        // Hours of the day before may last into the first one.
        let days = first.yesterday().unwrap_or(first).series(1.day()).take_while(|day| *day <= last);
        let mut open: Vec<_> = days.flat_map(|day| self.spans_of(day, zone)).collect();
        open.sort();
        let (mut closed, mut at) = (Vec::new(), from);
        for (start, end) in open.into_iter().chain([(to, to)]) {
            closed.push((at, start.min(to)));
            at = at.max(end);
        }
        closed.retain(|(start, end)| start < end);
        closed
    }

    /// Begin and end of the hours that begin on a day.
    fn spans_of(&self, day: Date, zone: &TimeZone) -> Vec<(Timestamp, Timestamp)> {
        if self.days_off.iter().any(|(first, last)| (*first..=*last).contains(&day)) {
            return Vec::new();
        }
        // A time that the clocks skip is the moment after the gap.
        let moment = |day: Date, time: Time| Some(day.to_datetime(time).to_zoned(zone.clone()).ok()?.timestamp());
        let next = |day: Date| day.tomorrow().ok();
        if self.hours.is_empty() {
            let whole = moment(day, Time::midnight()).zip(next(day).and_then(|day| moment(day, Time::midnight())));
            return whole.into_iter().collect();
        }
        let of_day = self.hours.iter().filter(|hours| hours.days.contains(&day.weekday()));
        let span = |hours: &WorkHours| {
            let end = match hours.to {
                Some(to) if to > hours.from => moment(day, to),
                to => moment(next(day)?, to.unwrap_or(Time::midnight())),
            };
            // The clocks may skip all of it.
            moment(day, hours.from).zip(end).filter(|(start, end)| start < end)
        };
        of_day.filter_map(span).collect()
    }
}

/// `Mon-Fri 6-22`, `Sat 8:30-12`, `Sun`.
fn parse_hours(text: &str) -> Result<WorkHours, String> {
    let wrong = || format!("\"{}\" is not understood", text.escape_debug());
    let mut words = text.split_whitespace();
    let (days, times, rest) = (words.next().ok_or_else(wrong)?, words.next(), words.next());
    if rest.is_some() {
        return Err(wrong());
    }
    let days = match days.split_once('-') {
        None => vec![parse_weekday(days).ok_or_else(wrong)?],
        Some((first, last)) => {
            let (first, last) = (parse_weekday(first).ok_or_else(wrong)?, parse_weekday(last).ok_or_else(wrong)?);
            let count = last.since(first) + 1;
            first.cycle_forward().take(usize::try_from(count).unwrap_or_default()).collect()
        }
    };
    let Some(times) = times else { return Ok(WorkHours { days, from: Time::midnight(), to: None }) };
    let (from, to) = times.split_once('-').ok_or_else(wrong)?;
    let to = match to {
        "24" | "24:00" => None,
        to => Some(parse_hour(to).ok_or_else(wrong)?),
    };
    Ok(WorkHours { days, from: parse_hour(from).ok_or_else(wrong)?, to })
}

fn parse_weekday(text: &str) -> Option<Weekday> {
    let names = ["mon", "tue", "wed", "thu", "fri", "sat", "sun"];
    let place = names.iter().position(|name| text.eq_ignore_ascii_case(name))?;
    Weekday::from_monday_zero_offset(i8::try_from(place).ok()?).ok()
}

/// `6`, `06`, `6:30`.
fn parse_hour(text: &str) -> Option<Time> {
    let (hour, minute) = text.split_once(':').unwrap_or((text, "0"));
    let number = |digits: &str| i8::from_str(digits).ok().filter(|_| digits.bytes().all(|b| b.is_ascii_digit()));
    Time::new(number(hour)?, number(minute)?, 0, 0).ok()
}

/// `2026-12-25`, or the first and last day of a span: `2026-12-24..2027-01-01`.
fn parse_days_off(text: &str) -> Result<(Date, Date), String> {
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    match (first.trim().parse::<Date>(), last.trim().parse::<Date>()) {
        (Ok(first), Ok(last)) if first <= last => Ok((first, last)),
        _ => Err(format!("\"{}\" is no day", text.escape_debug())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn berlin() -> TimeZone {
        TimeZone::get("Europe/Berlin").unwrap()
    }

    fn calendar(hours: &str, days_off: &[&str]) -> WorkCalendar {
        let days_off: Vec<String> = days_off.iter().map(|day| (*day).to_owned()).collect();
        WorkCalendar::parse(hours, &days_off).unwrap()
    }

    /// The next moment, as people write it, for a moment in the zone of Berlin.
    fn next(calendar: &WorkCalendar, at: &str) -> String {
        let at: jiff::civil::DateTime = at.parse().unwrap();
        let open = calendar.next_open(at.to_zoned(berlin()).unwrap().timestamp(), &berlin());
        open.map_or("never".to_owned(), |open| open.to_zoned(berlin()).strftime("%F %R %Z").to_string())
    }

    #[test]
    fn prints_begin_in_the_hours_of_the_week_and_not_on_days_off() {
        let week = calendar("Mon-Fri 6-22, Sat 8:30-12", &["2026-12-25", "2026-12-28..2027-01-01"]);
        assert_eq!(next(&week, "2026-11-25T07:15"), "2026-11-25 07:15 CET");
        assert_eq!(next(&week, "2026-11-25T05:00"), "2026-11-25 06:00 CET");
        assert_eq!(next(&week, "2026-11-25T22:00"), "2026-11-26 06:00 CET", "the end is not in it");
        assert_eq!(next(&week, "2026-11-27T23:00"), "2026-11-28 08:30 CET");
        assert_eq!(next(&week, "2026-11-28T12:00"), "2026-11-30 06:00 CET");
        assert_eq!(next(&week, "2026-12-24T22:30"), "2026-12-26 08:30 CET");
        assert_eq!(next(&week, "2026-12-26T13:00"), "2027-01-02 08:30 CET");
    }

    #[test]
    fn the_last_moment_in_which_a_print_begins_is_in_the_hours_before() {
        let week = calendar("Mon-Fri 6-22, Sat 22-2", &["2026-12-25"]);
        let last = |at: &str| {
            let at: jiff::civil::DateTime = at.parse().unwrap();
            let open = week.last_open(at.to_zoned(berlin()).unwrap().timestamp(), &berlin()).unwrap();
            open.to_zoned(berlin()).strftime("%F %T").to_string()
        };
        assert_eq!(last("2026-11-25T07:15"), "2026-11-25 07:15:00");
        assert_eq!(last("2026-11-25T05:00"), "2026-11-24 21:59:59");
        assert_eq!(last("2026-11-29T01:00"), "2026-11-29 01:00:00", "the night of Saturday");
        assert_eq!(last("2026-11-30T05:00"), "2026-11-29 01:59:59");
        assert_eq!(last("2026-12-25T12:00"), "2026-12-24 21:59:59");
        let never = calendar("Mon 6-7", &["2020-01-01..2030-01-01"]);
        let in_it: Timestamp = "2026-11-25T12:00:00Z".parse().unwrap();
        assert_eq!(never.last_open(in_it, &berlin()), None);
    }

    #[test]
    fn the_spans_in_which_no_print_begins_are_those_between_the_hours() {
        let week = calendar("Fri 22-2, Mon-Fri 6-22", &["2026-11-30"]);
        let at = |text: &str| text.parse::<jiff::civil::DateTime>().unwrap().to_zoned(berlin()).unwrap().timestamp();
        let closed = |from: &str, to: &str| {
            let shown = |at: Timestamp| at.to_zoned(berlin()).strftime("%a %R").to_string();
            let spans = week.closed_spans(at(from), at(to), &berlin());
            spans.into_iter().map(|(start, end)| format!("{} {}", shown(start), shown(end))).collect::<Vec<_>>()
        };
        let all = ["Thu 22:00 Fri 06:00", "Sat 02:00 Tue 06:00", "Tue 22:00 Wed 01:00"];
        assert_eq!(closed("2026-11-26T12:00", "2026-12-02T01:00"), all);
        assert_eq!(closed("2026-11-28T12:00", "2026-11-29T12:00"), ["Sat 12:00 Sun 12:00"]);
        assert!(closed("2026-11-28T01:00", "2026-11-28T02:00").is_empty(), "the night of Friday");
        assert!(
            calendar("always", &[]).closed_spans(at("2026-11-28T01:00"), at("2026-11-29T02:00"), &berlin()).is_empty()
        );
    }

    #[test]
    fn hours_are_those_of_the_day_also_where_the_clocks_change() {
        let week = calendar("Mon-Sun 6-22", &[]);
        assert_eq!(next(&week, "2026-03-28T22:30"), "2026-03-29 06:00 CEST");
        assert_eq!(next(&week, "2026-10-24T22:30"), "2026-10-25 06:00 CET");
        let hours_until = |at: &str| {
            let at = at.parse::<jiff::civil::DateTime>().unwrap().to_zoned(berlin()).unwrap().timestamp();
            week.next_open(at, &berlin()).unwrap().duration_since(at).as_hours()
        };
        assert_eq!((hours_until("2026-03-28T22:00"), hours_until("2026-10-24T22:00")), (7, 9));
        assert_eq!(
            next(&calendar("Sun 2:30-3", &[]), "2026-03-29T00:00"),
            "2026-04-05 02:30 CEST",
            "all of it is skipped"
        );
        // 02:30 is skipped on that day.
        assert_eq!(next(&calendar("Sun 2:30-8", &[]), "2026-03-29T00:00"), "2026-03-29 03:30 CEST");
    }

    #[test]
    fn hours_over_midnight_belong_to_the_day_on_which_they_begin() {
        let night = calendar("Fri-Sun 22-6", &["2026-11-28"]);
        assert_eq!(next(&night, "2026-11-28T03:00"), "2026-11-28 03:00 CET", "of Friday");
        assert_eq!(next(&night, "2026-11-28T23:00"), "2026-11-29 22:00 CET");
        assert_eq!(next(&night, "2026-11-30T06:00"), "2026-12-04 22:00 CET");
    }

    #[test]
    fn without_hours_prints_begin_at_any_time_and_after_the_days_off() {
        assert_eq!(next(&calendar("always", &[]), "2026-11-28T03:07"), "2026-11-28 03:07 CET");
        assert_eq!(next(&calendar("always", &["2026-11-28"]), "2026-11-28T03:07"), "2026-11-29 00:00 CET");
        assert_eq!(next(&calendar("Sat", &[]), "2026-11-28T23:59"), "2026-11-28 23:59 CET");
        assert_eq!(next(&calendar("Sat-Sun 0-24", &[]), "2026-11-30T00:00"), "2026-12-05 00:00 CET");
        assert_eq!(next(&calendar("Mon 6-22", &["2020-01-01..2040-01-01"]), "2026-11-30T00:00"), "never");
    }

    #[test]
    fn what_is_no_calendar_is_named() {
        for hours in ["", "Mon-Fri 6", "Mo 6-22", "Mon 6-25", "Mon 6-22 Tue", "6-22", "Mon 6:60-7", "Mon +6-22"] {
            assert!(WorkCalendar::parse(hours, &[]).is_err(), "{hours}");
        }
        for day in ["", "24.12.", "2026-02-30", "2026-12-26..2026-12-24"] {
            assert!(WorkCalendar::parse("always", &[day.to_owned()]).is_err(), "{day}");
        }
    }
}
