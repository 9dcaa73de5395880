//! The marker in each folder, `.nestd-owner`: who serves the folder, or served it last.

use std::{
    fs::{self, OpenOptions},
    io::{self, Read},
    os::unix::fs::{FileExt, MetadataExt, OpenOptionsExt},
    path::Path,
};

use super::{lease_clock::LeaseTimestamp, lease_holder::LeaseHolder};

/// Name of the marker in each folder: a dot-file, which no scan and no printer takes.
pub(crate) const NAME: &str = ".nestd-owner";
/// Fixed length of the marker, so that a renewal is a single write that never shortens it.
pub(super) const BYTES: usize = 1024;

/// What the marker of a folder says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LeaseMarker {
    /// There is no marker.
    Missing,
    /// The marker names no daemon: a person has accepted the folder as it is, or a crash tore the file.
    NoHolder,
    /// The daemon that served the folder last.
    HeldBy(Box<LeaseHolder>),
}

/// Device and inode of a folder.
pub(super) fn folder_identity(folder: &Path) -> io::Result<(u64, u64)> {
    let meta = fs::metadata(folder)?;
    match meta.is_dir() {
        true => Ok((meta.dev(), meta.ino())),
        false => Err(io::ErrorKind::NotADirectory.into()),
    }
}

/// Reads the marker of a folder; an unreadable text counts as a marker without a holder.
pub(crate) fn read_marker(folder: &Path) -> io::Result<LeaseMarker> {
    let flags = rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK;
    let mut text = String::new();
    match OpenOptions::new().read(true).custom_flags(flags.bits() as i32).open(folder.join(NAME)) {
        Ok(file) => match file.take(BYTES as u64).read_to_string(&mut text) {
            Err(error) if error.raw_os_error().is_some() => return Err(error),
            _ => {}
        },
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(LeaseMarker::Missing),
        Err(error) => return Err(error),
    }
    Ok(serde_json::from_str(text.trim_end())
        .map_or(LeaseMarker::NoHolder, |holder| LeaseMarker::HeldBy(Box::new(holder))))
}

/// Writes the marker in place and at full length: a reader sees the old or the new number. Fails if `checked_at` is too
/// old: after a long pause the daemon would overwrite the name of another one that has taken the folder meanwhile.
pub(super) fn write_marker(folder: &Path, holder: &LeaseHolder, checked_at: LeaseTimestamp) -> io::Result<()> {
    let mut text = serde_json::to_string(holder).map_err(io::Error::other)?;
    text.extend(std::iter::repeat_n(' ', BYTES.saturating_sub(text.len() + 1)));
    text.push('\n');
    let flags = rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK;
    let mut open = OpenOptions::new();
    open.write(true).create(true).truncate(false).custom_flags(flags.bits() as i32);
    let file = match open.open(folder.join(NAME)) {
        // An administrator created it to accept the folder: the folder is ours, so the marker may be replaced.
        Err(error)
            if error.kind() == io::ErrorKind::PermissionDenied && read_marker(folder)? == LeaseMarker::NoHolder =>
        {
            fs::remove_file(folder.join(NAME))?;
            open.open(folder.join(NAME))?
        }
        other => other?,
    };
    if file.metadata()?.len() == 0 {
        access::apply_file_permissions(&file)?;
    }
    match checked_at.is_valid() {
        true => file.write_all_at(text.as_bytes(), 0),
        false => Err(io::ErrorKind::TimedOut.into()),
    }
}
