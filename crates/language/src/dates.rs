//! Dates and numbers as each language writes them.

use crate::{current, say};

/// A day of this year: `Fri 4 Dec`. `weekday` is 1 for Monday, `month` 1 for January.
pub fn day_text(weekday: i8, day: i8, month: i8) -> String {
    say!("date-day", weekday = weekday_name(weekday), day = day, month = month_name(month))
}

/// A day of another year: `4 Dec 2027`.
pub fn year_text(day: i8, month: i8, year: i16) -> String {
    say!("date-year", day = day, month = month_name(month), year = year.to_string())
}

/// A day in full: `Friday 4 December`, with the year if one is given.
pub fn long_day_text(weekday: i8, day: i8, month: i8, year: Option<i16>) -> String {
    let (weekday, month) = (say!("weekday-long", weekday = weekday), say!("month-long", month = month));
    match year {
        Some(year) => say!("date-long-year", weekday = weekday, day = day, month = month, year = year.to_string()),
        None => say!("date-long", weekday = weekday, day = day, month = month),
    }
}

/// A time of a day: `today 05:49`.
pub fn clock_text(day: String, clock: String) -> String {
    say!("date-clock", day = day, clock = clock)
}

/// A month: `October 2026`.
pub fn month_text(month: i8, year: i16) -> String {
    say!("date-month", month = say!("month-long", month = month), year = year.to_string())
}

fn month_name(month: i8) -> String {
    say!("month-short", month = month)
}

fn weekday_name(weekday: i8) -> String {
    say!("weekday-short", weekday = weekday)
}

/// A number that was written with a point, with the decimal sign of the language.
pub fn decimal(number: String) -> String {
    if current().has_decimal_comma() { number.replace('.', ",") } else { number }
}
