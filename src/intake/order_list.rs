//! Order lists: an `order.csv` says copies, due date, priority and orientation for the files of its own folder.

use std::{io, path::Path};

use super::Seen;

/// What became of an order list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ListEnd {
    /// It stays: files that it names are still to come, or parts of its folder still settle.
    Awaited,
    /// Every row's file was claimed; the list is in the archive.
    Archived,
    /// It is in the error folder, with this reason.
    Refused(String),
}

/// Ends an order list when its time has come: archives it when all its files were claimed, refuses it when the others
/// did not come for `orphan_secs`. Call it for each [`Ready::List`](super::Ready::List).
pub fn end_list(
    _inbox: &Path,
    _list: &Seen,
    _quiet_secs: f64,
    _orphan_secs: f64,
    _archive_dir: &Path,
    _error_dir: &Path,
) -> io::Result<ListEnd> {
    Ok(ListEnd::Awaited)
}
