//! A claimed part, loaded from the folder of its claim.

use std::{
    ffi::OsString,
    fs, io,
    path::{Path, PathBuf},
};

use thiserror::Error;

use super::{
    claim_folder::{CLAIMED_DIR, is_ordered_claim, parse_folder_name},
    disk,
    file_role::{FileRole, file_role},
};
use crate::{display_name, names::name::order_display_name};

/// A claimed part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClaimedPart {
    /// Unique forever and sortable by time. The folder name begins with it.
    pub id: String,
    /// The hot folder it was claimed from.
    pub inbox: PathBuf,
    /// Folder of the claim, `.claimed/<id>@<farm>`.
    pub dir: PathBuf,
    /// The claimed file.
    pub part: PathBuf,
    /// File name as dropped, unescaped.
    pub name: OsString,
    /// Sub-folders below the hot folder, unescaped. Empty = none.
    pub order_path: PathBuf,
    /// The same sub-folders, escaped for display and joined by `/`. Empty = none.
    pub order: String,
    /// Sidecar tickets that were claimed with it.
    pub tickets: Vec<PathBuf>,
    /// File with what the order list says about the part. In claims of an older nestd it is a copy of the whole list.
    pub list: Option<PathBuf>,
    /// Size, bytes.
    pub size: u64,
    /// Last change of contents, nanoseconds since 1970.
    pub mtime_ns: i128,
    /// Last change of contents or attributes, nanoseconds since 1970. Programs cannot set this time.
    pub ctime_ns: i128,
}

impl ClaimedPart {
    /// File name, escaped for display.
    pub fn display_name(&self) -> String {
        display_name(&self.name)
    }

    /// Modification time of the file as it was dropped, nanoseconds since 1970. `None` = a program ordered it over HTTP.
    pub fn dropped_mtime_ns(&self) -> Option<i64> {
        i64::try_from(self.mtime_ns).ok().filter(|_| !is_ordered_claim(&self.id))
    }

    /// Loads a claim from its folder. `None` if the folder does not hold exactly one part.
    pub(crate) fn load_from_folder(inbox: &Path, name: &str) -> io::Result<Option<Self>> {
        let dir = inbox.join(CLAIMED_DIR).join(name);
        let (mut parts, mut tickets, mut list) = (Vec::new(), Vec::new(), None);
        for file in disk::files_below(&dir)? {
            match file_role(&file) {
                FileRole::Part => parts.push(file),
                FileRole::Ticket { .. } => tickets.push(file),
                FileRole::List => list = Some(file),
            }
        }
        let [part] = &parts[..] else { return Ok(None) };
        let meta = fs::symlink_metadata(part)?;
        let order_path = part.parent().and_then(|p| p.strip_prefix(&dir).ok()).unwrap_or(Path::new("")).to_owned();
        Ok(Some(Self {
            id: parse_folder_name(name).0.to_owned(),
            inbox: inbox.to_owned(),
            part: part.clone(),
            name: part.file_name().unwrap_or_default().to_owned(),
            order: order_display_name(&order_path),
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

/// Why a claim failed. The part is still in the hot folder, or crash recovery will put it back there.
#[derive(Debug, Error)]
pub enum ClaimError {
    /// The file changed after the scan; it must settle again.
    #[error("{} changed while it was being claimed", .0.display())]
    Changed(PathBuf),
    /// The file is gone, or was never a part.
    #[error("{} is not there to be claimed", .0.display())]
    Gone(PathBuf),
    /// The operating system reported an error.
    #[error("cannot {what} {}", .path.display())]
    Io {
        /// The operation that failed.
        what: &'static str,
        /// The path that it was applied to.
        path: PathBuf,
        /// The error of the operating system.
        #[source]
        source: io::Error,
    },
}

pub(crate) fn io_error(what: &'static str, path: &Path, source: io::Error) -> ClaimError {
    ClaimError::Io { what, path: path.to_owned(), source }
}
