//! Basic file-system operations: renaming without overwriting, creating folders durably, and opening sub-folders
//! without following links.

use std::{
    ffi::OsStr,
    fs::{self, File, OpenOptions},
    io::{self, Read, Write},
    os::{
        fd::{AsFd, AsRawFd, OwnedFd},
        unix::fs::MetadataExt,
    },
    path::{Component, Path, PathBuf},
    time::{SystemTime, UNIX_EPOCH},
};

use rustix::{
    fs::{CWD, Mode, OFlags, RenameFlags, fsync, mkdirat, openat, renameat, renameat_with},
    io::Errno,
};

use crate::{InboxEntry, names::name::numbered_name};

/// How the name of a file begins and ends whose content is incomplete.
const TEMPORARY_PREFIX: &str = ".nestd-";
const TEMPORARY_SUFFIX: &str = ".tmp";
/// Highest number that is added to a name to make it unique in a folder.
pub(crate) const MAX_NAME_NUMBER: u32 = 9999;

/// Renames `from` in `from_dir` to `to` in `to_dir`; an existing `to` is an error (`AlreadyExists`).
///
/// Some file systems (NFS) and old kernels do not support this. Then the target is checked first and renamed
/// afterwards; this is safe because only nestd uses these target names.
fn rename_at(from_dir: impl AsFd, from: &Path, to_dir: impl AsFd, to: &Path) -> io::Result<()> {
    match renameat_with(&from_dir, from, &to_dir, to, RenameFlags::NOREPLACE) {
        Err(Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP) => {
            match rustix::fs::statat(&to_dir, to, rustix::fs::AtFlags::SYMLINK_NOFOLLOW) {
                Err(Errno::NOENT) => Ok(renameat(from_dir, from, to_dir, to)?),
                Err(error) => Err(error.into()),
                Ok(_) => Err(io::ErrorKind::AlreadyExists.into()),
            }
        }
        other => Ok(other?),
    }
}

/// Renames without overwriting.
pub(crate) fn rename_noreplace(from: &Path, to: &Path) -> io::Result<()> {
    rename_at(CWD, from, CWD, to)
}

/// Renames `base/relative` to `to` without overwriting and without following links in `relative`. Otherwise somebody
/// could replace a sub-folder of the hot folder by a link and make nestd take files from elsewhere.
pub(crate) fn rename_out(base: &Path, relative: &Path, to: &Path) -> io::Result<()> {
    let name = relative.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    let folder = open_dir_beneath(base, relative.parent().unwrap_or(Path::new("")))?;
    rename_at(folder, Path::new(name), CWD, to)
}

/// Like [`rename_out`], but also works between file systems: the entry is then copied and removed, and links are copied
/// as links.
pub(crate) fn move_out_of(base: &Path, relative: &Path, to: &Path) -> io::Result<()> {
    match rename_out(base, relative, to) {
        Err(error) if error.kind() == io::ErrorKind::CrossesDevices => {}
        other => return other.and_then(|()| to.parent().map_or(Ok(()), fsync_dir)),
    }
    let folder = open_dir_beneath(base, relative.parent().unwrap_or(Path::new("")))?;
    // Addresses the opened folder itself, even if its path was replaced in the meantime.
    let open = PathBuf::from(format!("/proc/self/fd/{}", folder.as_raw_fd()));
    move_noreplace(&open.join(relative.file_name().ok_or(io::ErrorKind::InvalidInput)?), to)
}

/// Renames `from` to `base/relative` in the same way; creates missing sub-folders.
pub(crate) fn rename_in(from: &Path, base: &Path, relative: &Path) -> io::Result<()> {
    let name = relative.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    let above = relative.parent().unwrap_or(Path::new(""));
    let folder = create_dirs_beneath(base, above)?;
    rename_at(CWD, from, &folder, Path::new(name))?;
    File::from(folder).sync_all()
}

/// Opens `base/relative` and creates missing folders. A link in `relative` is an error.
pub(crate) fn create_dirs_beneath(base: &Path, relative: &Path) -> io::Result<OwnedFd> {
    create_dirs(base)?;
    let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
    let mut folder = openat(CWD, base, flags, Mode::empty())?;
    for part in relative.components() {
        let Component::Normal(name) = part else { return Err(io::ErrorKind::InvalidInput.into()) };
        let is_made = match mkdirat(&folder, name, Mode::from_raw_mode(0o777)) {
            Err(Errno::EXIST) => false,
            made => made.and_then(|()| fsync(&folder)).map(|()| true)?,
        };
        folder = openat(&folder, name, flags | OFlags::NOFOLLOW, Mode::empty())?;
        if is_made {
            access::apply_open_folder_permissions(&folder)?;
        }
    }
    Ok(folder)
}

/// Opens the regular file `base/relative` for reading. It follows no link in `relative` and does not block on a pipe.
pub(crate) fn open_beneath(base: &Path, relative: &Path) -> io::Result<File> {
    let folder = open_dir_beneath(base, relative.parent().unwrap_or(Path::new("")))?;
    require_regular(openat(
        &folder,
        relative.file_name().ok_or(io::ErrorKind::InvalidInput)?,
        READ_FLAGS,
        Mode::empty(),
    )?)
}

/// Opens the folder `base/relative`; a link in `relative` is an error.
pub(super) fn open_dir_beneath(base: &Path, relative: &Path) -> io::Result<OwnedFd> {
    let flags = OFlags::PATH | OFlags::DIRECTORY | OFlags::CLOEXEC;
    let mut folder = openat(CWD, base, flags, Mode::empty())?;
    for part in relative.components() {
        let Component::Normal(name) = part else { return Err(io::ErrorKind::InvalidInput.into()) };
        folder = openat(&folder, name, flags | OFlags::NOFOLLOW, Mode::empty())?;
    }
    Ok(folder)
}

/// Flags for opening a file that others may replace by a link or a pipe.
const READ_FLAGS: OFlags = OFlags::RDONLY.union(OFlags::NOFOLLOW).union(OFlags::NONBLOCK).union(OFlags::CLOEXEC);

/// Opens a regular file for reading. It follows no link and does not block on a pipe.
pub(crate) fn open_regular_file(path: &Path) -> io::Result<File> {
    require_regular(rustix::fs::open(path, READ_FLAGS, Mode::empty())?)
}

/// Reads the first bytes of a regular file, at most `max_bytes`. `None` if there is no file, or not a regular one.
pub fn read_start(path: &Path, max_bytes: u64) -> io::Result<Option<Vec<u8>>> {
    use io::ErrorKind::{InvalidInput, IsADirectory, NotFound};
    let mut bytes = Vec::new();
    match open_regular_file(path) {
        Ok(file) => file.take(max_bytes).read_to_end(&mut bytes).map(|_| Some(bytes)),
        Err(error) if matches!(error.kind(), NotFound | IsADirectory | InvalidInput) => Ok(None),
        // These error codes mean a link or a socket.
        Err(error) if [Errno::LOOP, Errno::NXIO].iter().any(|e| error.raw_os_error() == Some(e.raw_os_error())) => {
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

fn require_regular(opened: OwnedFd) -> io::Result<File> {
    let file = File::from(opened);
    match file.metadata()?.is_file() {
        true => Ok(file),
        false => Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file")),
    }
}

/// Makes the names in a folder durable.
pub(crate) fn fsync_dir(dir: &Path) -> io::Result<()> {
    File::open(dir)?.sync_all()
}

/// Creates a folder and its missing parents, and makes their names durable.
pub(crate) fn create_dirs(dir: &Path) -> io::Result<()> {
    if dir.is_dir() {
        return Ok(());
    }
    if let Some(above) = dir.parent().filter(|p| !p.as_os_str().is_empty()) {
        create_dirs(above)?;
    }
    match fs::create_dir(dir) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error),
        Err(error) if !dir.is_dir() => return Err(error),
        Err(_) => {}
        Ok(()) => access::apply_folder_permissions(dir)?,
    }
    dir.parent().filter(|p| !p.as_os_str().is_empty()).map_or(Ok(()), fsync_dir)
}

/// Path of the temporary file beside `path` while its content is incomplete. The name begins with a dot, so the scan
/// ignores it.
pub(super) fn temporary_path(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or(OsStr::new("file")).as_encoded_bytes();
    let hash = blake3::hash(name).to_hex();
    path.with_file_name(format!("{TEMPORARY_PREFIX}{}{TEMPORARY_SUFFIX}", &hash[..24]))
}

/// Whether a file has the name of one whose content is incomplete.
pub fn is_temporary_name(name: &OsStr) -> bool {
    let name = name.as_encoded_bytes();
    name.starts_with(TEMPORARY_PREFIX.as_bytes()) && name.ends_with(TEMPORARY_SUFFIX.as_bytes())
}

/// Creates a new file. An existing entry of that name (a leftover, a planted link) is removed first.
pub(crate) fn create_fresh_file(path: &Path) -> io::Result<File> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let file = OpenOptions::new().write(true).create_new(true).open(path)?;
    access::apply_file_permissions(&file)?;
    Ok(file)
}

/// Writes a file atomically: writes it under a temporary name, calls fsync, and renames it over the target.
pub fn write_file_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let part = temporary_path(path);
    let mut file = create_fresh_file(&part)?;
    file.write_all(bytes)?;
    file.sync_all()?;
    fs::rename(&part, path)?;
    path.parent().map_or(Ok(()), fsync_dir)
}

/// Copies a regular file to a free name. The copy is durable on return; `to` appears complete or not at all.
pub(crate) fn copy_noreplace(from: &Path, to: &Path) -> io::Result<()> {
    let part = temporary_path(to);
    let mut file = create_fresh_file(&part)?;
    io::copy(&mut open_regular_file(from)?, &mut file)?;
    file.sync_all()?;
    rename_noreplace(&part, to)?;
    to.parent().map_or(Ok(()), fsync_dir)
}

/// Moves the entry at `from` to the free name `to`, also between file systems. A file appears complete. After a crash
/// it may exist at both places, but never at neither.
pub(super) fn move_noreplace(from: &Path, to: &Path) -> io::Result<()> {
    match rename_noreplace(from, to) {
        Err(error) if error.kind() == io::ErrorKind::CrossesDevices => {}
        other => {
            other?;
            return to.parent().map_or(Ok(()), fsync_dir);
        }
    }
    let file_type = fs::symlink_metadata(from)?.file_type();
    if file_type.is_dir() {
        fs::create_dir(to)?;
        access::apply_folder_permissions(to)?;
        for entry in fs::read_dir(from)? {
            let entry = entry?;
            move_noreplace(&entry.path(), &to.join(entry.file_name()))?;
        }
        return fs::remove_dir(from);
    }
    if file_type.is_file() {
        copy_noreplace(from, to)?;
    } else if file_type.is_symlink() {
        std::os::unix::fs::symlink(fs::read_link(from)?, to)?;
    } else {
        // A socket, pipe or device has no content. An empty file keeps its name; the reason file says what it was.
        create_fresh_file(to)?;
    }
    fs::remove_file(from)?;
    from.parent().map_or(Ok(()), fsync_dir)
}

/// Moves an entry to a folder under the first free name of `name`, `name (2)`, `name (3)` and so on.
pub(crate) fn move_to_free_name(from: &Path, folder: &Path, name: &OsStr) -> io::Result<PathBuf> {
    for n in 1..=MAX_NAME_NUMBER {
        let to = folder.join(numbered_name(name, n));
        match move_noreplace(from, &to) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            other => return other.map(|()| to),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Whether two regular files have the same bytes. `false` if one cannot be read.
pub(crate) fn have_same_bytes(one: &Path, other: &Path) -> bool {
    matches!((hash_file(one), hash_file(other)), (Ok(a), Ok(b)) if a == b)
}

/// BLAKE3 hash of a regular file, 64 hex digits. Links are not followed.
pub fn hash_file(path: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(open_regular_file(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// Whether an entry exists at this path, including a dangling link. An entry that cannot be inspected counts as
/// missing.
pub(crate) fn path_exists(path: &Path) -> bool {
    try_path_exists(path).unwrap_or(false)
}

/// Whether an entry exists at this path, including a dangling link.
pub(crate) fn try_path_exists(path: &Path) -> io::Result<bool> {
    match fs::symlink_metadata(path) {
        Ok(_) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Whether this is one of several hard links to a file that is not readable by everyone. A user who may not read the
/// file can make a hard link to it, and nestd would then read it for that user.
pub(crate) fn is_hard_link_to_private_file(meta: &fs::Metadata) -> bool {
    const OTHERS_READ: u32 = 0o004;
    meta.is_file() && meta.nlink() > 1 && meta.mode() & OTHERS_READ == 0
}

/// Whether the file is unchanged since the scan and is not a hard link to a private file.
pub(crate) fn is_unchanged(seen: &InboxEntry, meta: &fs::Metadata) -> bool {
    meta.is_file()
        && (meta.ino(), ctime_ns(meta), meta.len()) == (seen.inode, seen.ctime_ns, seen.size)
        && !is_hard_link_to_private_file(meta)
}

/// Whether the renamed file is the one that had settled. The rename itself changes the ctime.
pub(crate) fn is_same_file(seen: &InboxEntry, now_at: &Path) -> bool {
    fs::symlink_metadata(now_at).is_ok_and(|meta| {
        meta.is_file()
            && (meta.len(), meta.ino(), meta.dev()) == (seen.size, seen.inode, seen.dev)
            && mtime_ns(&meta) == seen.mtime_ns
            && !is_hard_link_to_private_file(&meta)
    })
}

/// Nanoseconds since 1970 of the last change of contents.
pub(crate) fn mtime_ns(meta: &fs::Metadata) -> i128 {
    i128::from(meta.mtime()) * 1_000_000_000 + i128::from(meta.mtime_nsec())
}

/// Nanoseconds since 1970 of the last change of contents or attributes.
pub(crate) fn ctime_ns(meta: &fs::Metadata) -> i128 {
    i128::from(meta.ctime()) * 1_000_000_000 + i128::from(meta.ctime_nsec())
}

/// Converts a file time to [`SystemTime`].
pub(crate) fn to_system_time(ns: i128) -> SystemTime {
    UNIX_EPOCH + std::time::Duration::from_nanos(u64::try_from(ns).unwrap_or(0))
}

/// All files below a folder, sorted. Links are not followed, even if `dir` is one.
pub fn files_below(dir: &Path) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    if !fs::symlink_metadata(dir)?.is_dir() {
        return Err(io::ErrorKind::NotADirectory.into());
    }
    for entry in fs::read_dir(dir)? {
        let entry = entry?;
        match entry.file_type()?.is_dir() {
            true => files.extend(files_below(&entry.path())?),
            false => files.push(entry.path()),
        }
    }
    files.sort();
    Ok(files)
}

/// Removes a folder with all that is in it, if it is there.
pub(crate) fn remove_folder(dir: &Path) -> io::Result<()> {
    match fs::remove_dir_all(dir) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Removes a folder and its sub-folders if they hold no file. A file in one of them is an error.
pub(crate) fn remove_empty_folders(dir: &Path) -> io::Result<()> {
    for entry in fs::read_dir(dir)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            remove_empty_folders(&entry.path())?;
        }
    }
    fs::remove_dir(dir)
}

/// Removes `dir` and its parent folders while they are empty, up to but not including `top`.
pub(crate) fn remove_empty_parents(dir: &Path, top: &Path) {
    let mut dir = dir;
    while dir != top && dir.starts_with(top) && fs::remove_dir(dir).is_ok() {
        let Some(above) = dir.parent() else { return };
        dir = above;
    }
}
