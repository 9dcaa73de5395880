//! The farm's folders: there or to be made, writable, on the right kind of disk, with room.

use std::{
    collections::HashMap,
    fs, io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
};

use rustix::fs::{Access, access, statfs, statvfs};

use super::report::Report;
use crate::{
    intake::{self, display_name},
    settings::{Profile, Settings},
};

/// Less room than this in the state directory, and the next large drop fills the disk.
const MIN_STATE_BYTES: u64 = 1 << 30;
/// Less room than this in any other folder, and the next build or archive fills the disk.
const MIN_FOLDER_BYTES: u64 = 256 << 20;
/// nestd adds suffixes to names (`.reason.txt`); shorter limits refuse ordinary names.
const MIN_NAME_BYTES: u64 = 143;
/// More stray files than these are only counted.
const MAX_STRAY_SHOWN: usize = 20;
/// Magic numbers of file systems that tell nobody of changes made elsewhere.
const REMOTE: [(u32, &str); 4] = [(0x6969, "NFS"), (0xfe53_4d42, "SMB2"), (0xff53_4d42, "CIFS"), (0x6573_5546, "FUSE")];

/// Looks at all folders.
pub fn look(settings: &Settings, report: &mut Report) {
    let mut seen = HashMap::new();
    if folder("state folder", &settings.state_dir, MIN_STATE_BYTES, &mut seen, report)
        && let Some(kind) = remote_kind(&settings.state_dir)
    {
        let text = format!("{} is on {kind}", settings.state_dir.display());
        report.problem("state folder", text, "set folders.state to a local disk: SQLite does not work on a share");
    }
    for profile in settings.profiles.values() {
        profile_folders(profile, &mut seen, report);
    }
    stray_files(settings, report);
}

/// What was dropped beside the hot folders lies there for ever.
fn stray_files(settings: &Settings, report: &mut Report) {
    let base = settings.inbox_base.display();
    let stray = match intake::stray(&settings.inbox_base, &settings.folders()) {
        Ok(stray) => stray,
        Err(error) => return report.note("inbox", format!("{base} cannot be listed: {error}")),
    };
    for path in stray.iter().take(MAX_STRAY_SHOWN) {
        let name = display_name(path.file_name().unwrap_or_default());
        let (text, remedy) = match path.is_dir() {
            true => (
                format!("the folder {name:?} in {base} belongs to no profile: nothing in it is printed"),
                "move it into the folder of a profile, where it is an order, or give it a profile of that name",
            ),
            false => (
                format!("{name:?} lies in {base} itself: it is not printed"),
                "move it into the folder of the profile that it is for",
            ),
        };
        report.warning("inbox", text, remedy);
    }
    if stray.len() > MAX_STRAY_SHOWN {
        let text = format!("{} more things in {base} belong to no profile", stray.len() - MAX_STRAY_SHOWN);
        report.warning("inbox", text, "move them into the folders of the profiles that they are for");
    }
}

fn profile_folders(profile: &Profile, seen: &mut HashMap<(u64, u64), String>, report: &mut Report) {
    let folders = &profile.folders;
    let inbox = format!("inbox of {}", profile.name);
    if folder(&inbox, &folders.inbox, MIN_FOLDER_BYTES, seen, report) {
        claims_by_rename(&inbox, &folders.inbox, report);
        if let Some(kind) = remote_kind(&folders.inbox) {
            report.note(&inbox, format!("is on {kind}: what other computers drop is found by scanning only"));
        }
    }
    let others = [("queue", &folders.queue), ("error folder", &folders.error), ("archive", &folders.archive)];
    for (what, path) in others {
        folder(&format!("{what} of {}", profile.name), path, MIN_FOLDER_BYTES, seen, report);
    }
}

/// Looks at one folder; whether it is there and can be used.
fn folder(what: &str, path: &Path, room: u64, seen: &mut HashMap<(u64, u64), String>, report: &mut Report) -> bool {
    let shown = path.display();
    let metadata = match fs::metadata(path) {
        Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            to_be_made(what, path, report);
            return false;
        }
        Err(error) => {
            report.problem(what, format!("{shown}: {error}"), "let nestd's user enter all folders above it");
            return false;
        }
        Ok(metadata) if !metadata.is_dir() => {
            report.problem(what, format!("{shown} is not a folder"), "move it away or configure another folder");
            return false;
        }
        Ok(metadata) => metadata,
    };
    if let Some(other) = seen.insert((metadata.dev(), metadata.ino()), what.to_owned()) {
        let text = format!("{shown} is, through a link or mount, also the {other}");
        report.problem(what, text, "give each a folder of its own");
        return false;
    }
    if let Err(error) = try_to_write(path) {
        let remedy = format!(
            "let nestd's user write there, as in: chown nestd {shown}; check as that user: sudo -u nestd nestd check"
        );
        report.problem(what, format!("cannot write into {shown} as user {}: {error}", user()), remedy);
        return false;
    }
    if has_room(what, path, room, report) {
        report.ok(what, shown.to_string());
    }
    true
}

/// A folder that is not there must be one that the daemon can make.
fn to_be_made(what: &str, path: &Path, report: &mut Report) {
    let above = path.ancestors().skip(1).find(|above| above.exists()).unwrap_or(Path::new("/"));
    if above.is_dir() && access(above, Access::WRITE_OK | Access::EXEC_OK).is_ok() {
        report.ok(what, format!("{} will be made", path.display()));
    } else {
        let text = format!("{} is not there and user {} cannot make it in {}", path.display(), user(), above.display());
        report.problem(what, text, format!("make it: install -d -o nestd -g nestd {}", path.display()));
    }
}

/// Writes a file that is gone at once.
fn try_to_write(path: &Path) -> io::Result<()> {
    let file = tempfile::Builder::new().prefix(".nestd-check-").tempfile_in(path)?;
    file.close()
}

/// Parts are claimed by a rename into `.claimed`, which works inside one file system only: also for the order folders.
fn claims_by_rename(what: &str, inbox: &Path, report: &mut Report) {
    if let Err(error) = try_to_rename(inbox) {
        report.problem(
            what,
            format!("files cannot be renamed in {}: {error}", inbox.display()),
            "let nestd's user write there",
        );
    }
    let device = |path: &Path| fs::metadata(path).map(|metadata| metadata.dev()).ok();
    let orders = fs::read_dir(inbox).into_iter().flatten().flatten().map(|entry| entry.path());
    for order in orders.filter(|path| path.is_dir() && !path.is_symlink()) {
        if device(&order) != device(inbox) {
            let text =
                format!("{} is on another file system: parts in it cannot be claimed by a rename", order.display());
            report.problem(what, text, "mount the whole inbox, not a folder in it");
        }
    }
}

fn try_to_rename(inbox: &Path) -> io::Result<()> {
    let file = tempfile::Builder::new().prefix(".nestd-check-").tempfile_in(inbox)?;
    let claimed = inbox.join(".claimed");
    let to: PathBuf = if claimed.is_dir() { claimed } else { inbox.to_owned() };
    let to = to.join(format!(".nestd-check-renamed-{}", std::process::id()));
    fs::rename(file.path(), &to)?;
    fs::remove_file(&to)
}

/// Whether there is room on the disk; says so when there is not.
fn has_room(what: &str, path: &Path, least: u64, report: &mut Report) -> bool {
    let Ok(disk) = statvfs(path) else { return true };
    let free = disk.f_bavail.saturating_mul(disk.f_frsize);
    if free < least {
        let text = format!("{} MiB are free at {}, less than {} MiB", free >> 20, path.display(), least >> 20);
        report.problem(what, text, "free some room or move the folder to a larger disk");
        return false;
    }
    if disk.f_files > 0 && disk.f_favail == 0 {
        report.problem(what, format!("no inode is free at {}", path.display()), "remove files or move the folder");
        return false;
    }
    if disk.f_namemax < MIN_NAME_BYTES {
        report.note(what, format!("file names there end at {} bytes: longer ones cannot be taken", disk.f_namemax));
    }
    true
}

fn remote_kind(path: &Path) -> Option<&'static str> {
    let magic = statfs(path).ok()?.f_type as u32; // signed or wider on some machines; the magic is its low 32 bits
    REMOTE.iter().find(|(known, _)| *known == magic).map(|&(_, kind)| kind)
}

/// Who looks: what root may do, the daemon's user may not.
fn user() -> String {
    rustix::process::geteuid().as_raw().to_string()
}
