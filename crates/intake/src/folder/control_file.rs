//! Control files: a technician without a shell puts an empty file `FLUSH`, `PAUSE` or `RESUME` into the hot folder. It is
//! removed once the farm has acted upon it.

use std::{ffi::OsStr, fs, io, os::unix::fs::MetadataExt, path::Path};

use super::disk;
use crate::{InboxEntry, display_name};

/// Command of a control file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ControlKind {
    /// Build what waits.
    Flush,
    /// Fire no build.
    Pause,
    /// Fire builds again.
    Resume,
}

impl ControlKind {
    /// The name of its file.
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Flush => "FLUSH",
            Self::Pause => "PAUSE",
            Self::Resume => "RESUME",
        }
    }
}

/// A control file that has settled. It is reported at each scan until [`finish_control_file`] has removed it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ControlFile {
    /// The file.
    pub entry: InboxEntry,
    /// Its command.
    pub kind: ControlKind,
    /// The user that owns the file. On a share it may be the user of the server.
    pub owner_uid: Option<u32>,
    /// Distinguishes this file from every other one, also after a restart: a command that was given already is not given
    /// again if a crash prevented the removal of its file.
    pub key: String,
}

impl ControlFile {
    /// A control file of a scan.
    pub fn from_entry(entry: &InboxEntry, kind: ControlKind) -> Self {
        let owner_uid = fs::symlink_metadata(&entry.path).ok().map(|meta| meta.uid());
        Self { kind, owner_uid, key: entry_key(entry), entry: entry.clone() }
    }
}

/// Identifies an entry as it was at the scan. A file that was written again has another key.
pub(crate) fn entry_key(entry: &InboxEntry) -> String {
    format!("{}-{}", entry.inode, entry.ctime_ns)
}

/// What the name of a file says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ControlName {
    Command(ControlKind),
    /// It has content.
    NotEmpty(ControlKind),
    /// It lies in an order folder.
    InOrder(ControlKind),
}

/// Recognises a control file by its name: in any case, and with `.txt`, which Windows adds and hides.
pub(crate) fn control_name(entry: &InboxEntry) -> Option<ControlName> {
    let kind = named_control(entry.path.file_name()?)?;
    match (entry.order.is_empty(), entry.size) {
        (true, 0) => Some(ControlName::Command(kind)),
        (true, _) => Some(ControlName::NotEmpty(kind)),
        (false, 0) => Some(ControlName::InOrder(kind)),
        // An order may hold a file of that name.
        (false, _) => None,
    }
}

/// The command that a file of this name gives.
pub(crate) fn named_control(name: &OsStr) -> Option<ControlKind> {
    let name = name.to_str()?.to_ascii_uppercase();
    let name = name.strip_suffix(".TXT").unwrap_or(&name);
    [ControlKind::Flush, ControlKind::Pause, ControlKind::Resume].into_iter().find(|kind| kind.file_name() == name)
}

/// Why a file with the name of a control file gives no command.
pub(crate) fn misplaced_control_reason(name: Option<ControlName>, file: &InboxEntry) -> String {
    let shown = display_name(file.path.file_name().unwrap_or_default());
    match name {
        Some(ControlName::InOrder(kind)) => format!(
            "{shown} has the name of a control file, but lies in an order folder. A control file is for the whole machine: \
             put an empty file {} right into the hot folder.",
            kind.file_name()
        ),
        _ => format!(
            "{shown} has the name of a control file, but is not empty ({} bytes), so nothing was done. \
             Put an empty file of that name into the hot folder.",
            file.size
        ),
    }
}

/// Removes a control file after its command was given. Safe to repeat. Returns whether the file was still there; a file
/// that was replaced meanwhile stays, and is a new command.
///
/// # Errors
/// The file system reports an error.
pub fn finish_control_file(inbox: &Path, control: &ControlFile) -> io::Result<bool> {
    let entry = &control.entry;
    let relative = entry.path.strip_prefix(inbox).map_err(|_| io::ErrorKind::InvalidInput)?;
    let folder = disk::open_dir_beneath(inbox, relative.parent().unwrap_or(Path::new("")))?;
    match fs::symlink_metadata(&entry.path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
        Err(error) => return Err(error),
        Ok(meta) if !disk::is_unchanged(entry, &meta) => return Ok(false),
        Ok(_) => {}
    }
    let name = relative.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    match rustix::fs::unlinkat(&folder, name, rustix::fs::AtFlags::empty()) {
        Err(rustix::io::Errno::NOENT) => Ok(false),
        other => Ok(other.map(|()| true)?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SettledEntry, test_inbox::TestInbox};

    fn controls(farm: &TestInbox) -> Vec<ControlFile> {
        let ready = farm.ready().into_iter();
        let of_entry = |one| match one {
            SettledEntry::Control { file, kind } => Some(ControlFile::from_entry(&file, kind)),
            _ => None,
        };
        ready.filter_map(of_entry).collect()
    }

    #[test]
    fn empty_files_of_these_names_are_commands_in_any_case() {
        let farm = TestInbox::new();
        for name in ["FLUSH", "pause.txt", "Resume.TXT"] {
            farm.drop_file(name, "");
        }
        farm.drop_file("flush.stl", "solid");
        let found = controls(&farm);
        let kinds: Vec<ControlKind> = found.iter().map(|control| control.kind).collect();
        assert_eq!(kinds, [ControlKind::Flush, ControlKind::Resume, ControlKind::Pause]);
        assert!(found.iter().all(|control| control.owner_uid.is_some()));
        for control in &found {
            assert!(finish_control_file(&farm.inbox, control).unwrap());
            assert!(!finish_control_file(&farm.inbox, control).unwrap(), "it is safe to repeat");
        }
        assert_eq!(farm.dropped(), ["flush.stl"]);
    }

    #[test]
    fn a_control_file_that_was_put_again_is_a_new_command() {
        let farm = TestInbox::new();
        let path = farm.drop_file("FLUSH", "");
        let first = controls(&farm).remove(0);
        farm.drop_file("other", "");
        fs::remove_file(&path).unwrap();
        fs::rename(farm.inbox.join("other"), &path).unwrap();
        let second = controls(&farm).remove(0);
        assert_ne!(first.key, second.key);
        assert!(!finish_control_file(&farm.inbox, &first).unwrap());
        assert!(path.exists());
    }

    #[test]
    fn what_is_not_empty_or_lies_in_an_order_is_refused_with_its_reason() {
        let farm = TestInbox::new();
        farm.drop_file("FLUSH", "now\n");
        farm.drop_file("order-7/PAUSE", "");
        farm.drop_file("order-7/resume.txt", "notes");
        assert_eq!(controls(&farm), []);
        let reasons: Vec<String> = (farm.ready().into_iter())
            .filter_map(|one| if let SettledEntry::Refuse { reason, .. } = one { Some(reason) } else { None })
            .collect();
        assert_eq!(reasons.len(), 2, "{reasons:?}");
        assert!(reasons[0].contains("not empty (4 bytes)") && reasons[1].contains("right into the hot folder"));
    }
}
