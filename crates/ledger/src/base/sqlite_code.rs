//! The result codes of SQLite that tell one failure from another.

/// The statement does not fit the database.
pub const SQLITE_ERROR: i64 = 1;
/// Another connection holds the lock.
pub const SQLITE_BUSY: i64 = 5;
/// The disk failed.
pub const SQLITE_IOERR: i64 = 10;
/// The disk is full.
pub const SQLITE_FULL: i64 = 13;
/// The file or the connection cannot be written.
pub const SQLITE_READONLY: i64 = 8;
/// A page has invalid content.
pub const SQLITE_CORRUPT: i64 = 11;
/// The file is no database at all.
pub const SQLITE_NOTADB: i64 = 26;

/// SQLite's primary result code of an error, whatever its extended form.
pub fn sqlite_code(error: &sqlx::Error) -> Option<i64> {
    // Those of PostgreSQL have five characters, also where all are digits.
    let code = error.as_database_error()?.code().filter(|code| code.len() < 5)?;
    Some(code.parse::<i64>().ok()? & 0xff)
}

/// Why a query failed, with the remedy where there is one.
pub fn query_failure(error: &sqlx::Error) -> String {
    match sqlite_code(error) {
        Some(SQLITE_BUSY) => "another process holds the ledger. Try again when that has ended".to_owned(),
        Some(SQLITE_FULL) => "the disk is full. Free some room on the disk of the state folder".to_owned(),
        _ => error.to_string(),
    }
}
