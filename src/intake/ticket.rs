//! A ticket: what the customer says about a part beside it, `part.stl.toml` or `part.stl.json`.

use build_file::{Unit, visible, visible_lines};
use jiff::{Timestamp, civil, tz::TimeZone};
use nester::{MAX_TILTS, NotDown, OrientationRule, Tilt};
use serde::Deserialize;
use thiserror::Error;

use super::copies::MAX_COPIES;

/// More than this around a part is no clearance but a slip of the unit.
const MAX_CLEARANCE_MM: f64 = 100.0;
/// Of an order's name or a note.
const MAX_TEXT_BYTES: usize = 4096;
/// Years of due dates; the ledger's times sort as text as long as their years have four digits.
const YEARS: std::ops::RangeInclusive<i16> = 1970..=9998;

/// When a part is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Due {
    /// By the end of a day.
    Day(civil::Date),
    /// At a local time.
    Local(civil::DateTime),
    /// At an instant.
    At(Timestamp),
}

impl Due {
    /// The instant, in the farm's time zone.
    pub fn at(self, zone: &TimeZone) -> Result<Timestamp, jiff::Error> {
        match self {
            Self::At(instant) => Ok(instant),
            Self::Local(time) => Ok(time.to_zoned(zone.clone())?.timestamp()),
            Self::Day(day) => Ok(day.tomorrow()?.to_zoned(zone.clone())?.timestamp()),
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

/// What a ticket says; `None` = it says nothing about that.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Ticket {
    /// Copies, 1 to 10 000.
    pub copies: Option<u32>,
    /// Name of the order; else the sub-folder is it.
    pub order: Option<String>,
    /// When it is due.
    pub due: Option<Due>,
    /// 0 to 100; 100 must be in the next build.
    pub priority: Option<u8>,
    /// How the part may be turned.
    pub orientation: Option<OrientationRule>,
    /// Directions of the mesh that must stand near to straight up.
    pub keep_up: Option<Vec<Tilt>>,
    /// Faces, by their outward normals, that must not look down.
    pub not_down: Option<Vec<NotDown>>,
    /// The part's own clearance, mm.
    pub clearance_mm: Option<f64>,
    /// Unit of the file.
    pub unit: Option<Unit>,
    /// For people.
    pub note: Option<String>,
}

/// Why a ticket cannot be used; its part is refused with it, for its copies are not known.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
pub enum TicketError {
    /// It says something that nestd does not understand.
    #[error("the ticket {file} cannot be read: {why}")]
    Broken {
        /// Its name, escaped.
        file: String,
        /// In plain words.
        why: String,
    },
    /// The disk failed or denied it, not the ticket.
    #[error("the ticket {file} cannot be read: {}", std::io::Error::from_raw_os_error(*.errno))]
    Unreadable {
        /// Its name, escaped.
        file: String,
        /// The error of the system.
        errno: i32,
    },
    /// There is an order list, and it does not name the part.
    #[error("{0}")]
    Unlisted(String),
    /// Two sidecars for one part.
    #[error("there are two tickets for one part, {first} and {second}; leave one")]
    Two {
        /// The first, escaped.
        first: String,
        /// The second, escaped.
        second: String,
    },
}

/// The words of a ticket file as they stand there.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Words {
    copies: Option<toml::Value>,
    order: Option<toml::Value>,
    /// A string, or a date of TOML's own.
    due: Option<toml::Value>,
    priority: Option<toml::Value>,
    orientation: Option<OrientationRule>,
    keep_up: Option<Vec<Tilt>>,
    not_down: Option<Vec<NotDown>>,
    clearance_mm: Option<toml::Value>,
    unit: Option<Unit>,
    note: Option<String>,
}

impl Ticket {
    /// Reads a TOML ticket; `file` is its display name, for errors.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, TicketError> {
        let words = toml::from_str(without_bom(text)).map_err(|error| broken(file, error.to_string()))?;
        Self::check(words).map_err(|why| broken(file, why))
    }

    /// Reads a JSON ticket; `file` is its display name, for errors.
    pub fn from_json(text: &str, file: &str) -> Result<Self, TicketError> {
        let words = serde_json::from_str(without_bom(text)).map_err(|error| broken(file, error.to_string()))?;
        Self::check(words).map_err(|why| broken(file, why))
    }

    /// What this ticket does not say is taken from a weaker one.
    pub fn or(self, weaker: Self) -> Self {
        Self {
            copies: self.copies.or(weaker.copies),
            order: self.order.or(weaker.order),
            due: self.due.or(weaker.due),
            priority: self.priority.or(weaker.priority),
            orientation: self.orientation.or(weaker.orientation),
            keep_up: self.keep_up.or(weaker.keep_up),
            not_down: self.not_down.or(weaker.not_down),
            clearance_mm: self.clearance_mm.or(weaker.clearance_mm),
            unit: self.unit.or(weaker.unit),
            note: self.note.or(weaker.note),
        }
    }

    fn check(words: Words) -> Result<Self, String> {
        Ok(Self {
            copies: words.copies.map(|value| copies(whole("copies", value)?)).transpose()?,
            order: words.order.map(|order| text("order", visible(&order_name(order)?))).transpose()?,
            due: words.due.map(due_of_value).transpose()?,
            priority: words.priority.map(|value| priority(whole("priority", value)?)).transpose()?,
            orientation: words.orientation,
            keep_up: words.keep_up.map(|tilts| few("keep_up", tilts)).transpose()?,
            not_down: words.not_down.map(|faces| few("not_down", faces)).transpose()?,
            clearance_mm: words.clearance_mm.map(|value| clearance(number("clearance_mm", value)?)).transpose()?,
            unit: words.unit,
            note: words.note.map(|note| text("note", visible_lines(&note))).transpose()?,
        })
    }
}

/// A whole number; one in quotes is told how to write it.
fn whole(word: &str, value: toml::Value) -> Result<i64, String> {
    match value {
        toml::Value::Integer(number) => Ok(number),
        toml::Value::String(text) => Err(quoted::<i64>(word, &text)),
        other => Err(format!("{word} = {other}; it must be a whole number such as 10")),
    }
}

fn number(word: &str, value: toml::Value) -> Result<f64, String> {
    match value {
        toml::Value::Integer(number) => Ok(number as f64),
        toml::Value::Float(number) => Ok(number),
        toml::Value::String(text) => Err(quoted::<f64>(word, &text)),
        other => Err(format!("{word} = {other}; it must be a number such as 2.5")),
    }
}

fn quoted<N: std::str::FromStr>(word: &str, text: &str) -> String {
    match text.trim().parse::<N>() {
        Ok(_) => format!("{word} = {text:?} is text; write it without the quotes: {word} = {}", text.trim()),
        Err(_) => format!("{word} = {text:?}; it must be a number without quotes, such as 10"),
    }
}

/// Many orders have numbers for names.
fn order_name(value: toml::Value) -> Result<String, String> {
    match value {
        toml::Value::String(name) => Ok(name),
        toml::Value::Integer(number) => Ok(number.to_string()),
        other => Err(format!("order = {other}; write its name in quotes, such as order = \"1042\"")),
    }
}

fn without_bom(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

pub(super) fn broken(file: &str, why: impl Into<String>) -> TicketError {
    TicketError::Broken { file: file.to_owned(), why: visible_lines(why.into().trim_end()) }
}

pub(super) fn copies(copies: i64) -> Result<u32, String> {
    match u32::try_from(copies) {
        Ok(copies @ 1..=MAX_COPIES) => Ok(copies),
        _ => Err(format!("copies = {copies}; it must be 1 to {MAX_COPIES}")),
    }
}

pub(super) fn priority(priority: i64) -> Result<u8, String> {
    match u8::try_from(priority) {
        Ok(priority @ 0..=100) => Ok(priority),
        _ => Err(format!("priority = {priority}; it must be 0 to 100")),
    }
}

pub(super) fn clearance(clearance_mm: f64) -> Result<f64, String> {
    match (0.0..=MAX_CLEARANCE_MM).contains(&clearance_mm) {
        true => Ok(clearance_mm),
        false => Err(format!("clearance_mm = {clearance_mm}; it must be 0 to {MAX_CLEARANCE_MM}")),
    }
}

fn few<T>(word: &str, directions: Vec<T>) -> Result<Vec<T>, String> {
    match directions.len() <= MAX_TILTS {
        true => Ok(directions),
        false => Err(format!("{word} names {} directions; at most {MAX_TILTS} are taken", directions.len())),
    }
}

pub(super) fn text(word: &str, text: String) -> Result<String, String> {
    match text.len() <= MAX_TEXT_BYTES {
        true => Ok(text),
        false => Err(format!("{word} is {} bytes long; at most {MAX_TEXT_BYTES} are taken", text.len())),
    }
}

fn due_of_value(value: toml::Value) -> Result<Due, String> {
    match value {
        toml::Value::String(text) => due(&text),
        toml::Value::Datetime(time) => due(&time.to_string()),
        other => {
            Err(format!("due = {other}; it must be a date such as 2026-11-25 or a time such as 2026-11-25T17:00:00Z"))
        }
    }
}

/// A date, a local time or an instant.
pub(super) fn due(text: &str) -> Result<Due, String> {
    let text = text.trim();
    let has_time = text.contains(['T', 't', ' ']);
    let parsed = match text.parse::<Timestamp>() {
        Ok(instant) => Ok(Due::At(instant)),
        Err(_) if has_time => text.parse().map(Due::Local),
        Err(_) => text.parse().map(Due::Day),
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
    fn every_word_of_a_ticket_is_read_in_toml_and_json() {
        let toml = "copies = 10\norder = \"A-7\"\ndue = 2026-11-25\npriority = 100\norientation = \"upright\"\n\
                    keep_up = [{ direction = [0, 0, 1], within_deg = 30 }]\nnot_down = [[1, 0, 0]]\nclearance_mm = 2\nunit = \"inch\"\nnote = \"für Jörg\"\n";
        let json = r#"{"copies":10,"order":"A-7","due":"2026-11-25","priority":100,"orientation":"upright",
                       "keep_up":[{"direction":[0,0,1],"within_deg":30}],
                       "not_down":[{"direction":[1,0,0],"spare_deg":45}],
                       "clearance_mm":2,"unit":"in","note":"für Jörg"}"#;
        let expected = Ticket {
            copies: Some(10),
            order: Some("A-7".into()),
            due: Some(Due::Day(civil::date(2026, 11, 25))),
            priority: Some(100),
            orientation: Some(OrientationRule::Upright),
            keep_up: Some(vec![Tilt::new(glam::DVec3::Z, 30.0).unwrap()]),
            not_down: Some(vec![NotDown::new(glam::DVec3::X, 45.0).unwrap()]),
            clearance_mm: Some(2.0),
            unit: Some(Unit::Inch),
            note: Some("für Jörg".into()),
        };
        assert_eq!(Ticket::from_toml(toml, "t").unwrap(), expected);
        assert_eq!(Ticket::from_json(&format!("\u{feff}{json}"), "t").unwrap(), expected);
        assert_eq!(Ticket::from_toml("", "t").unwrap(), Ticket::default());
        assert_eq!(Ticket::from_json("{\"order\":1042}", "t").unwrap().order.as_deref(), Some("1042"));
    }

    #[test]
    fn what_is_not_understood_is_an_error_that_names_it() {
        for (toml, said) in [
            ("copys = 3", "copys"),
            ("copies = 0", "1 to 10000"),
            ("copies = 10001", "10001"),
            ("copies = \"three\"", "copies"),
            ("copies = 1.5", "whole number"),
            ("copies = \"10\"", "without the quotes: copies = 10"),
            ("clearance_mm = \"2.5\"", "without the quotes: clearance_mm = 2.5"),
            ("order = 1.5", "in quotes"),
            ("priority = 101", "0 to 100"),
            ("priority = -1", "0 to 100"),
            ("orientation = \"sideways\"", "sideways"),
            ("keep_up = [{ direction = [0, 0, 0], within_deg = 30 }]", "not all 0"),
            ("keep_up = [{ direction = [0, 0, 1], within_deg = 200 }]", "0 to 180"),
            ("keep_up = [[0, 0, 1]]", "keep_up"),
            ("not_down = [0, 0, 1]", "a direction as in"),
            ("clearance_mm = nan", "clearance_mm"),
            ("clearance_mm = -1", "clearance_mm"),
            ("unit = \"parsec\"", "parsec"),
            ("due = \"tomorrow\"", "tomorrow"),
            ("due = 07:30:00", "due"),
            ("due = 5", "due"),
            // Found by fuzzing: a year below zero was written into the ledger and could not be read back.
            ("due = \"-0034920111\"", "1970 to 9998"),
            ("due = \"-000001-01-01T00:00:00Z\"", "1970 to 9998"),
            ("due = \"9999-12-31\"", "1970 to 9998"),
            ("due = 0000-01-01", "1970 to 9998"),
            ("copies = ", "line 1"),
        ] {
            let error = Ticket::from_toml(toml, "a.stl.toml").unwrap_err().to_string();
            assert!(error.contains(said) && error.contains("a.stl.toml"), "{toml}: {error}");
        }
        let long = format!("note = \"{}\"", "x".repeat(MAX_TEXT_BYTES + 1));
        assert!(Ticket::from_toml(&long, "t").is_err());
        assert!(Ticket::from_json("[1]", "t").is_err());
        assert!(Ticket::from_json("{\"copies\":1}{", "t").is_err());
    }

    #[test]
    fn a_day_is_due_at_its_end_and_a_local_time_in_the_zone_of_the_farm() {
        let zone = TimeZone::fixed(jiff::tz::offset(1));
        let at = |text: &str| due(text).unwrap().at(&zone).unwrap().to_string();
        assert_eq!(at("2026-11-25"), "2026-11-25T23:00:00Z");
        assert_eq!(at("2026-11-25T17:00"), "2026-11-25T16:00:00Z");
        assert_eq!(at("2026-11-25 17:00:00"), "2026-11-25T16:00:00Z");
        assert_eq!(at("2026-11-25T17:00:00Z"), "2026-11-25T17:00:00Z");
        assert_eq!(at("2026-11-25T17:00:00-05:00"), "2026-11-25T22:00:00Z");
    }

    #[test]
    fn dates_of_toml_itself_are_read() {
        let ticket = Ticket::from_toml("due = 2026-11-25T17:00:00-05:00", "t").unwrap();
        assert_eq!(ticket.due, Some(due("2026-11-25T22:00:00Z").unwrap()));
        assert!(matches!(Ticket::from_toml("due = 2026-11-25 17:00:00", "t").unwrap().due, Some(Due::Local(_))));
    }

    #[test]
    fn a_stronger_ticket_wins_word_by_word() {
        let strong = Ticket { copies: Some(2), ..Default::default() };
        let weak = Ticket { copies: Some(9), priority: Some(70), ..Default::default() };
        assert_eq!(strong.or(weak), Ticket { copies: Some(2), priority: Some(70), ..Default::default() });
    }
}
