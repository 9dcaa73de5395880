//! Order archives: a ZIP file in a hot folder becomes the order folder that was packed into it.
//!
//! The files are unpacked into `.claimed/.unpack-<inode>-<mtime>/files`, then the archive is moved beside them, and then `files`
//! becomes the order folder by one rename. After a crash, an archive that lies beside `files` was unpacked whole and goes on from
//! there; one that is still in the hot folder is unpacked once more. So an order is never there twice, and never in part.

use std::{
    collections::{BTreeMap, BTreeSet},
    ffi::{OsStr, OsString},
    fs::{self, File},
    io::{self, BufReader, Read},
    os::unix::ffi::{OsStrExt, OsStringExt},
    path::{Path, PathBuf},
    time::SystemTime,
};

use build_file::{MAX_RATIO, RATIO_FREE_BYTES, ReadLimits, escape_invisible};
use zip::{ZipArchive, read::ZipFile, result::ZipError};

use super::scan::is_file_name;
use crate::{
    ClaimError, InboxEntry, display_name,
    folder::{
        claim_folder::{CLAIMED_DIR, lock_claims},
        claimed_part::io_error,
        disk,
        file_role::has_extension,
        ignore::is_ignored,
    },
    lists::hidden_sidecar::is_hidden_sidecar,
    names::{code_page::decode_dos_name, name::numbered_name},
};

/// Prefix of the folder that an archive is unpacked in.
pub(super) const UNPACK_PREFIX: &str = ".unpack-";
/// Sub-folder of what was unpacked.
const FILES: &str = "files";
/// Sub-folder of the archive, once all is unpacked, at its path below the hot folder.
const ARCHIVE: &str = "archive";

/// What became of an archive.
#[derive(Debug, PartialEq, Eq)]
pub enum UnpackOutcome {
    /// It is gone, and its files are in this order folder.
    Unpacked(PathBuf),
    /// It stays where it is: the reason to refuse it, in whole sentences.
    Refused(String),
}

/// Why an archive was not unpacked.
enum UnpackError {
    Refused(String),
    Io(io::Error),
}

impl From<io::Error> for UnpackError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl From<ZipError> for UnpackError {
    fn from(error: ZipError) -> Self {
        match error {
            // The archive is damaged where it tells so; a disk that fails has an error number.
            ZipError::Io(error) if error.raw_os_error().is_some() => Self::Io(error),
            other => Self::Refused(format!(
                "This archive cannot be unpacked: {}. Pack it once more as an ordinary ZIP file without a password, or unpack it \
                 and drop the folder.",
                escape_invisible(&other.to_string())
            )),
        }
    }
}

/// Whether a file is an archive to be unpacked: by its name and what it holds. A 3MF file or a workbook under such a name is a
/// package, and no archive.
pub fn is_order_archive(inbox: &Path, path: &Path) -> bool {
    has_extension(path, &["zip"])
        && open_archive(inbox, path).is_ok_and(|archive| {
            !archive.is_empty()
                && archive.index_for_name("_rels/.rels").is_none()
                && !archive.file_names().any(is_camspec)
        })
}

/// Whether an entry describes the order of a CAMSPEC file.
fn is_camspec(name: &str) -> bool {
    ["camspec.json", ".camspec.json"].iter().any(|known| name.eq_ignore_ascii_case(known))
}

fn open_archive(inbox: &Path, path: &Path) -> Result<ZipArchive<BufReader<File>>, UnpackError> {
    let relative = path.strip_prefix(inbox).map_err(|_| io::Error::from(io::ErrorKind::NotFound))?;
    let mut file = disk::open_beneath(inbox, relative)?;
    let bytes = file.metadata()?.len();
    let declared = build_file::declared_entries(&mut file, bytes)?;
    let archive = ZipArchive::new(BufReader::new(file))?;
    // Of two entries with one name, this reader keeps one, and others the other.
    if declared != Some(archive.len() as u64) {
        return Err(UnpackError::Refused(
            "This archive names a file twice. Unpack it, and drop the folder.".to_owned(),
        ));
    }
    Ok(archive)
}

/// Unpacks a settled archive into an order folder of its name, beside it. A folder that all its files are in is left out. Unpacked are
/// at most `limits.max_unpacked_bytes` and `limits.max_entries`.
///
/// # Errors
/// It changed or went, or the disk failed. It is then where it was.
pub fn unpack_archive(inbox: &Path, seen: &InboxEntry, limits: &ReadLimits) -> Result<UnpackOutcome, ClaimError> {
    unpack_stepwise(inbox, seen, limits, &mut || {})
}

/// Calls `step` between any two steps where a crash could happen, so that tests can stop there.
pub(super) fn unpack_stepwise(
    inbox: &Path,
    seen: &InboxEntry,
    limits: &ReadLimits,
    step: &mut dyn FnMut(),
) -> Result<UnpackOutcome, ClaimError> {
    let _only_one = lock_claims(inbox);
    let relative = seen.path.strip_prefix(inbox).map_err(|_| ClaimError::Gone(seen.path.clone()))?;
    let made = inbox.join(CLAIMED_DIR).join(format!("{UNPACK_PREFIX}{}-{}", seen.inode, seen.mtime_ns));
    let failed = |error| io_error("unpack", &seen.path, error);
    disk::remove_folder(&made).map_err(failed)?;
    disk::create_dirs_beneath(inbox, Path::new(CLAIMED_DIR)).map_err(failed)?;
    if let Err(error) = unpack_files(inbox, seen, &made.join(FILES), limits, step) {
        disk::remove_folder(&made).map_err(failed)?;
        return match error {
            UnpackError::Refused(reason) => Ok(UnpackOutcome::Refused(reason)),
            UnpackError::Io(error) if error.kind() == io::ErrorKind::NotFound => {
                Err(ClaimError::Gone(seen.path.clone()))
            }
            UnpackError::Io(error) => Err(failed(error)),
        };
    }
    step();
    let kept = made.join(ARCHIVE).join(relative);
    disk::create_dirs(kept.parent().unwrap_or(&made)).map_err(failed)?;
    let is_same = fs::symlink_metadata(&seen.path).is_ok_and(|meta| disk::is_unchanged(seen, &meta));
    if !is_same {
        disk::remove_folder(&made).map_err(failed)?;
        return Err(ClaimError::Changed(seen.path.clone()));
    }
    step();
    disk::rename_out(inbox, relative, &kept).map_err(failed)?;
    step();
    if !disk::is_same_file(seen, &kept) {
        disk::rename_in(&kept, inbox, relative).map_err(failed)?;
        disk::remove_folder(&made).map_err(failed)?;
        return Err(ClaimError::Changed(seen.path.clone()));
    }
    finish(inbox, &made, step)
        .map_err(failed)?
        .map(UnpackOutcome::Unpacked)
        .ok_or_else(|| ClaimError::Gone(seen.path.clone()))
}

/// Goes on with what a crash left of unpacking in `.claimed/`: an archive that was unpacked whole becomes its order folder, and what
/// is incomplete is removed, since its archive is still in the hot folder.
pub(super) fn finish_unpacked(inbox: &Path, made: &Path) -> io::Result<()> {
    finish(inbox, made, &mut || {}).map(|_| ())
}

fn finish(inbox: &Path, made: &Path, step: &mut dyn FnMut()) -> io::Result<Option<PathBuf>> {
    let top = made.join(ARCHIVE);
    let archive = match disk::try_path_exists(&top)? {
        true => disk::files_below(&top)?.into_iter().next(),
        false => None,
    };
    let mut order = None;
    if let Some(archive) = archive.filter(|_| made.join(FILES).is_dir()) {
        let folder = order_folder(archive.strip_prefix(&top).unwrap_or(&archive));
        order = Some(move_to_free_folder(&made.join(FILES), inbox, &folder)?);
        step();
    }
    disk::remove_folder(made)?;
    disk::fsync_dir(&inbox.join(CLAIMED_DIR))?;
    Ok(order)
}

/// The order folder of an archive: named like it, and so that a scan takes it for an order.
fn order_folder(archive: &Path) -> PathBuf {
    let mut folder = archive.with_extension("");
    while let Some(name) = folder.file_name().filter(|name| is_ignored(name) || is_file_name(name)) {
        folder = match folder.extension() {
            Some(_) => folder.with_extension(""),
            None => {
                let mut name = name.to_owned();
                name.push(" order");
                folder.with_file_name(name)
            }
        };
    }
    folder
}

fn move_to_free_folder(files: &Path, inbox: &Path, folder: &Path) -> io::Result<PathBuf> {
    let name = folder.file_name().unwrap_or(OsStr::new("order"));
    for n in 1..=disk::MAX_NAME_NUMBER {
        let to = folder.with_file_name(numbered_name(name, n));
        match disk::rename_in(files, inbox, &to) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            other => return other.map(|()| inbox.join(to)),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Unpacks all files into `folder`, durably.
fn unpack_files(
    inbox: &Path,
    seen: &InboxEntry,
    folder: &Path,
    limits: &ReadLimits,
    step: &mut dyn FnMut(),
) -> Result<(), UnpackError> {
    let mut archive = open_archive(inbox, &seen.path)?;
    let paths = paths_in_archive(&mut archive, limits)?;
    disk::create_dirs(folder)?;
    let mut left = limits.max_unpacked_bytes;
    for (path, index) in &paths {
        step();
        let mut entry = archive.by_index(*index)?;
        let to = folder.join(path);
        disk::create_dirs(to.parent().unwrap_or(folder))?;
        let mut file = disk::create_fresh_file(&to)?;
        let most = left.min(entry.compressed_size().saturating_mul(MAX_RATIO).max(RATIO_FREE_BYTES));
        let written = match io::copy(&mut (&mut entry).take(most.saturating_add(1)), &mut file) {
            Err(error) if error.raw_os_error().is_none() => return Err(ZipError::Io(error).into()),
            other => other?,
        };
        if written > most {
            return Err(UnpackError::Refused(format!(
                "This archive unpacks to more than the limit (`max_unpacked_bytes` = {}, and {MAX_RATIO} times its size for a file). \
                 Unpack it, and drop the folder.",
                limits.max_unpacked_bytes
            )));
        }
        left -= written;
        file.set_modified(time_of(&entry).unwrap_or_else(|| disk::to_system_time(seen.mtime_ns)))?;
    }
    // One call for all files: each of them has to be on the disk before the archive goes.
    rustix::fs::syncfs(File::open(folder)?).map_err(io::Error::from)?;
    Ok(())
}

/// The files to unpack, by their path in the order folder, with their index. Names that are neither UTF-8 nor of DOS keep their bytes.
fn paths_in_archive(
    archive: &mut ZipArchive<BufReader<File>>,
    limits: &ReadLimits,
) -> Result<BTreeMap<PathBuf, usize>, UnpackError> {
    if archive.len() as u64 > limits.max_entries {
        return Err(UnpackError::Refused(format!(
            "This archive has {} entries; the limit is {} (`max_entries`). Unpack it, and drop the folder.",
            archive.len(),
            limits.max_entries
        )));
    }
    let mut paths = BTreeMap::new();
    for index in 0..archive.len() {
        let entry = archive.by_index(index)?;
        let Some(path) = path_of(&entry)? else { continue };
        let shown = display_name(path.as_os_str());
        if has_extension(&path, &["zip"]) {
            return Err(UnpackError::Refused(format!(
                "This archive has another archive in it, \"{shown}\". Unpack both, and drop the folder."
            )));
        }
        if paths.insert(path, index).is_some() {
            return Err(UnpackError::Refused(format!(
                "This archive names \"{shown}\" twice. Unpack it, and drop the folder."
            )));
        }
    }
    if paths.is_empty() {
        return Err(UnpackError::Refused(
            "This archive has no file in it. Pack the parts into it, and drop it again.".into(),
        ));
    }
    let tops: BTreeSet<&OsStr> = paths.keys().filter_map(|path| path.iter().next()).collect();
    let is_one_folder = tops.len() == 1 && paths.keys().all(|path| path.iter().count() > 1);
    Ok(match is_one_folder {
        true => paths.into_iter().map(|(path, index)| (path.iter().skip(1).collect(), index)).collect(),
        false => paths,
    })
}

/// The path of a file to unpack; `None` for folders, and for what a scan would ignore.
fn path_of(entry: &ZipFile<'_, BufReader<File>>) -> Result<Option<PathBuf>, UnpackError> {
    let mut bytes = entry.name_raw().to_vec();
    if let Some(name) = decode_dos_name(&bytes) {
        bytes = name.into_bytes();
    }
    // Old programs for Windows write such paths. In names of other bytes it may be the second half of a letter.
    if bytes.is_ascii() && !bytes.contains(&b'/') {
        bytes.iter_mut().filter(|byte| **byte == b'\\').for_each(|byte| *byte = b'/');
    }
    let is_strange =
        bytes.contains(&0) || bytes.starts_with(b"/") || bytes.split(|&byte| byte == b'/').any(|one| one == b"..");
    if is_strange || entry.is_symlink() {
        let name = display_name(OsStr::from_bytes(&bytes));
        let names = match is_strange {
            true => format!("This archive names a file outside of it, \"{name}\"."),
            false => format!("This archive names a link, \"{name}\"."),
        };
        return Err(UnpackError::Refused(format!("{names} Unpack it, and drop the files that are meant.")));
    }
    if bytes.ends_with(b"/") {
        return Ok(None);
    }
    let components = bytes.split(|&byte| byte == b'/').filter(|one| !one.is_empty() && *one != b".");
    let path: PathBuf = components.map(|one| OsString::from_vec(one.to_vec())).collect();
    let is_left = |name: &OsStr| is_ignored(name) && !is_hidden_sidecar(name);
    Ok((!path.as_os_str().as_bytes().is_empty() && !path.iter().any(is_left)).then_some(path))
}

/// When a file was changed last. The same archive gives the same times, by which a drop that comes again is known.
fn time_of(entry: &ZipFile<'_, BufReader<File>>) -> Option<SystemTime> {
    let time = entry.last_modified()?;
    let date = jiff::civil::Date::new(i16::try_from(time.year()).ok()?, time.month() as i8, time.day() as i8).ok()?;
    let clock = jiff::civil::Time::new(time.hour() as i8, time.minute() as i8, time.second().min(59) as i8, 0).ok()?;
    Some(date.to_datetime(clock).to_zoned(jiff::tz::TimeZone::UTC).ok()?.timestamp().into())
}

#[cfg(test)]
#[path = "tests/unpack_tests.rs"]
mod tests;
