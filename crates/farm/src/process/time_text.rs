//! The line in `STATUS.txt` that shows whether the file is current.

use jiff::Timestamp;
use language::say;
use ledger::UtcTimestamp;
use settings::FarmZone;

/// The line in `STATUS.txt` that shows whether the file is current, and the values for `status.json`.
pub(crate) fn written_stamp(scan_secs: f64, zone: &FarmZone) -> (String, Timestamp, u64) {
    // A scan of very many files takes time too.
    let minutes = (scan_secs / 60.0).ceil() as u64 + 1;
    let now = floor_to_minute(Timestamp::now());
    let line = say!("status-stamp", time = zone.format_minute(now), minutes = minutes) + "\n";
    (line, now, 60 * minutes)
}

/// A time down to the minute, unless it is the end of all time.
pub(crate) fn known_minute(time: Timestamp) -> Option<UtcTimestamp> {
    (time < Timestamp::MAX).then(|| UtcTimestamp(floor_to_minute(time)))
}

/// Rounds down to the minute: an unchanged status is written at most once a minute.
pub(crate) fn floor_to_minute(time: Timestamp) -> Timestamp {
    Timestamp::from_second(time.as_second().div_euclid(60) * 60).unwrap_or(time)
}
