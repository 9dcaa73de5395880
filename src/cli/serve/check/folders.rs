//! Checks the farm's folders: each exists or can be created, is writable, is on the right kind of disk and has free
//! space.

use std::{
    collections::HashMap,
    fs, io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
};

use farm::LeaseError;
use intake::display_name;
use rustix::fs::{Access, access, statfs, statvfs};
use settings::{MachineProfile, Settings};

use super::{other_machines::OtherMachines, report::CheckReport};

/// With less free space than this in the state directory, the next large drop fills the disk.
const MIN_STATE_BYTES: u64 = 1 << 30;
/// With less free space than this in any other folder, the next build or archive fills the disk.
const MIN_FOLDER_BYTES: u64 = 256 << 20;
/// nestd adds suffixes to names (`.reason.txt`); a file system with a lower limit than this refuses ordinary names.
const MIN_NAME_BYTES: u64 = 143;
/// This many stray files are listed; further ones are only counted.
const MAX_STRAY_SHOWN: usize = 20;
/// Magic numbers of file systems that send no inotify events for changes made by other computers.
const REMOTE_FILE_SYSTEMS: [(u32, &str); 4] =
    [(0x6969, "NFS"), (0xfe53_4d42, "SMB2"), (0xff53_4d42, "CIFS"), (0x6573_5546, "FUSE")];

/// Checks the folders of this node.
pub fn check_folders(settings: &Settings, others: &OtherMachines, report: &mut CheckReport) {
    let mut seen = HashMap::new();
    let state_dir = &settings.state_dir;
    if check_folder("state folder", state_dir, MIN_STATE_BYTES, state_dir, &mut seen, report)
        && let Some(kind) = remote_file_system(&settings.state_dir)
    {
        let text = format!("{} is on {kind}", settings.state_dir.display());
        report.add_problem("state folder", text, "set folders.state to a local disk: SQLite does not work on a share");
    }
    for profile in settings.profiles.values() {
        check_machine_folders(profile, state_dir, &mut seen, report);
    }
    report_stray_files(settings, others, report);
}

/// Reports files that were dropped beside the hot folders: no node takes them.
fn report_stray_files(settings: &Settings, others: &OtherMachines, report: &mut CheckReport) {
    let base = settings.inbox_base.display();
    let mut known = settings.all_folders();
    known.extend(others.hot_folders(settings));
    let stray = match intake::find_misplaced(&settings.inbox_base, &known) {
        Ok(stray) => stray,
        Err(error) => return report.add_note("inbox", format!("{base} cannot be listed: {error}")),
    };
    for path in stray.iter().take(MAX_STRAY_SHOWN) {
        let name = display_name(path.file_name().unwrap_or_default());
        let (text, remedy) = match path.is_dir() {
            true if path.join(".nestd-owner").exists() => (
                format!(
                    "the folder {name:?} in {base} was that of a machine that is not configured: nothing in it is printed"
                ),
                "put the machine's file back into profiles/, or move the parts in it, and nothing else, into the folder of \
                 another machine; STATUS.txt and status.json are nestd's own",
            ),
            true => (
                format!("the folder {name:?} in {base} belongs to no machine: nothing in it is printed"),
                "move it into the folder of a machine, where it is an order, or add a machine of that name",
            ),
            false => (
                format!("{name:?} lies in {base} itself: it is not printed"),
                "move it into the folder of the machine that it is for",
            ),
        };
        report.add_warning("inbox", text, remedy);
    }
    if stray.len() > MAX_STRAY_SHOWN {
        let text = format!("{} more things in {base} belong to no machine", stray.len() - MAX_STRAY_SHOWN);
        report.add_warning("inbox", text, "move them into the folders of the machines that they are for");
    }
}

fn check_machine_folders(
    profile: &MachineProfile,
    state_dir: &Path,
    seen: &mut HashMap<(u64, u64), String>,
    report: &mut CheckReport,
) {
    let folders = &profile.folders;
    let inbox = format!("inbox of {}", profile.name);
    if check_folder(&inbox, &folders.inbox, MIN_FOLDER_BYTES, state_dir, seen, report) {
        check_claim_rename(&inbox, &folders.inbox, report);
        if let Some(kind) = remote_file_system(&folders.inbox) {
            report.add_note(&inbox, format!("is on {kind}: what other computers drop is found by scanning only"));
        }
    }
    for printer in &profile.printers {
        if let Some(folder) = printer.queue.folder() {
            check_folder(&profile.queue_description(printer), folder, MIN_FOLDER_BYTES, state_dir, seen, report);
        }
    }
    for (what, path) in [("error folder", &folders.error), ("archive", &folders.archive)] {
        check_folder(&format!("{what} of {}", profile.name), path, MIN_FOLDER_BYTES, state_dir, seen, report);
    }
}

/// Checks one folder; returns whether it exists and can be used.
fn check_folder(
    what: &str,
    path: &Path,
    room: u64,
    state_dir: &Path,
    seen: &mut HashMap<(u64, u64), String>,
    report: &mut CheckReport,
) -> bool {
    let shown = path.display();
    let metadata = match fs::metadata(path) {
        Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            match farm::is_known_folder(state_dir, path) {
                true => report_away(what, path, report),
                false => check_can_be_made(what, path, report),
            }
            return false;
        }
        Err(error) => {
            report.add_problem(what, format!("{shown}: {error}"), "let nestd's user enter all folders above it");
            return false;
        }
        Ok(metadata) if !metadata.is_dir() => {
            report.add_problem(what, format!("{shown} is not a folder"), "move it away or configure another folder");
            return false;
        }
        Ok(metadata) => metadata,
    };
    if let Some(other) = seen.insert((metadata.dev(), metadata.ino()), what.to_owned()) {
        let text = format!("{shown} is, through a link or mount, also the {other}");
        report.add_problem(what, text, "give each a folder of its own");
        return false;
    }
    if let Err(error) = farm::check_readable(state_dir, path) {
        report.add_problem(what, error.to_string(), folder_remedy(&error));
        return false;
    }
    if let Err(error) = try_to_write(path) {
        let remedy = format!(
            "let nestd's user write there, as in: chown nestd {shown}; check as that user: sudo -u nestd nestd check"
        );
        report.add_problem(what, format!("cannot write into {shown} as user {}: {error}", user_id()), remedy);
        return false;
    }
    if has_room(what, path, room, report) {
        report.add_ok(what, shown.to_string());
    }
    true
}

/// Reports a folder that is not there and that this farm has served: the daemon does not create it, because an empty folder would be in
/// the way of whoever mounts it again.
fn report_away(what: &str, path: &Path, report: &mut CheckReport) {
    let shown = path.display();
    let text = format!("{shown} is not there, and this farm has used it before: the daemon does not make it again");
    report.add_problem(what, text, format!("mount it again; if its contents are lost for good: mkdir {shown}"));
}

/// What to do about a folder that the daemon would not use.
fn folder_remedy(error: &LeaseError) -> &'static str {
    match error {
        LeaseError::HeldByOther { .. } | LeaseError::HolderUnclear { .. } => "let one farm alone serve it",
        LeaseError::Replaced(_) => "mount it again; the folder is used as it is only with that marker",
        LeaseError::ClaimsNotReleased { .. } | LeaseError::Io { .. } => "mount it again, and let nestd's user read it",
    }
}

/// Checks that the daemon can create a folder that does not exist.
fn check_can_be_made(what: &str, path: &Path, report: &mut CheckReport) {
    let above = path.ancestors().skip(1).find(|above| above.exists()).unwrap_or(Path::new("/"));
    if above.is_dir() && access(above, Access::WRITE_OK | Access::EXEC_OK).is_ok() {
        report.add_ok(what, format!("{} will be made", path.display()));
    } else {
        let text =
            format!("{} is not there and user {} cannot make it in {}", path.display(), user_id(), above.display());
        report.add_problem(what, text, format!("make it: install -d -o nestd -g nestd {}", path.display()));
    }
}

/// Writes a temporary file and removes it at once.
fn try_to_write(path: &Path) -> io::Result<()> {
    let file = tempfile::Builder::new().prefix(".nestd-check-").tempfile_in(path)?;
    file.close()
}

/// Checks that parts can be claimed by a rename into `.claimed`. A rename works inside one file system only, so the
/// order folders are checked as well.
fn check_claim_rename(what: &str, inbox: &Path, report: &mut CheckReport) {
    if let Err(error) = try_to_rename(inbox) {
        report.add_problem(
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
            report.add_problem(what, text, "mount the whole inbox, not a folder in it");
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

/// Whether the disk has enough free space; reports a problem when it has not.
fn has_room(what: &str, path: &Path, least: u64, report: &mut CheckReport) -> bool {
    let Ok(disk) = statvfs(path) else { return true };
    let free = disk.f_bavail.saturating_mul(disk.f_frsize);
    if free < least {
        let text = format!("{} MiB are free at {}, less than {} MiB", free >> 20, path.display(), least >> 20);
        report.add_problem(what, text, "free some room or move the folder to a larger disk");
        return false;
    }
    if disk.f_files > 0 && disk.f_favail == 0 {
        report.add_problem(what, format!("no inode is free at {}", path.display()), "remove files or move the folder");
        return false;
    }
    if disk.f_namemax < MIN_NAME_BYTES {
        report.add_note(what, format!("file names there end at {} bytes: longer ones cannot be taken", disk.f_namemax));
    }
    true
}

fn remote_file_system(path: &Path) -> Option<&'static str> {
    let magic = statfs(path).ok()?.f_type as u32; // signed or wider on some machines; the magic is its low 32 bits
    REMOTE_FILE_SYSTEMS.iter().find(|(known, _)| *known == magic).map(|&(_, kind)| kind)
}

/// The id of the current user, for messages: root may do things that the daemon's user may not.
fn user_id() -> String {
    rustix::process::geteuid().as_raw().to_string()
}
