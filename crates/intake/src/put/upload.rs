//! Files that come from a page instead of a copying program. Each is written into the hot folder under a name that begins with a dot,
//! which a scan ignores, and renamed when it is there as a whole: so everything that the hot folder promises holds for it, too.

use std::{
    ffi::{OsStr, OsString},
    fs::{self, File},
    io::{self, Write},
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

use crate::{
    display_name,
    folder::{
        control_file::named_control,
        disk::{create_fresh_file, fsync_dir, rename_noreplace, try_path_exists},
        ignore::{is_ignored, is_status_file},
    },
    lists::folder_lists::WORKBOOKS,
    names::name::{MAX_NAME_BYTES, numbered_name},
};

/// How the name of a file begins that has not arrived as a whole.
const UNFINISHED_PREFIX: &str = ".nestd-upload-";
/// Endings of texts that say something about other files, as workbooks do.
const SIDECAR_ENDINGS: [&str; 5] = ["csv", "tsv", "txt", "toml", "json"];
/// A name is tried with numbers up to this.
const MAX_NUMBER: u32 = 1000;
/// Room in a name for a number and the ending of a ticket, bytes.
const NAME_RESERVE: usize = 16;

/// Why a file cannot be taken from a page. Whether it can be printed is for the hot folder to say.
#[derive(Debug, thiserror::Error)]
pub enum UploadError {
    /// The name cannot be that of a part.
    #[error("{name}: {why}")]
    Name {
        /// The name, escaped.
        name: String,
        /// Why not.
        why: &'static str,
    },
    /// It is larger than the farm takes.
    #[error("{name} is larger than {max_bytes} bytes (limits.max_bytes)")]
    TooLarge {
        /// The name, escaped.
        name: String,
        /// The limit.
        max_bytes: u64,
    },
    /// It cannot be written.
    #[error("{name} cannot be written into the hot folder: {source}")]
    Write {
        /// The name, escaped.
        name: String,
        /// What the system says.
        source: io::Error,
    },
}

/// A file that is arriving. It is removed unless it is finished.
#[derive(Debug)]
pub struct UploadedFile {
    name: OsString,
    path: PathBuf,
    file: File,
    bytes: u64,
    max_bytes: u64,
    is_finished: bool,
}

/// The name under which a file from a page may lie in a hot folder: without the folders of the computer that it comes from.
///
/// # Errors
/// `Name` where it would be no part there.
pub fn check_upload_name(name: &str) -> Result<OsString, UploadError> {
    let name = name.rsplit(['/', '\\']).next().unwrap_or_default().trim();
    let refused = |why| Err(UploadError::Name { name: display_name(OsStr::new(name)), why });
    let raw = OsStr::new(name);
    let ending = Path::new(name).extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase();
    match () {
        () if name.is_empty() || name.chars().any(|letter| letter.is_control()) => refused("this is no name of a file"),
        () if name.len() > MAX_NAME_BYTES - NAME_RESERVE => refused("the name is too long"),
        () if is_ignored(raw) => refused("the hot folder ignores files of this name"),
        () if is_status_file(raw) || named_control(raw).is_some() => {
            refused("the hot folder has its own use for this name")
        }
        () if SIDECAR_ENDINGS.iter().chain(&WORKBOOKS).any(|sidecar| *sidecar == ending) => {
            refused("a list or ticket speaks of other files: put it into the hot folder itself, beside them")
        }
        () => Ok(raw.to_owned()),
    }
}

impl UploadedFile {
    /// Begins a file in a hot folder. `token` distinguishes it from every other one that is arriving.
    ///
    /// # Errors
    /// `Name` for a name that cannot be a part, `Write` where the folder cannot be written.
    pub fn begin(inbox: &Path, name: &str, token: u128, max_bytes: u64) -> Result<Self, UploadError> {
        let name = check_upload_name(name)?;
        let path = inbox.join(format!("{UNFINISHED_PREFIX}{token:032x}"));
        let opened = create_fresh_file(&path);
        let file = opened.map_err(|source| UploadError::Write { name: display_name(&name), source })?;
        Ok(Self { name, path, file, bytes: 0, max_bytes, is_finished: false })
    }

    /// Its name, escaped for people.
    pub fn shown_name(&self) -> String {
        display_name(&self.name)
    }

    /// Adds what has arrived.
    ///
    /// # Errors
    /// `TooLarge` beyond the limit, `Write` where the disk is full.
    pub fn write_chunk(&mut self, chunk: &[u8]) -> Result<(), UploadError> {
        self.bytes += chunk.len() as u64;
        if self.bytes > self.max_bytes {
            return Err(UploadError::TooLarge { name: self.shown_name(), max_bytes: self.max_bytes });
        }
        self.file.write_all(chunk).map_err(|source| UploadError::Write { name: self.shown_name(), source })
    }

    /// Makes the file visible in the hot folder under a name that is free, with a ticket beside it; "" = none. Returns the name,
    /// escaped.
    ///
    /// # Errors
    /// `Write` where the folder cannot be written; nothing of it is left then.
    pub fn finish(mut self, ticket: &str) -> Result<String, UploadError> {
        let placed = self.place_file(ticket);
        let name = placed.map_err(|source| UploadError::Write { name: self.shown_name(), source })?;
        self.is_finished = true;
        Ok(display_name(&name))
    }

    fn place_file(&self, ticket: &str) -> io::Result<OsString> {
        self.file.sync_all()?;
        let folder = self.path.parent().unwrap_or(Path::new("."));
        for number in 1..=MAX_NUMBER {
            let name = numbered_name(&self.name, number);
            if self.take_name(folder, &name, ticket)? {
                fsync_dir(folder)?;
                return Ok(name);
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    /// Renames the file to this name, after its ticket; `false` if one of the two names is taken.
    fn take_name(&self, folder: &Path, name: &OsStr, ticket: &str) -> io::Result<bool> {
        let target = folder.join(name);
        let mut ticket_name = name.to_owned();
        ticket_name.push(".toml");
        let ticket_path = folder.join(ticket_name);
        if try_path_exists(&target)? || try_path_exists(&ticket_path)? {
            return Ok(false);
        }
        if !ticket.is_empty() && !place_ticket(&self.path, &ticket_path, ticket)? {
            return Ok(false);
        }
        match rename_noreplace(&self.path, &target) {
            Ok(()) => Ok(true),
            Err(error) => {
                if !ticket.is_empty() {
                    fs::remove_file(&ticket_path)?;
                }
                if error.kind() == io::ErrorKind::AlreadyExists { Ok(false) } else { Err(error) }
            }
        }
    }
}

/// Writes a ticket under a name that a scan ignores, then renames it; `false` if its name is taken.
fn place_ticket(unfinished: &Path, path: &Path, ticket: &str) -> io::Result<bool> {
    let mut name = unfinished.file_name().unwrap_or_default().to_owned();
    name.push("-ticket");
    let hidden = unfinished.with_file_name(name);
    let written = create_fresh_file(&hidden).and_then(|mut file| {
        file.write_all(ticket.as_bytes())?;
        file.sync_all()?;
        rename_noreplace(&hidden, path)
    });
    match written {
        Ok(()) => Ok(true),
        Err(error) => {
            _ = fs::remove_file(&hidden);
            if error.kind() == io::ErrorKind::AlreadyExists { Ok(false) } else { Err(error) }
        }
    }
}

impl Drop for UploadedFile {
    fn drop(&mut self) {
        if !self.is_finished {
            _ = fs::remove_file(&self.path);
        }
    }
}

/// Removes what was arriving in a hot folder when a daemon ended: nothing was added to it for this time.
///
/// # Errors
/// When the folder cannot be read or written.
pub fn remove_unfinished_uploads(inbox: &Path, quiet_for: Duration) -> io::Result<()> {
    for entry in fs::read_dir(inbox)? {
        let entry = entry?;
        let is_ours = entry.file_name().as_encoded_bytes().starts_with(UNFINISHED_PREFIX.as_bytes());
        let is_quiet = |changed: SystemTime| changed.elapsed().is_ok_and(|age| age >= quiet_for);
        if is_ours && entry.file_type()?.is_file() && is_quiet(entry.metadata()?.modified()?) {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut all: Vec<String> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        all.sort();
        all
    }

    fn begun(inbox: &Path, name: &str, token: u128) -> UploadedFile {
        UploadedFile::begin(inbox, name, token, 10).unwrap()
    }

    #[test]
    fn a_file_appears_as_a_whole_with_its_ticket_under_names_that_are_free() {
        let inbox = tempfile::tempdir().unwrap();
        fs::write(inbox.path().join("a.stl"), "old").unwrap();
        fs::write(inbox.path().join("a (2).stl.toml"), "copies = 7").unwrap();
        let mut file = begun(inbox.path(), "C:\\parts\\a.stl", 1);
        file.write_chunk(b"solid").unwrap();
        assert!(names(inbox.path()).iter().filter(|name| name.starts_with(".nestd-upload-")).count() == 1);
        assert_eq!(file.finish("copies = 2\n").unwrap(), "a (3).stl");
        assert_eq!(names(inbox.path()), ["a (2).stl.toml", "a (3).stl", "a (3).stl.toml", "a.stl"]);
        assert_eq!(fs::read_to_string(inbox.path().join("a (3).stl")).unwrap(), "solid");
        assert_eq!(fs::read_to_string(inbox.path().join("a (3).stl.toml")).unwrap(), "copies = 2\n");
        assert_eq!(fs::read_to_string(inbox.path().join("a.stl")).unwrap(), "old");
        assert_eq!(begun(inbox.path(), "b.3mf", 2).finish("").unwrap(), "b.3mf");
    }

    #[test]
    fn what_does_not_arrive_as_a_whole_leaves_nothing_behind() {
        let inbox = tempfile::tempdir().unwrap();
        let mut file = begun(inbox.path(), "a.stl", 1);
        file.write_chunk(b"12345").unwrap();
        assert!(matches!(file.write_chunk(b"678901"), Err(UploadError::TooLarge { max_bytes: 10, .. })));
        drop(file);
        drop(begun(inbox.path(), "a.stl", 2));
        assert!(names(inbox.path()).is_empty());
        std::mem::forget(begun(inbox.path(), "a.stl", 3));
        fs::write(inbox.path().join(".other"), "").unwrap();
        remove_unfinished_uploads(inbox.path(), Duration::from_secs(600)).unwrap();
        assert_eq!(names(inbox.path()).len(), 2, "it may still arrive");
        remove_unfinished_uploads(inbox.path(), Duration::ZERO).unwrap();
        assert_eq!(names(inbox.path()), [".other"]);
        assert!(UploadedFile::begin(&inbox.path().join("gone"), "a.stl", 1, 10).is_err());
    }

    #[test]
    fn names_that_mean_something_else_in_a_hot_folder_are_refused() {
        for name in [
            "",
            "  ",
            "..",
            ".hidden.stl",
            "FLUSH",
            "flush",
            "STATUS.txt",
            "order.csv",
            "a.stl.toml",
            "x.tmp",
            "a/",
            "a\nb.stl",
        ] {
            assert!(check_upload_name(name).is_err(), "{name:?}");
        }
        assert!(check_upload_name(&"ä".repeat(130)).is_err());
        for (name, kept) in
            [("../../etc/part.stl", "part.stl"), ("Größe ü.3mf", "Größe ü.3mf"), ("plan.dwg", "plan.dwg")]
        {
            assert_eq!(check_upload_name(name).unwrap(), kept);
        }
    }
}
