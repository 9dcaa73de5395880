//! Who may use what the daemon makes: one mode and one group for all files and folders of the farm, whatever the umask of
//! whoever started it. Nothing is set until the daemon says so: commands that make files of their own are as any other program.

use std::{
    fs::{self, File},
    io,
    os::{
        fd::AsFd,
        unix::fs::{DirBuilderExt, PermissionsExt},
    },
    path::{Path, PathBuf},
    sync::RwLock,
};

use rustix::{
    fs::{Gid, Mode, fchmod, fchown, fstat},
    io::Errno,
};

/// Set-group-ID of a folder: what is made in it gets its group. The farm's folders have it from whoever made them.
const GROUP_IS_INHERITED: u32 = 0o2000;

/// Mode and group of what the daemon makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Access {
    /// Permission bits of files, as 0o660; folders can be entered by whoever may read.
    pub mode: u32,
    /// Number of the group; `None` = as the system gives it.
    pub group: Option<u32>,
}

static NOW: RwLock<Option<Access>> = RwLock::new(None);

impl Access {
    /// Holds from now on for all that this process makes.
    pub fn set(self) {
        *NOW.write().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(self);
        rustix::process::umask(Mode::from_raw_mode(0o777 & !self.folder_mode()));
    }

    /// Permission bits of folders.
    pub fn folder_mode(self) -> u32 {
        self.mode | (self.mode & 0o444) >> 2
    }

    /// What holds now.
    fn now() -> Option<Self> {
        *NOW.read().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// A secret shorter than this is guessed, letters.
const LEAST_SECRET: usize = 16;

/// Why a secret is none.
#[derive(Debug, thiserror::Error)]
pub enum SecretError {
    /// The file cannot be read.
    #[error("reading the secret {}", .0.display())]
    Io(PathBuf, #[source] io::Error),
    /// It is too short.
    #[error("the secret in {} is shorter than {LEAST_SECRET} letters", .0.display())]
    Short(PathBuf),
    /// Everybody may read it.
    #[error("everybody may read the secret in {}: chmod 640 it", .0.display())]
    Open(PathBuf),
}

/// Reads a secret out of a file of its own: a token, a key. White space around it is none of it.
///
/// # Errors
/// When it cannot be read, is too short, or is open to everybody.
pub fn read_secret(file: &Path) -> Result<String, SecretError> {
    let failed = |error| SecretError::Io(file.to_owned(), error);
    let secret = fs::read_to_string(file).map_err(failed)?.trim().to_owned();
    if secret.len() < LEAST_SECRET {
        return Err(SecretError::Short(file.to_owned()));
    }
    if fs::metadata(file).map_err(failed)?.permissions().mode() & 0o007 != 0 {
        return Err(SecretError::Open(file.to_owned()));
    }
    Ok(secret)
}

/// Gives a file that was just made its mode and group.
///
/// # Errors
/// Those of the system, but for a share that keeps modes and groups to itself.
pub fn of_file(file: &File) -> io::Result<()> {
    let Some(access) = Access::now() else { return Ok(()) };
    if let Some(group) = access.group {
        lenient(fchown(file, None, Some(Gid::from_raw(group))))?;
    }
    lenient(fchmod(file, Mode::from_raw_mode(access.mode)))
}

/// Gives a folder that was just made its mode and group; what it inherits from the folder above stays.
///
/// # Errors
/// As [`of_file`].
pub fn of_folder(folder: &Path) -> io::Result<()> {
    match Access::now() {
        Some(_) => of_open_folder(File::open(folder)?),
        None => Ok(()),
    }
}

/// Likewise, for a folder that is open.
///
/// # Errors
/// As [`of_file`].
pub fn of_open_folder(folder: impl AsFd) -> io::Result<()> {
    let Some(access) = Access::now() else { return Ok(()) };
    let before = fstat(&folder)?;
    if let Some(group) = access.group.filter(|group| before.st_gid != *group) {
        lenient(fchown(&folder, None, Some(Gid::from_raw(group))))?;
    }
    if fstat(&folder)?.st_mode & 0o777 == access.folder_mode() {
        return Ok(());
    }
    // The service is forbidden to set that bit, also where it is set already: then the mode stays as the system made it.
    let inherits = before.st_mode & GROUP_IS_INHERITED;
    lenient(fchmod(&folder, Mode::from_raw_mode(access.folder_mode() | inherits)))
}

/// Makes a folder and those above it that are missing, each with mode and group.
///
/// # Errors
/// Those of the system.
pub fn create_folders(folder: &Path) -> io::Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    if let Some(above) = folder.parent().filter(|above| !above.as_os_str().is_empty()) {
        create_folders(above)?;
    }
    match fs::create_dir(folder) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => Err(error),
        Err(error) if !folder.is_dir() => Err(error),
        Err(_) => Ok(()),
        Ok(()) => of_folder(folder),
    }
}

/// Makes a folder for the daemon and its group alone, whatever the mode of the farm: it holds the ledger and what was sent.
///
/// # Errors
/// Those of the system.
pub fn create_private_folders(folder: &Path) -> io::Result<()> {
    fs::DirBuilder::new().recursive(true).mode(0o750).create(folder)
}

/// Whether this process may give files to a group.
pub fn may_give_to(group: u32) -> bool {
    let own = [rustix::process::getegid().as_raw(), rustix::process::getgid().as_raw()];
    let others = rustix::process::getgroups().unwrap_or_default();
    rustix::process::geteuid().is_root() || own.contains(&group) || others.iter().any(|one| one.as_raw() == group)
}

/// The number of a group by its name in `/etc/group`, or as a number.
pub fn group_number(name: &str) -> Option<u32> {
    if let Ok(number) = name.parse() {
        return Some(number);
    }
    let groups = fs::read_to_string("/etc/group").ok()?;
    let mut lines = groups.lines().map(|line| line.split(':'));
    lines.find_map(|mut fields| (fields.next()? == name).then(|| fields.nth(1)?.parse().ok())?)
}

/// Shares have modes and groups of their own, by how they are mounted.
fn lenient(result: Result<(), Errno>) -> io::Result<()> {
    match result {
        Err(Errno::PERM | Errno::OPNOTSUPP | Errno::INVAL | Errno::ACCESS) => Ok(()),
        other => Ok(other?),
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::MetadataExt;

    use super::*;

    #[test]
    fn folders_can_be_entered_by_whoever_may_read() {
        let of = |mode| Access { mode, group: None }.folder_mode();
        assert_eq!([of(0o660), of(0o664), of(0o600), of(0o640)], [0o770, 0o775, 0o700, 0o750]);
    }

    #[test]
    fn a_group_is_known_by_name_or_number() {
        assert_eq!(group_number("root"), Some(0));
        assert_eq!(group_number("4711"), Some(4711));
        assert_eq!(group_number("no such group"), None);
        assert!(may_give_to(rustix::process::getegid().as_raw()));
    }

    #[test]
    fn nothing_is_changed_until_the_daemon_says_so() {
        let dir = tempfile::tempdir().unwrap();
        let file = File::create(dir.path().join("a")).unwrap();
        let before = file.metadata().unwrap().mode();
        of_file(&file).unwrap();
        assert_eq!(file.metadata().unwrap().mode(), before);
        create_folders(&dir.path().join("b/c")).unwrap();
        assert!(dir.path().join("b/c").is_dir());
    }
}
