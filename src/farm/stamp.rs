//! When something was written, as people read it.

use jiff::{Timestamp, tz::TimeZone};

use build_file::counted;

/// The line of `STATUS.txt` by which everybody sees whether it is of now, and the same for `status.json`.
pub(super) fn stamp(scan_secs: f64) -> (String, Timestamp, u64) {
    // A look through very many files takes its time too.
    let minutes = (scan_secs / 60.0).ceil() as u64 + 1;
    let now = minute(Timestamp::now());
    let line = format!(
        "Written {}, and anew at least every {} while nestd runs: where this is older, nobody looks here.\n",
        zoned(now),
        counted(minutes, "minute", "minutes")
    );
    (line, now, 60 * minutes)
}

/// To the minute: what says nothing new is not written within one.
pub(super) fn minute(time: Timestamp) -> Timestamp {
    Timestamp::from_second(time.as_second().div_euclid(60) * 60).unwrap_or(time)
}

/// Local, with its zone.
pub(super) fn zoned(time: Timestamp) -> String {
    time.to_zoned(TimeZone::system()).strftime("%Y-%m-%d %H:%M %Z").to_string()
}
