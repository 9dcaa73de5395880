//! A claimed part, read from the folder of its claim.

use std::{
    ffi::OsString,
    fs, io,
    path::{Path, PathBuf},
};

use thiserror::Error;

use super::{
    beside::{Role, role},
    claim_folder::{CLAIMED_DIR, id_and_farm},
    disk, display_name,
    name::order_name,
};

/// A claimed part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Claim {
    /// Unique for ever, sortable by time; begins the name of its folder.
    pub id: String,
    /// The hot folder it was claimed from.
    pub inbox: PathBuf,
    /// Its folder, `.claimed/<id>@<farm>`.
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
    /// What the order list of its folder says about it; of an older nestd a copy of the whole list.
    pub list: Option<PathBuf>,
    /// Size, bytes.
    pub size: u64,
    /// Last change of contents, nanoseconds since 1970.
    pub mtime_ns: i128,
    /// Last change of contents or attributes, nanoseconds since 1970: nobody can set it.
    pub ctime_ns: i128,
}

impl Claim {
    /// Its name, escaped.
    pub fn display_name(&self) -> String {
        display_name(&self.name)
    }

    /// Reads a claim from its folder; `None` if it does not hold exactly one part.
    pub(super) fn load(inbox: &Path, name: &str) -> io::Result<Option<Self>> {
        let dir = inbox.join(CLAIMED_DIR).join(name);
        let (mut parts, mut tickets, mut list) = (Vec::new(), Vec::new(), None);
        for file in disk::files_below(&dir)? {
            match role(&file) {
                Role::Part => parts.push(file),
                Role::Ticket { .. } => tickets.push(file),
                Role::List => list = Some(file),
            }
        }
        let [part] = &parts[..] else { return Ok(None) };
        let meta = fs::symlink_metadata(part)?;
        let order_path = part.parent().and_then(|p| p.strip_prefix(&dir).ok()).unwrap_or(Path::new("")).to_owned();
        Ok(Some(Self {
            id: id_and_farm(name).0.to_owned(),
            inbox: inbox.to_owned(),
            part: part.clone(),
            name: part.file_name().unwrap_or_default().to_owned(),
            order: order_name(&order_path),
            order_path,
            tickets,
            list,
            size: meta.len(),
            mtime_ns: disk::mtime_ns(&meta),
            ctime_ns: disk::ctime_ns(&meta),
            dir,
        }))
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

pub(super) fn io_error(what: &'static str, path: &Path, source: io::Error) -> ClaimError {
    ClaimError::Io { what, path: path.to_owned(), source }
}
