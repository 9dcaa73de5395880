//! Small file-system steps: a rename that overwrites nothing, folders that are on disk when a function returns, sub-folders
//! opened without following a link.

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

use super::{Seen, name::numbered};
use crate::access;

/// So many things of one name fit into a folder.
pub(super) const MAX_NUMBER: u32 = 9999;

/// Renames `from` in `from_dir` to `to` in `to_dir`; an existing `to` is an error (`AlreadyExists`).
///
/// Where the file system cannot promise that (NFS, old kernels), it is looked first and then renamed: only nestd gives
/// the names that it renames to.
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
pub(super) fn rename_noreplace(from: &Path, to: &Path) -> io::Result<()> {
    rename_at(CWD, from, CWD, to)
}

/// Renames `base/relative` to `to` without overwriting and without following a link in `relative`: a sub-folder of the
/// hot folder that was swapped for a link must not make nestd take files from elsewhere.
pub(super) fn rename_out(base: &Path, relative: &Path, to: &Path) -> io::Result<()> {
    let name = relative.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    let folder = open_dir_beneath(base, relative.parent().unwrap_or(Path::new("")))?;
    rename_at(folder, Path::new(name), CWD, to)
}

/// As [`rename_out`], between file systems too: what stands there is then copied and removed, links as links.
pub(super) fn move_out(base: &Path, relative: &Path, to: &Path) -> io::Result<()> {
    match rename_out(base, relative, to) {
        Err(error) if error.kind() == io::ErrorKind::CrossesDevices => {}
        other => return other.and_then(|()| to.parent().map_or(Ok(()), fsync_dir)),
    }
    let folder = open_dir_beneath(base, relative.parent().unwrap_or(Path::new("")))?;
    // The folder that is open, whatever its path has become meanwhile.
    let open = PathBuf::from(format!("/proc/self/fd/{}", folder.as_raw_fd()));
    move_noreplace(&open.join(relative.file_name().ok_or(io::ErrorKind::InvalidInput)?), to)
}

/// Renames `from` to `base/relative`, likewise; makes the sub-folders that are missing.
pub(super) fn rename_in(from: &Path, base: &Path, relative: &Path) -> io::Result<()> {
    let name = relative.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    let above = relative.parent().unwrap_or(Path::new(""));
    let folder = create_dirs_beneath(base, above)?;
    rename_at(CWD, from, &folder, Path::new(name))?;
    File::from(folder).sync_all()
}

/// Opens `base/relative` and makes what is missing of it; a link in `relative` is not followed but an error.
pub(super) fn create_dirs_beneath(base: &Path, relative: &Path) -> io::Result<OwnedFd> {
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
            access::of_open_folder(&folder)?;
        }
    }
    Ok(folder)
}

/// Opens the regular file `base/relative` to read: no link is followed anywhere in `relative`, no pipe is waited for.
pub(super) fn open_beneath(base: &Path, relative: &Path) -> io::Result<File> {
    let folder = open_dir_beneath(base, relative.parent().unwrap_or(Path::new("")))?;
    regular(openat(&folder, relative.file_name().ok_or(io::ErrorKind::InvalidInput)?, READ, Mode::empty())?)
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

/// How a file is opened that others can put something else in the place of.
const READ: OFlags = OFlags::RDONLY.union(OFlags::NOFOLLOW).union(OFlags::NONBLOCK).union(OFlags::CLOEXEC);

/// Opens a regular file to read: no link is followed, no pipe is waited for.
pub(super) fn open_regular(path: &Path) -> io::Result<File> {
    regular(rustix::fs::open(path, READ, Mode::empty())?)
}

/// The first bytes of a regular file, `max_bytes` at most; `None` where there is none, or something else.
pub fn read_start(path: &Path, max_bytes: u64) -> io::Result<Option<Vec<u8>>> {
    use io::ErrorKind::{InvalidInput, IsADirectory, NotFound};
    let mut bytes = Vec::new();
    match open_regular(path) {
        Ok(file) => file.take(max_bytes).read_to_end(&mut bytes).map(|_| Some(bytes)),
        Err(error) if matches!(error.kind(), NotFound | IsADirectory | InvalidInput) => Ok(None),
        // How a link and a socket are told.
        Err(error) if [Errno::LOOP, Errno::NXIO].iter().any(|e| error.raw_os_error() == Some(e.raw_os_error())) => {
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

fn regular(opened: OwnedFd) -> io::Result<File> {
    let file = File::from(opened);
    match file.metadata()?.is_file() {
        true => Ok(file),
        false => Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file")),
    }
}

/// Makes the names in a folder last.
pub(super) fn fsync_dir(dir: &Path) -> io::Result<()> {
    File::open(dir)?.sync_all()
}

/// Creates a folder and those above it that are missing, and makes their names last.
pub(super) fn create_dirs(dir: &Path) -> io::Result<()> {
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
        Ok(()) => access::of_folder(dir)?,
    }
    dir.parent().filter(|p| !p.as_os_str().is_empty()).map_or(Ok(()), fsync_dir)
}

/// A dot-name beside `path` for what is not whole yet; the scan ignores it.
pub(super) fn unfinished(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or(OsStr::new("file")).as_encoded_bytes();
    let hash = blake3::hash(name).to_hex();
    path.with_file_name(format!(".nestd-{}.tmp", &hash[..24]))
}

/// Creates the file anew; whatever stood under that dot-name (a leftover, a planted link) goes.
pub(super) fn create_anew(path: &Path) -> io::Result<File> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let file = OpenOptions::new().write(true).create_new(true).open(path)?;
    access::of_file(&file)?;
    Ok(file)
}

/// Writes a whole file under a dot-name, fsyncs and renames it, replacing what stood there.
pub fn write_by_rename(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let part = unfinished(path);
    let mut file = create_anew(&part)?;
    file.write_all(bytes)?;
    file.sync_all()?;
    fs::rename(&part, path)?;
    path.parent().map_or(Ok(()), fsync_dir)
}

/// Copies a regular file to a free name, on disk when it returns; `to` appears whole or not at all.
pub(super) fn copy_noreplace(from: &Path, to: &Path) -> io::Result<()> {
    let part = unfinished(to);
    let mut file = create_anew(&part)?;
    io::copy(&mut open_regular(from)?, &mut file)?;
    file.sync_all()?;
    rename_noreplace(&part, to)?;
    to.parent().map_or(Ok(()), fsync_dir)
}

/// Moves whatever stands at `from` to the free name `to`, between file systems too. A file appears whole; a crash between
/// leaves it at both places, never at none.
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
        access::of_folder(to)?;
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
        // A socket, pipe or device holds no bytes: its name and kind are in the reason.
        create_anew(to)?;
    }
    fs::remove_file(from)?;
    from.parent().map_or(Ok(()), fsync_dir)
}

/// Moves to the first free of `name`, `name (2)`, `name (3)` in a folder.
pub(super) fn move_to_free_name(from: &Path, folder: &Path, name: &OsStr) -> io::Result<PathBuf> {
    for n in 1..=MAX_NUMBER {
        let to = folder.join(numbered(name, n));
        match move_noreplace(from, &to) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            other => return other.map(|()| to),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Whether two regular files hold the same bytes; an unreadable one holds none.
pub(super) fn same_bytes(one: &Path, other: &Path) -> bool {
    matches!((hash_file(one), hash_file(other)), (Ok(a), Ok(b)) if a == b)
}

/// BLAKE3 of a regular file, 64 hex digits; no link is followed.
pub fn hash_file(path: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(open_regular(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// Whether something stands under this name, a dangling link too; what cannot be looked at is taken for gone.
pub(super) fn is_there(path: &Path) -> bool {
    try_is_there(path).unwrap_or(false)
}

/// Whether something stands under this name, a dangling link too.
pub(super) fn try_is_there(path: &Path) -> io::Result<bool> {
    match fs::symlink_metadata(path) {
        Ok(_) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Whether this is one of several names of a file that not everybody may read: whoever made a hard link to it may be one
/// who may not, and would have nestd read it for him.
pub(super) fn is_second_name_of_a_secret(meta: &fs::Metadata) -> bool {
    const OTHERS_READ: u32 = 0o004;
    meta.is_file() && meta.nlink() > 1 && meta.mode() & OTHERS_READ == 0
}

/// Whether this is what a scan saw, unchanged, and no link to a secret.
pub(super) fn is_still(seen: &Seen, meta: &fs::Metadata) -> bool {
    meta.is_file()
        && (meta.ino(), ctime_ns(meta), meta.len()) == (seen.inode, seen.ctime_ns, seen.size)
        && !is_second_name_of_a_secret(meta)
}

/// Nanoseconds since 1970 of the last change of contents.
pub(super) fn mtime_ns(meta: &fs::Metadata) -> i128 {
    i128::from(meta.mtime()) * 1_000_000_000 + i128::from(meta.mtime_nsec())
}

/// Nanoseconds since 1970 of the last change of contents or attributes.
pub(super) fn ctime_ns(meta: &fs::Metadata) -> i128 {
    i128::from(meta.ctime()) * 1_000_000_000 + i128::from(meta.ctime_nsec())
}

/// A file time as the system's.
pub(super) fn as_time(ns: i128) -> SystemTime {
    UNIX_EPOCH + std::time::Duration::from_nanos(u64::try_from(ns).unwrap_or(0))
}

/// All files below a folder, sorted; links are not followed, also where `dir` is one.
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

/// Removes a folder and its sub-folders as far as they hold no file; one that holds something is an error.
pub(super) fn remove_empty_folders(dir: &Path) -> io::Result<()> {
    for entry in fs::read_dir(dir)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            remove_empty_folders(&entry.path())?;
        }
    }
    fs::remove_dir(dir)
}

/// Removes `dir` and the folders above it up to `top` (which stays) as long as they are empty.
pub(super) fn remove_empty_up_to(dir: &Path, top: &Path) {
    let mut dir = dir;
    while dir != top && dir.starts_with(top) && fs::remove_dir(dir).is_ok() {
        let Some(above) = dir.parent() else { return };
        dir = above;
    }
}
