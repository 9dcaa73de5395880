//! One printer queue folder.

use std::{
    fs::{self, File, OpenOptions},
    io,
    path::{Path, PathBuf},
};

use rustix::{
    fs::{CWD, RenameFlags, renameat_with},
    io::Errno,
};

use super::{
    QueueError,
    file_names::{self, HALF, STAGED},
    marker,
};

/// A printer queue folder, identified by its marker file.
#[derive(Debug, Clone)]
pub struct QueueFolder {
    dir: PathBuf,
    id: String,
}

/// Where a build file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StagedState {
    /// Under its dot-name: not published yet.
    Staged,
    /// Under its own name: published, and not yet taken by the printer.
    Published,
    /// Under neither name: published and taken, if it was staged completely.
    Gone,
}

/// Result of publishing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PublishOutcome {
    /// The file was published by this call.
    PublishedNow,
    /// The dot-file was gone: the build was published before.
    AlreadyPublished,
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
        Ok(Self { dir, id })
    }

    /// The folder if it is there and has its marker; nothing is created.
    pub fn find(dir: impl Into<PathBuf>) -> Option<Self> {
        let dir = dir.into();
        let id = marker::read_marker_id(&dir).ok()??;
        Some(Self { dir, id })
    }

    /// The random id in its marker. It is stored in the build's row, so that a replaced folder is detected.
    pub fn marker_id(&self) -> &str {
        &self.id
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

    /// Writes a file under its dot-name and fsyncs file and folder; afterwards the dot-file is complete or does not
    /// exist. Sidecars of a build (same stem, other suffix) are staged in the same way and published with the build.
    /// Replaces a staged file of that name, and never changes a published one. Returns the path of the dot-file.
    pub fn stage<E>(&self, name: &str, write: impl FnOnce(&mut File) -> Result<(), E>) -> Result<PathBuf, QueueError>
    where
        E: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        file_names::queue_file_stem(name).ok_or_else(|| QueueError::InvalidName(name.to_owned()))?;
        self.check_marker()?;
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
        if let Err(error) = write(&mut file) {
            remove_if_exists(&half)?;
            return Err(QueueError::Write { path: half, source: error.into() });
        }
        file.sync_all().map_err(io_error("fsync", &half))?;
        let staged = self.staged_path(name);
        fs::rename(&half, &staged).map_err(io_error("stage", &staged))?;
        self.sync_folder()?;
        Ok(staged)
    }

    /// Publishes a staged build and its sidecars, the build last, by one rename that overwrites nothing. The result is
    /// on disk when this returns. Safe to repeat.
    pub fn publish(&self, build_name: &str) -> Result<PublishOutcome, QueueError> {
        self.publish_with_hook(build_name, &mut || {})
    }

    /// `step` is called wherever a crash could separate two operations; tests stop there.
    pub(super) fn publish_with_hook(
        &self,
        build_name: &str,
        step: &mut dyn FnMut(),
    ) -> Result<PublishOutcome, QueueError> {
        let stem = file_names::build_stem(build_name)?;
        self.check_marker()?;
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

    /// Where a build file is, for recovery.
    pub fn staged_state(&self, build_name: &str) -> Result<StagedState, QueueError> {
        file_names::build_stem(build_name)?;
        self.check_marker()?;
        // The dot-name is checked first: only a rename away from it publishes the build.
        Ok(match (path_exists(&self.staged_path(build_name))?, path_exists(&self.published_path(build_name))?) {
            (true, _) => StagedState::Staged,
            (false, true) => StagedState::Published,
            (false, false) => StagedState::Gone,
        })
    }

    /// Removes a staged build and its sidecars, and published sidecars if the build itself is not visible. A visible
    /// build stays. Call it only for a build that was not published: the printer may have taken a published build and
    /// left its sidecars. Returns whether a staged build existed.
    pub fn discard(&self, build_name: &str) -> Result<bool, QueueError> {
        let stem = file_names::build_stem(build_name)?;
        let was_staged = self.staged_state(build_name)? == StagedState::Staged;
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

    /// The names of all entries.
    fn names(&self) -> Result<impl Iterator<Item = String>, QueueError> {
        let entries = fs::read_dir(&self.dir).map_err(io_error("list", &self.dir))?;
        Ok(entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()))
    }

    /// The names of all builds that are visible here, including those of other farms.
    pub fn published_build_names(&self) -> Result<Vec<String>, QueueError> {
        Ok(self.names()?.filter(|name| file_names::build_stem(name).is_ok()).collect())
    }

    /// The names of all visible entries, whoever gave them.
    pub fn visible_names(&self) -> Result<Vec<String>, QueueError> {
        Ok(self.names()?.filter(|name| !name.starts_with('.')).collect())
    }

    /// The names of all builds that have dot-files here, including those of other farms.
    pub fn staged_build_names(&self) -> Result<Vec<String>, QueueError> {
        let mut builds: Vec<String> = (self.names()?)
            .filter_map(|name| Some(format!("{}{}", file_names::staged_file_stem(&name)?, file_names::BUILD)))
            .collect();
        builds.sort();
        builds.dedup();
        Ok(builds)
    }

    /// Removes nestd's dot-files whose build (`*.build.3mf`) is not in `keep`. Returns their names.
    pub fn remove_unknown_staged(&self, keep: &[String]) -> Result<Vec<String>, QueueError> {
        self.check_marker()?;
        let mut swept = Vec::new();
        for entry in fs::read_dir(&self.dir).map_err(io_error("list", &self.dir))? {
            let entry = entry.map_err(io_error("list", &self.dir))?;
            let Ok(name) = entry.file_name().into_string() else { continue };
            let Some(stem) = file_names::staged_file_stem(&name) else { continue };
            if !keep.iter().any(|k| k.strip_suffix(file_names::BUILD) == Some(stem)) {
                remove_if_exists(&entry.path())?;
                swept.push(name);
            }
        }
        swept.sort();
        Ok(swept)
    }

    /// Checks that this is still the folder that was opened. Without the marker, an unmounted or replaced folder would
    /// look as if the printer had taken all builds.
    pub fn check_marker(&self) -> Result<(), QueueError> {
        let unavailable = |why: String| QueueError::Unavailable { dir: self.dir.clone(), why };
        match marker::read_marker_id(&self.dir) {
            Ok(Some(id)) if id == self.id => Ok(()),
            Ok(Some(_)) => Err(unavailable("its marker .nestd-queue is another one; it was replaced".to_owned())),
            Ok(None) => Err(unavailable("its marker .nestd-queue is missing; is it mounted?".to_owned())),
            Err(error) => Err(unavailable(error.to_string())),
        }
    }

    pub(super) fn sync_folder(&self) -> Result<(), QueueError> {
        File::open(&self.dir).and_then(|dir| dir.sync_all()).map_err(io_error("fsync", &self.dir))
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
