//! A ticket: what the customer says about a part beside it, `part.stl.toml` or `part.stl.json`.

use jiff::{Timestamp, civil, tz::TimeZone};
use thiserror::Error;

use crate::{format::Unit, nest::OrientationRule};

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
    /// Two sidecars for one part.
    #[error("there are two tickets for one part, {first} and {second}; leave one")]
    Two {
        /// The first, escaped.
        first: String,
        /// The second, escaped.
        second: String,
    },
}

impl Ticket {
    /// Reads a TOML ticket; `file` is its display name, for errors.
    pub fn from_toml(_text: &str, _file: &str) -> Result<Self, TicketError> {
        Ok(Self::default())
    }

    /// Reads a JSON ticket; `file` is its display name, for errors.
    pub fn from_json(_text: &str, _file: &str) -> Result<Self, TicketError> {
        Ok(Self::default())
    }
}
