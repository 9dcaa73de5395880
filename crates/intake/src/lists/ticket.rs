//! A ticket: the customer's instructions for the part beside it, `part.stl.toml` or `part.stl.json`.

use std::borrow::Cow;

use build_file::{
    LengthUnit, check_clearance, check_copies, check_email, check_finish, check_name, check_note, check_priority,
    escape_invisible_lines,
};
use nester::{FaceNotDown, MAX_TILTS, OrientationRule, TiltLimit};
use serde::Deserialize;
use thiserror::Error;

use super::list_cells::parse_due_cell;
use crate::names::due_date::{DueDate, parse_due};

/// The fields of a ticket. `None` = the ticket does not set the field.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Ticket {
    /// Copies, 1 to 10 000.
    pub copies: Option<u32>,
    /// Name of the order. If not set, the sub-folder is the order.
    pub order: Option<String>,
    /// Who it is for.
    pub customer: Option<String>,
    /// Where that customer gets e-mail.
    pub email: Option<String>,
    /// What it is to be made of.
    pub material: Option<String>,
    /// Finishing steps after the print.
    pub finish: Option<String>,
    /// When it is due.
    pub due: Option<DueDate>,
    /// Priority from 0 to 100. A part with 100 must be in the next build.
    pub priority: Option<u8>,
    /// How the part may be turned.
    pub orientation: Option<OrientationRule>,
    /// Directions of the mesh that must point nearly straight up.
    pub keep_up: Option<Vec<TiltLimit>>,
    /// Faces, by their outward normals, that must not face down.
    pub not_down: Option<Vec<FaceNotDown>>,
    /// The part's own clearance, mm.
    pub clearance_mm: Option<f64>,
    /// Unit of the file.
    pub unit: Option<LengthUnit>,
    /// Note for people.
    pub note: Option<String>,
    /// Whether a mesh that is not closed may be mended.
    pub mend: Option<bool>,
}

/// Why a ticket cannot be used. Its part is then refused, because its number of copies is unknown.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
pub enum TicketError {
    /// Its content is not valid.
    #[error("the ticket {file} cannot be read: {why}")]
    Broken {
        /// Its name, escaped.
        file: String,
        /// The reason, in plain words.
        why: String,
    },
    /// The operating system could not read the file; the ticket itself may be valid.
    #[error("the ticket {file} cannot be read: {}", std::io::Error::from_raw_os_error(*.errno))]
    Unreadable {
        /// Its name, escaped.
        file: String,
        /// The error code of the operating system.
        errno: i32,
    },
    /// There is an order list that does not name the part.
    #[error("{0}")]
    Unlisted(String),
    /// Two sidecars for one part.
    #[error("there are two tickets for one part, {first} and {second}; leave one")]
    Duplicate {
        /// The first, escaped.
        first: String,
        /// The second, escaped.
        second: String,
    },
}

/// The fields of a ticket file before validation.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TicketFields {
    copies: Option<toml::Value>,
    order: Option<toml::Value>,
    customer: Option<toml::Value>,
    email: Option<String>,
    material: Option<toml::Value>,
    finish: Option<String>,
    /// A string, or a date of TOML's own.
    due: Option<toml::Value>,
    priority: Option<toml::Value>,
    orientation: Option<OrientationRule>,
    keep_up: Option<Vec<TiltLimit>>,
    not_down: Option<Vec<FaceNotDown>>,
    clearance_mm: Option<toml::Value>,
    unit: Option<LengthUnit>,
    note: Option<String>,
    mend: Option<bool>,
}

/// How the file of a ticket is written, for the remedies in its errors.
#[derive(Debug, Clone, Copy)]
enum TicketSyntax {
    Toml,
    Json,
}

impl TicketSyntax {
    /// A field as it is to be written.
    fn field(self, word: &str, value: &str) -> String {
        match self {
            Self::Toml => format!("{word} = {value}"),
            Self::Json => format!("{word:?}: {value}"),
        }
    }
}

impl Ticket {
    /// Reads a TOML ticket; `file` is its display name, for errors.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, TicketError> {
        let words = toml::from_str(&with_plain_dates(strip_bom(text)))
            .map_err(|error| broken_ticket(file, error.to_string()))?;
        Self::from_fields(words, TicketSyntax::Toml).map_err(|why| broken_ticket(file, why))
    }

    /// Reads a JSON ticket; `file` is its display name, for errors.
    pub fn from_json(text: &str, file: &str) -> Result<Self, TicketError> {
        let words = serde_json::from_str(strip_bom(text)).map_err(|error| broken_ticket(file, error.to_string()))?;
        Self::from_fields(words, TicketSyntax::Json).map_err(|why| broken_ticket(file, why))
    }

    /// Fills the fields that this ticket does not set from a ticket with lower precedence.
    pub fn merge_weaker(self, weaker: Self) -> Self {
        Self {
            copies: self.copies.or(weaker.copies),
            order: self.order.or(weaker.order),
            customer: self.customer.or(weaker.customer),
            email: self.email.or(weaker.email),
            material: self.material.or(weaker.material),
            finish: self.finish.or(weaker.finish),
            due: self.due.or(weaker.due),
            priority: self.priority.or(weaker.priority),
            orientation: self.orientation.or(weaker.orientation),
            keep_up: self.keep_up.or(weaker.keep_up),
            not_down: self.not_down.or(weaker.not_down),
            clearance_mm: self.clearance_mm.or(weaker.clearance_mm),
            unit: self.unit.or(weaker.unit),
            note: self.note.or(weaker.note),
            mend: self.mend.or(weaker.mend),
        }
    }

    fn from_fields(words: TicketFields, syntax: TicketSyntax) -> Result<Self, String> {
        Ok(Self {
            copies: words.copies.map(|value| check_copies(whole_number("copies", value, syntax)?)).transpose()?,
            order: words.order.map(|order| parse_name("order", order)).transpose()?,
            customer: words.customer.map(|customer| parse_name("customer", customer)).transpose()?,
            email: words.email.as_deref().map(check_email).transpose()?,
            material: words.material.map(|material| parse_name("material", material)).transpose()?,
            finish: words.finish.as_deref().map(check_finish).transpose()?,
            due: words.due.map(parse_due_value).transpose()?,
            priority: words
                .priority
                .map(|value| check_priority(whole_number("priority", value, syntax)?))
                .transpose()?,
            orientation: words.orientation,
            keep_up: words.keep_up.map(|tilts| check_directions("keep_up", tilts)).transpose()?,
            not_down: words.not_down.map(|faces| check_directions("not_down", faces)).transpose()?,
            clearance_mm: words
                .clearance_mm
                .map(|value| check_clearance(parse_number("clearance_mm", value, syntax)?))
                .transpose()?,
            unit: words.unit,
            note: words.note.as_deref().map(check_note).transpose()?,
            mend: words.mend,
        })
    }
}

/// Parses a whole number. For a number in quotes, the error shows how to write it.
fn whole_number(word: &str, value: toml::Value, syntax: TicketSyntax) -> Result<i64, String> {
    match value {
        toml::Value::Integer(number) => Ok(number),
        toml::Value::String(text) => Err(quoted_number_error::<i64>(word, &text, syntax)),
        other => Err(format!("{word} = {other}; it must be a whole number such as 10")),
    }
}

fn parse_number(word: &str, value: toml::Value, syntax: TicketSyntax) -> Result<f64, String> {
    match value {
        toml::Value::Integer(number) => Ok(number as f64),
        toml::Value::Float(number) => Ok(number),
        toml::Value::String(text) => Err(quoted_number_error::<f64>(word, &text, syntax)),
        other => Err(format!("{word} = {other}; it must be a number such as 2.5")),
    }
}

fn quoted_number_error<N: std::str::FromStr>(word: &str, text: &str, syntax: TicketSyntax) -> String {
    match text.trim().parse::<N>() {
        Ok(_) => {
            let mended = syntax.field(word, text.trim());
            format!("{word} = {text:?} is text; write it without the quotes: {mended}")
        }
        Err(_) => format!("{word} = {text:?}; it must be a number without quotes, such as 10"),
    }
}

/// Accepts a number as a name, because many orders and customers are named by a number.
fn parse_name(word: &str, value: toml::Value) -> Result<String, String> {
    let name = match value {
        toml::Value::String(name) => name,
        toml::Value::Integer(number) => number.to_string(),
        other => return Err(format!("{word} = {other}; write its name in quotes, such as {word} = \"1042\"")),
    };
    check_name(word, &name)
}

/// Puts a due date as people write it, `due = 31.12.2026`, into quotes, which TOML wants around it.
fn with_plain_dates(text: &str) -> Cow<'_, str> {
    let is_plain = |value: &str| {
        value.starts_with(|c: char| c.is_ascii_digit()) && value.contains('.') && parse_due_cell(value).is_ok()
    };
    let quoted = |line: &str| {
        let (word, value) = line.split_once('=')?;
        let value = value.split('#').next().unwrap_or_default().trim();
        (word.trim() == "due" && is_plain(value)).then(|| format!("due = {value:?}"))
    };
    if !text.lines().any(|line| quoted(line).is_some()) {
        return text.into();
    }
    let lines: Vec<String> = text.lines().map(|line| quoted(line).unwrap_or_else(|| line.to_owned())).collect();
    lines.join("\n").into()
}

fn strip_bom(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

pub(crate) fn broken_ticket(file: &str, why: impl Into<String>) -> TicketError {
    TicketError::Broken { file: file.to_owned(), why: escape_invisible_lines(why.into().trim_end()) }
}

fn check_directions<T>(word: &str, directions: Vec<T>) -> Result<Vec<T>, String> {
    match directions.len() <= MAX_TILTS {
        true => Ok(directions),
        false => Err(format!("{word} names {} directions; at most {MAX_TILTS} are taken", directions.len())),
    }
}

fn parse_due_value(value: toml::Value) -> Result<DueDate, String> {
    match value {
        toml::Value::String(text) => parse_due(&text).or_else(|why| parse_due_cell(&text).map_err(|_| why)),
        toml::Value::Datetime(time) => parse_due(&time.to_string()),
        other => {
            Err(format!("due = {other}; it must be a date such as 2026-11-25 or a time such as 2026-11-25T17:00:00Z"))
        }
    }
}

#[cfg(test)]
mod tests {
    use build_file::MAX_TEXT_BYTES;
    use jiff::civil;

    use super::*;

    #[test]
    fn every_word_of_a_ticket_is_read_in_toml_and_json() {
        let toml = "copies = 10\norder = \"A-7\"\ncustomer = \"Brandt\"\nemail = \"anna@brandt.example\"\nmaterial = \"PA12\"\nfinish = \"dye black; smooth\"\ndue = 2026-11-25\npriority = 100\norientation = \"upright\"\n\
                    keep_up = [{ direction = [0, 0, 1], within_deg = 30 }]\nnot_down = [[1, 0, 0]]\nclearance_mm = 2\nunit = \"inch\"\nnote = \"für Jörg\"\nmend = true\n";
        let json = r#"{"copies":10,"order":"A-7","customer":"Brandt","email":"anna@brandt.example","material":"PA12","finish":"dye black, smooth","due":"2026-11-25","priority":100,"orientation":"upright",
                       "keep_up":[{"direction":[0,0,1],"within_deg":30}],
                       "not_down":[{"direction":[1,0,0],"spare_deg":45}],
                       "clearance_mm":2,"unit":"in","note":"für Jörg","mend":true}"#;
        let expected = Ticket {
            copies: Some(10),
            order: Some("A-7".into()),
            customer: Some("Brandt".into()),
            email: Some("anna@brandt.example".into()),
            material: Some("PA12".into()),
            finish: Some("dye black, smooth".into()),
            due: Some(DueDate::Day(civil::date(2026, 11, 25))),
            priority: Some(100),
            orientation: Some(OrientationRule::Upright),
            keep_up: Some(vec![TiltLimit::new(glam::DVec3::Z, 30.0).unwrap()]),
            not_down: Some(vec![FaceNotDown::new(glam::DVec3::X, 45.0).unwrap()]),
            clearance_mm: Some(2.0),
            unit: Some(LengthUnit::Inch),
            note: Some("für Jörg".into()),
            mend: Some(true),
        };
        assert_eq!(Ticket::from_toml(toml, "t").unwrap(), expected);
        assert_eq!(Ticket::from_json(&format!("\u{feff}{json}"), "t").unwrap(), expected);
        assert_eq!(Ticket::from_toml("", "t").unwrap(), Ticket::default());
        let numbers = Ticket::from_json("{\"order\":1042,\"customer\":7}", "t").unwrap();
        assert_eq!((numbers.order.as_deref(), numbers.customer.as_deref()), (Some("1042"), Some("7")));
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
            ("customer = true", "customer = \"1042\""),
            ("email = \"Anna Brandt\"", "name@example.org"),
            ("priority = 101", "0 to 100"),
            ("priority = -1", "0 to 100"),
            ("orientation = \"sideways\"", "sideways"),
            ("keep_up = [{ direction = [0, 0, 0], within_deg = 30 }]", "not all 0"),
            ("keep_up = [{ direction = [0, 0, 1], within_deg = 200 }]", "0 to 180"),
            ("keep_up = [[0, 0, 1]]", "keep_up"),
            ("not_down = [0, 0, 1]", "a direction like"),
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
    fn dates_of_toml_itself_are_read() {
        let ticket = Ticket::from_toml("due = 2026-11-25T17:00:00-05:00", "t").unwrap();
        assert_eq!(ticket.due, Some(parse_due("2026-11-25T22:00:00Z").unwrap()));
        assert!(matches!(Ticket::from_toml("due = 2026-11-25 17:00:00", "t").unwrap().due, Some(DueDate::Local(_))));
    }

    #[test]
    fn dates_as_people_write_them_are_read_and_json_is_mended_as_json() {
        for due in ["31.12.2026", "\"31.12.2026\"", "31.12.2026 # bald"] {
            let ticket = Ticket::from_toml(&format!("copies = 2\ndue = {due}\n"), "t").unwrap();
            assert_eq!((ticket.due, ticket.copies), (Some(parse_due("2026-12-31").unwrap()), Some(2)), "{due}");
        }
        let why = Ticket::from_json("{\"copies\":\"2\"}", "t").unwrap_err().to_string();
        assert!(why.ends_with("write it without the quotes: \"copies\": 2"), "{why}");
    }

    #[test]
    fn a_stronger_ticket_wins_word_by_word() {
        let strong = Ticket { copies: Some(2), ..Default::default() };
        let weak = Ticket { copies: Some(9), priority: Some(70), ..Default::default() };
        assert_eq!(strong.merge_weaker(weak), Ticket { copies: Some(2), priority: Some(70), ..Default::default() });
    }
}
