//! The queue of a printer that is a folder. A file is staged under a dot-name, published by one rename, and taken back by one rename.

use std::{
    fs::{self, File, OpenOptions},
    io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
};

use rustix::{
    fs::{CWD, RenameFlags, renameat_with},
    io::Errno,
};

use super::{
    FileStamp, FileState, PrinterQueue, PublishOutcome, QueueAddress, QueueError, TakeBackOutcome,
    file_names::{self, HALF, MOVING, STAGED},
    marker,
    printer_queue::{IsProved, StageWriter},
};

/// A printer queue folder, identified by its marker file.
#[derive(Debug, Clone)]
pub struct QueueFolder {
    address: QueueAddress,
    dir: PathBuf,
    id: String,
}

pub(super) fn io_error<'a>(what: &'static str, path: &'a Path) -> impl FnOnce(io::Error) -> QueueError + 'a {
    move |source| QueueError::Io { what, path: path.to_owned(), source }
}

impl QueueFolder {
    /// Opens the folder; creates it and its marker `.nestd-queue` if they are missing.
    pub fn open(dir: impl Into<PathBuf>) -> Result<Self, QueueError> {
        let dir = dir.into();
        access::create_folders(&dir).map_err(io_error("create", &dir))?;
        let id = marker::read_or_create_marker(&dir).map_err(io_error("mark", &dir))?;
        Ok(Self { address: QueueAddress::Folder(dir.clone()), dir, id })
    }

    /// The folder if it is there and has its marker; nothing is created.
    pub(super) fn find(dir: impl Into<PathBuf>) -> Option<Self> {
        let dir = dir.into();
        let id = marker::read_marker_id(&dir).ok()??;
        Some(Self { address: QueueAddress::Folder(dir.clone()), dir, id })
    }

    /// Path of the folder.
    pub fn folder_path(&self) -> &Path {
        &self.dir
    }

    /// Path of a staged file: `.<name>.part`.
    pub fn staged_path(&self, name: &str) -> PathBuf {
        self.dir.join(format!(".{name}{STAGED}"))
    }

    /// Path of a published file.
    pub fn published_path(&self, name: &str) -> PathBuf {
        self.dir.join(name)
    }

    /// Path of a file that was taken back: `.<name>.moving`.
    pub fn withdrawn_path(&self, name: &str) -> PathBuf {
        self.dir.join(format!(".{name}{MOVING}"))
    }

    /// Publishes by one rename. `step` is called wherever a crash could separate two operations; tests stop there.
    pub(super) fn publish_with_hook(
        &self,
        build_name: &str,
        step: &mut dyn FnMut(),
    ) -> Result<PublishOutcome, QueueError> {
        let stem = file_names::build_stem(build_name)?;
        self.check()?;
        let (staged, published) = (self.staged_path(build_name), self.published_path(build_name));
        if !path_exists(&staged)? {
            self.sync_folder()?;
            return Ok(PublishOutcome::AlreadyPublished);
        }
        // Checked before the sidecars: those of another build with this name must not be replaced.
        if path_exists(&published)? {
            return Err(QueueError::NameTaken(published));
        }
        for suffix in file_names::SIDECARS {
            let sidecar = format!("{stem}{suffix}");
            let from = self.staged_path(&sidecar);
            if path_exists(&from)? {
                step();
                fs::rename(&from, self.published_path(&sidecar)).map_err(io_error("publish", &from))?;
            }
        }
        self.sync_folder()?;
        step();
        let renamed = rename_noreplace(&staged, &published);
        step();
        let end = match renamed {
            Ok(()) => PublishOutcome::PublishedNow,
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => return Err(QueueError::NameTaken(published)),
            // A network share may carry out the rename, lose the answer and try again: the second try says "not found".
            Err(_) if !path_exists(&staged)? => PublishOutcome::AlreadyPublished,
            Err(error) => return Err(io_error("publish", &staged)(error)),
        };
        self.sync_folder()?;
        step();
        Ok(end)
    }

    /// The names of all entries.
    fn entries(&self) -> Result<impl Iterator<Item = String>, QueueError> {
        let entries = fs::read_dir(&self.dir).map_err(io_error("list", &self.dir))?;
        Ok(entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()))
    }

    pub(super) fn sync_folder(&self) -> Result<(), QueueError> {
        File::open(&self.dir).and_then(|dir| dir.sync_all()).map_err(io_error("fsync", &self.dir))
    }
}

impl PrinterQueue for QueueFolder {
    /// The random id in its marker.
    fn id(&self) -> &str {
        &self.id
    }

    fn address(&self) -> &QueueAddress {
        &self.address
    }

    /// Without the marker, an unmounted or replaced folder would look as if the printer had taken all builds.
    fn check(&self) -> Result<(), QueueError> {
        let unavailable = |why: String| QueueError::Unavailable { dir: self.dir.clone(), why };
        match marker::read_marker_id(&self.dir) {
            Ok(Some(id)) if id == self.id => Ok(()),
            Ok(Some(_)) => Err(unavailable("its marker .nestd-queue is another one; it was replaced".to_owned())),
            Ok(None) => Err(unavailable("its marker .nestd-queue is missing; is it mounted?".to_owned())),
            Err(error) => Err(unavailable(error.to_string())),
        }
    }

    fn state(&self, build_name: &str) -> Result<FileState, QueueError> {
        file_names::build_stem(build_name)?;
        self.check()?;
        // The dot-name is checked first: only a rename away from it publishes the build.
        let places = [
            (self.staged_path(build_name), FileState::Staged),
            (self.published_path(build_name), FileState::Visible),
            (self.withdrawn_path(build_name), FileState::TakenBack),
        ];
        for (path, state) in places {
            if path_exists(&path)? {
                return Ok(state);
            }
        }
        // Once more: it may have been unmounted in between.
        self.check()?;
        Ok(FileState::Gone)
    }

    fn names(&self, state: FileState) -> Result<Vec<String>, QueueError> {
        let entries = self.entries()?;
        let staged = |name: String| file_names::staged_build_name(&name);
        let taken_back = |name: String| {
            let build = name.strip_prefix('.')?.strip_suffix(MOVING)?;
            file_names::build_stem(build).is_ok().then(|| build.to_owned())
        };
        let mut names: Vec<String> = match state {
            FileState::Staged => entries.filter_map(staged).collect(),
            FileState::Visible => entries.filter(|name| !name.starts_with('.')).collect(),
            FileState::TakenBack => entries.filter_map(taken_back).collect(),
            FileState::Gone => Vec::new(),
        };
        names.sort();
        names.dedup();
        Ok(names)
    }

    fn file(&self, name: &str, state: FileState) -> Result<PathBuf, QueueError> {
        Ok(match state {
            FileState::Staged => self.staged_path(name),
            FileState::TakenBack => self.withdrawn_path(name),
            FileState::Visible | FileState::Gone => self.published_path(name),
        })
    }

    fn stamp(&self, name: &str) -> Option<FileStamp> {
        let seen = fs::symlink_metadata(self.published_path(name)).ok()?;
        let version = [seen.mtime(), seen.mtime_nsec(), seen.ctime(), seen.ctime_nsec(), seen.ino().cast_signed()];
        Some(FileStamp { bytes: seen.len(), is_file: seen.is_file(), version })
    }

    fn stage(&self, name: &str, write: StageWriter<'_>) -> Result<PathBuf, QueueError> {
        file_names::queue_file_stem(name).ok_or_else(|| QueueError::InvalidName(name.to_owned()))?;
        self.check()?;
        if path_exists(&self.published_path(name))? {
            return Err(QueueError::NameTaken(self.published_path(name)));
        }
        let half = self.dir.join(format!(".{name}{HALF}"));
        remove_if_exists(&half)?;
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(true)
            .open(&half)
            .map_err(io_error("create", &half))?;
        access::apply_file_permissions(&file).map_err(io_error("give mode and group to", &half))?;
        if let Err(source) = write(&mut file) {
            remove_if_exists(&half)?;
            return Err(QueueError::Write { path: half, source });
        }
        file.sync_all().map_err(io_error("fsync", &half))?;
        let staged = self.staged_path(name);
        fs::rename(&half, &staged).map_err(io_error("stage", &staged))?;
        self.sync_folder()?;
        Ok(staged)
    }

    fn publish(&self, build_name: &str) -> Result<PublishOutcome, QueueError> {
        self.publish_with_hook(build_name, &mut || {})
    }

    fn discard(&self, build_name: &str) -> Result<bool, QueueError> {
        let stem = file_names::build_stem(build_name)?;
        let was_staged = self.state(build_name)? == FileState::Staged;
        // What an earlier attempt staged while builds were delivered as another kind goes, too.
        for other in file_names::builds_of_stem(stem).filter(|other| other != build_name) {
            remove_if_exists(&self.staged_path(&other))?;
        }
        for suffix in file_names::SIDECARS {
            let sidecar = format!("{stem}{suffix}");
            remove_if_exists(&self.staged_path(&sidecar))?;
            let visible = self.published_path(&sidecar);
            if path_exists(&visible)? && !path_exists(&self.published_path(build_name))? {
                remove_if_exists(&visible)?;
            }
        }
        // The build is removed last: after a crash before this line it can be discarded again.
        remove_if_exists(&self.staged_path(build_name))?;
        self.sync_folder()?;
        Ok(was_staged)
    }

    fn sweep(&self, keep: &[String]) -> Result<Vec<String>, QueueError> {
        self.check()?;
        let mut swept = Vec::new();
        for entry in fs::read_dir(&self.dir).map_err(io_error("list", &self.dir))? {
            let entry = entry.map_err(io_error("list", &self.dir))?;
            let Ok(name) = entry.file_name().into_string() else { continue };
            let Some(stem) = file_names::staged_file_stem(&name) else { continue };
            if !keep.iter().any(|kept| file_names::build_stem(kept).is_ok_and(|kept| kept == stem)) {
                remove_if_exists(&entry.path())?;
                swept.push(name);
            }
        }
        swept.sort();
        Ok(swept)
    }

    fn take_back(&self, build_name: &str, is_proved: IsProved<'_>) -> Result<TakeBackOutcome, QueueError> {
        self.take_back_with_hook(build_name, is_proved, &mut || {})
    }

    fn remove_taken_back(&self, build_name: &str) -> Result<(), QueueError> {
        file_names::build_stem(build_name)?;
        self.check()?;
        // The build is removed last: until then, it is known that it was taken back.
        for name in file_names::files_of_build(build_name)? {
            remove_if_exists(&self.withdrawn_path(&name))?;
        }
        self.sync_folder()
    }
}

pub(super) fn path_exists(path: &Path) -> Result<bool, QueueError> {
    match fs::symlink_metadata(path) {
        Ok(_) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(io_error("stat", path)(error)),
    }
}

pub(super) fn remove_if_exists(path: &Path) -> Result<(), QueueError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(io_error("remove", path)(error)),
        _ => Ok(()),
    }
}

/// A rename that overwrites nothing. Where the file system does not support that (NFS, old kernels), the target is
/// checked first and then renamed. Link and unlink are not used: if the printer takes the file and nestd crashes
/// between them, the build would be published twice.
pub(super) fn rename_noreplace(from: &Path, to: &Path) -> io::Result<()> {
    match renameat_with(CWD, from, CWD, to, RenameFlags::NOREPLACE) {
        Err(Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP) => match fs::symlink_metadata(to) {
            Ok(_) => Err(io::ErrorKind::AlreadyExists.into()),
            Err(_) => fs::rename(from, to),
        },
        other => Ok(other?),
    }
}
