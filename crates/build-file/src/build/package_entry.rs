//! The entries of a ZIP package that is written, and its errors.

use jiff::{Timestamp, tz::TimeZone};
use zip::{CompressionMethod, DateTime, write::SimpleFileOptions};

use crate::{BuildFile, FileWriteError};

/// Deflate level: higher levels are several times slower for a few percent.
const DEFLATE_LEVEL: i64 = 3;

/// Entry dates are the build's creation time, so that the bytes do not depend on a clock.
pub(super) fn entry_options(build: &BuildFile) -> Result<SimpleFileOptions, FileWriteError> {
    let bad = |_| FileWriteError::Build(format!("its creation date {:?} is no RFC 3339 time", build.heading.created));
    let created: Timestamp = build.heading.created.parse().map_err(bad)?;
    let utc = created.to_zoned(TimeZone::UTC);
    let part = |n: i8| n.unsigned_abs();
    let date = DateTime::from_date_and_time(
        utc.year().unsigned_abs(),
        part(utc.month()),
        part(utc.day()),
        part(utc.hour()),
        part(utc.minute()),
        part(utc.second()),
    );
    Ok(SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(DEFLATE_LEVEL))
        .last_modified_time(date.unwrap_or_default()))
}

pub(super) fn package_error(error: zip::result::ZipError) -> FileWriteError {
    match error {
        zip::result::ZipError::Io(error) => FileWriteError::Io(error),
        other => FileWriteError::Package(other.to_string()),
    }
}
