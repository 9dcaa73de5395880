//! Permissions of what the daemon creates: one mode and one group for all files and folders of the farm, whatever the
//! umask of the process that started it. Nothing is set until the daemon calls [`FilePermissions::apply_to_process`]: other commands create
//! files like any other program.

mod passwords;
mod tokens;

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

pub use passwords::{PasswordHash, is_password, is_person_name, is_pin};
pub use tokens::{
    Role, StoredToken, TokenError, TokenWatch, add_token, hash_token, random_token, read_tokens, revoke_token,
};

/// Set-group-ID of a folder: files created in it get its group. Whoever created the farm's folders may have set this
/// bit.
const SET_GROUP_ID: u32 = 0o2000;

/// Mode and group of the files and folders that the daemon creates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FilePermissions {
    /// Permission bits of files, such as 0o660. Folders also get the execute bit for everybody who may read.
    pub mode: u32,
    /// Group id; `None` = the default of the system.
    pub group: Option<u32>,
}

static PROCESS_PERMISSIONS: RwLock<Option<FilePermissions>> = RwLock::new(None);

/// This process may not assign files to this group, given by its id.
#[derive(Debug, thiserror::Error)]
#[error("files.group: nestd's user is not in the group {0}; add it with usermod -aG {0} USER")]
pub struct UnassignableGroupError(pub u32);

impl FilePermissions {
    /// Checks that this process may assign files to the group.
    ///
    /// # Errors
    /// It is not in the group.
    pub fn ensure_assignable(self) -> Result<(), UnassignableGroupError> {
        match self.group {
            Some(group) if !can_assign_group(group) => Err(UnassignableGroupError(group)),
            _ => Ok(()),
        }
    }

    /// Applies the permissions to everything that this process creates from now on.
    pub fn apply_to_process(self) {
        *PROCESS_PERMISSIONS.write().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(self);
        rustix::process::umask(Mode::from_raw_mode(0o777 & !self.folder_mode()));
    }

    /// Permission bits of folders.
    pub fn folder_mode(self) -> u32 {
        self.mode | (self.mode & 0o444) >> 2
    }

    /// The permissions that are in force; `None` = not set.
    fn current_permissions() -> Option<Self> {
        *PROCESS_PERMISSIONS.read().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// Shortest accepted secret, in characters; shorter ones can be guessed.
const LEAST_SECRET: usize = 16;

/// Why a secret file is not accepted.
#[derive(Debug, thiserror::Error)]
pub enum SecretError {
    /// The file cannot be read.
    #[error("reading the secret {}", .0.display())]
    Unreadable(PathBuf, #[source] io::Error),
    /// It is too short.
    #[error("the secret in {} is shorter than {LEAST_SECRET} letters", .0.display())]
    TooShort(PathBuf),
    /// It holds nothing.
    #[error("there is no secret in {}", .0.display())]
    Empty(PathBuf),
    /// Everybody may read it.
    #[error("everybody may read the secret in {}: chmod 640 it", .0.display())]
    WorldReadable(PathBuf),
}

/// Reads a secret (a token or a key) from a file of its own. Surrounding white space is removed.
///
/// # Errors
/// The file cannot be read, the secret is too short, or everybody may read the file.
pub fn read_secret(file: &Path) -> Result<String, SecretError> {
    let secret = read_password(file)?;
    if secret.len() < LEAST_SECRET {
        return Err(SecretError::TooShort(file.to_owned()));
    }
    Ok(secret)
}

/// Same as [`read_secret`] for a password that somebody else chose: it may be short.
///
/// # Errors
/// The file cannot be read or holds nothing, or everybody may read it.
pub fn read_password(file: &Path) -> Result<String, SecretError> {
    let failed = |error| SecretError::Unreadable(file.to_owned(), error);
    let secret = fs::read_to_string(file).map_err(failed)?.trim().to_owned();
    if secret.is_empty() {
        return Err(SecretError::Empty(file.to_owned()));
    }
    if fs::metadata(file).map_err(failed)?.permissions().mode() & 0o007 != 0 {
        return Err(SecretError::WorldReadable(file.to_owned()));
    }
    Ok(secret)
}

/// Gives a newly created file its mode and group.
///
/// # Errors
/// System errors, except on a share that does not support modes and groups.
pub fn apply_file_permissions(file: &File) -> io::Result<()> {
    let Some(access) = FilePermissions::current_permissions() else { return Ok(()) };
    if let Some(group) = access.group {
        ignore_unsupported(fchown(file, None, Some(Gid::from_raw(group))))?;
    }
    ignore_unsupported(fchmod(file, Mode::from_raw_mode(access.mode)))
}

/// Gives a newly created folder its mode and group. Bits inherited from the parent folder stay.
///
/// # Errors
/// As [`apply_file_permissions`].
pub fn apply_folder_permissions(folder: &Path) -> io::Result<()> {
    match FilePermissions::current_permissions() {
        Some(_) => apply_open_folder_permissions(File::open(folder)?),
        None => Ok(()),
    }
}

/// Same as [`apply_folder_permissions`], for a folder that is already open.
///
/// # Errors
/// As [`apply_file_permissions`].
pub fn apply_open_folder_permissions(folder: impl AsFd) -> io::Result<()> {
    let Some(access) = FilePermissions::current_permissions() else { return Ok(()) };
    let before = fstat(&folder)?;
    if let Some(group) = access.group.filter(|group| before.st_gid != *group) {
        ignore_unsupported(fchown(&folder, None, Some(Gid::from_raw(group))))?;
    }
    if fstat(&folder)?.st_mode & 0o777 == access.folder_mode() {
        return Ok(());
    }
    // The service is not allowed to set the set-group-ID bit, even where it is set already: in that case the mode stays
    // as the system created it.
    let inherits = before.st_mode & SET_GROUP_ID;
    ignore_unsupported(fchmod(&folder, Mode::from_raw_mode(access.folder_mode() | inherits)))
}

/// Creates a folder and its missing parents, each with mode and group.
///
/// # Errors
/// System errors.
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
        Ok(()) => apply_folder_permissions(folder),
    }
}

/// Creates a folder that only the daemon and its group may enter, whatever the mode of the farm. It holds the ledger
/// and the customers' files.
///
/// # Errors
/// System errors.
pub fn create_private_folders(folder: &Path) -> io::Result<()> {
    fs::DirBuilder::new().recursive(true).mode(0o750).create(folder)
}

/// Whether this process may assign files to a group.
fn can_assign_group(group: u32) -> bool {
    let own = [rustix::process::getegid().as_raw(), rustix::process::getgid().as_raw()];
    let others = rustix::process::getgroups().unwrap_or_default();
    rustix::process::geteuid().is_root() || own.contains(&group) || others.iter().any(|one| one.as_raw() == group)
}

/// The id of a group, found by its name in `/etc/group` or given as a number.
pub fn find_group_id(name: &str) -> Option<u32> {
    if let Ok(number) = name.parse() {
        return Some(number);
    }
    let groups = fs::read_to_string("/etc/group").ok()?;
    let mut lines = groups.lines().map(|line| line.split(':'));
    lines.find_map(|mut fields| (fields.next()? == name).then(|| fields.nth(1)?.parse().ok())?)
}

/// Ignores the errors of shares whose modes and groups are fixed by their mount options.
fn ignore_unsupported(result: Result<(), Errno>) -> io::Result<()> {
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
        let of = |mode| FilePermissions { mode, group: None }.folder_mode();
        assert_eq!([of(0o660), of(0o664), of(0o600), of(0o640)], [0o770, 0o775, 0o700, 0o750]);
    }

    #[test]
    fn a_group_is_known_by_name_or_number() {
        assert_eq!(find_group_id("root"), Some(0));
        assert_eq!(find_group_id("4711"), Some(4711));
        assert_eq!(find_group_id("no such group"), None);
        assert!(can_assign_group(rustix::process::getegid().as_raw()));
    }

    #[test]
    fn nothing_is_changed_until_the_daemon_says_so() {
        let dir = tempfile::tempdir().unwrap();
        let file = File::create(dir.path().join("a")).unwrap();
        let before = file.metadata().unwrap().mode();
        apply_file_permissions(&file).unwrap();
        assert_eq!(file.metadata().unwrap().mode(), before);
        create_folders(&dir.path().join("b/c")).unwrap();
        assert!(dir.path().join("b/c").is_dir());
    }
}
