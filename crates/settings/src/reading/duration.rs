//! Durations as people write them: a number of seconds, or "90s", "10m", "24h", "7d", "1h30m".

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{Error, Visitor},
};

/// Seconds in a unit; the empty name is a plain number.
const UNITS: [(&str, f64); 8] = [
    ("", 1.0),
    ("ms", 0.001),
    ("s", 1.0),
    ("m", 60.0),
    ("min", 60.0),
    ("h", 3600.0),
    ("d", 86_400.0),
    ("w", 604_800.0),
];

/// Reads a duration, in seconds: a plain number, or numbers with the units ms, s, m (or min), h, d, w, as in "1h30m".
///
/// A message for people if the text is not a duration.
pub fn parse_secs(text: &str) -> Result<f64, String> {
    let wrong = || {
        format!(
            "\"{}\" is not a duration; write seconds, or for example \"90s\", \"10m\", \"24h\"",
            text.escape_debug()
        )
    };
    let mut rest = text.trim();
    let mut total_secs = 0.0;
    let mut plain = false;
    while !rest.is_empty() {
        let digits = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        let number: f64 = rest[..digits].parse().map_err(|_| wrong())?;
        rest = rest[digits..].trim_start();
        let letters = rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(rest.len());
        let &(unit, secs) = UNITS.iter().find(|(unit, _)| *unit == &rest[..letters]).ok_or_else(wrong)?;
        rest = rest[letters..].trim_start();
        if plain || (unit.is_empty() && !(rest.is_empty() && total_secs == 0.0)) {
            return Err(wrong()); // "1h 30" could mean minutes or seconds
        }
        plain = unit.is_empty();
        total_secs += number * secs;
    }
    if text.trim().is_empty() { Err(wrong()) } else { Ok(total_secs) }
}

/// A duration in a configuration file, seconds.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(crate) struct DurationSecs(pub f64);

impl<'de> Deserialize<'de> for DurationSecs {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(DurationVisitor)
    }
}

impl Serialize for DurationSecs {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.0)
    }
}

struct DurationVisitor;

impl Visitor<'_> for DurationVisitor {
    type Value = DurationSecs;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number of seconds or a duration such as \"24h\"")
    }

    fn visit_i64<E: Error>(self, secs: i64) -> Result<DurationSecs, E> {
        Ok(DurationSecs(secs as f64))
    }

    fn visit_f64<E: Error>(self, secs: f64) -> Result<DurationSecs, E> {
        Ok(DurationSecs(secs))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<DurationSecs, E> {
        parse_secs(text).map(DurationSecs).map_err(E::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_read_as_people_write_them() {
        for (text, secs) in [
            ("90", 90.0),
            ("0.5", 0.5),
            ("90s", 90.0),
            ("10m", 600.0),
            ("10 min", 600.0),
            ("24h", 86_400.0),
            ("7d", 604_800.0),
            ("1h30m", 5400.0),
            ("1h 30m", 5400.0),
            ("200ms", 0.2),
        ] {
            assert_eq!(parse_secs(text), Ok(secs), "{text}");
        }
    }

    #[test]
    fn what_is_no_duration_is_refused() {
        for text in ["", " ", "h", "ten", "10x", "-5", "1h30", "30 1h", "1..5s", "10M", "5 5"] {
            assert!(parse_secs(text).is_err(), "{text} gave {:?}", parse_secs(text));
        }
    }
}
