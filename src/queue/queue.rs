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
    QueueError, marker,
    names::{self, HALF, STAGED},
};
use crate::access;

/// A printer queue folder of ours, known by its marker file.
#[derive(Debug, Clone)]
pub struct Queue {
    dir: PathBuf,
    id: String,
}

/// Where a build file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StagedState {
    /// Under its dot-name: not yet published.
    Staged,
    /// Under its own name: published, not yet taken by the printer.
    Published,
    /// Neither: published and taken, if it had been staged whole.
    Gone,
}

/// What publishing found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Published {
    /// The file appeared now.
    Now,
    /// The dot-file was gone: it had been published before.
    Before,
}

fn io_error<'a>(what: &'static str, path: &'a Path) -> impl FnOnce(io::Error) -> QueueError + 'a {
    move |source| QueueError::Io { what, path: path.to_owned(), source }
}

impl Queue {
    /// Opens the folder, creating it and its marker `.nestd-queue` if they are not there.
    pub fn open(dir: impl Into<PathBuf>) -> Result<Self, QueueError> {
        let dir = dir.into();
        access::create_folders(&dir).map_err(io_error("create", &dir))?;
        let id = marker::read_or_make(&dir).map_err(io_error("mark", &dir))?;
        Ok(Self { dir, id })
    }

    /// The random id in its marker: goes into the build's row, so that a replaced folder is noticed.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Where it is.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Where a file stands while it is staged: `.<name>.part`.
    pub fn staged_path(&self, name: &str) -> PathBuf {
        self.dir.join(format!(".{name}{STAGED}"))
    }

    /// Where a file stands once it is published.
    pub fn published_path(&self, name: &str) -> PathBuf {
        self.dir.join(name)
    }

    /// Writes a file under its dot-name and fsyncs it and the folder; the dot-file is there whole or not at all. Sidecars
    /// of a build (same stem, another suffix) are staged likewise, and published with it. Replaces what was staged under
    /// that name; never touches what is published. Returns the path of the dot-file.
    pub fn stage<E>(&self, name: &str, write: impl FnOnce(&mut File) -> Result<(), E>) -> Result<PathBuf, QueueError>
    where
        E: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        names::stem(name).ok_or_else(|| QueueError::BadName(name.to_owned()))?;
        self.check()?;
        if is_there(&self.published_path(name))? {
            return Err(QueueError::NameTaken(self.published_path(name)));
        }
        let half = self.dir.join(format!(".{name}{HALF}"));
        remove(&half)?;
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(true)
            .open(&half)
            .map_err(io_error("create", &half))?;
        access::of_file(&file).map_err(io_error("give mode and group to", &half))?;
        if let Err(error) = write(&mut file) {
            remove(&half)?;
            return Err(QueueError::Write { path: half, source: error.into() });
        }
        file.sync_all().map_err(io_error("fsync", &half))?;
        let staged = self.staged_path(name);
        fs::rename(&half, &staged).map_err(io_error("stage", &staged))?;
        self.fsync()?;
        Ok(staged)
    }

    /// Publishes a staged build by one rename that overwrites nothing, after its sidecars; on disk when it returns.
    /// Safe to repeat.
    pub fn publish(&self, build_name: &str) -> Result<Published, QueueError> {
        self.publish_stepwise(build_name, &mut || {})
    }

    /// `step` is called between any two steps that a crash could part; tests stop there.
    pub(super) fn publish_stepwise(&self, build_name: &str, step: &mut dyn FnMut()) -> Result<Published, QueueError> {
        let stem = names::build_stem(build_name)?;
        self.check()?;
        let (staged, published) = (self.staged_path(build_name), self.published_path(build_name));
        if !is_there(&staged)? {
            self.fsync()?;
            return Ok(Published::Before);
        }
        // Looked at before the sidecars: those of another build of this name must not be replaced.
        if is_there(&published)? {
            return Err(QueueError::NameTaken(published));
        }
        for suffix in names::SIDECARS {
            let sidecar = format!("{stem}{suffix}");
            let from = self.staged_path(&sidecar);
            if is_there(&from)? {
                step();
                fs::rename(&from, self.published_path(&sidecar)).map_err(io_error("publish", &from))?;
            }
        }
        self.fsync()?;
        step();
        let renamed = rename_noreplace(&staged, &published);
        step();
        let end = match renamed {
            Ok(()) => Published::Now,
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => return Err(QueueError::NameTaken(published)),
            // A network share whose answer was lost says "not found" to the second try of a rename that was done.
            Err(_) if !is_there(&staged)? => Published::Before,
            Err(error) => return Err(io_error("publish", &staged)(error)),
        };
        self.fsync()?;
        step();
        Ok(end)
    }

    /// Where a build file is, for recovery.
    pub fn state(&self, build_name: &str) -> Result<StagedState, QueueError> {
        names::build_stem(build_name)?;
        self.check()?;
        // The dot-name first: only a rename away from it publishes.
        Ok(match (is_there(&self.staged_path(build_name))?, is_there(&self.published_path(build_name))?) {
            (true, _) => StagedState::Staged,
            (false, true) => StagedState::Published,
            (false, false) => StagedState::Gone,
        })
    }

    /// Removes a staged build and its sidecars, published ones too if the build itself is not visible. A visible build is
    /// left alone. Only for a build that was not published: the printer may have taken the build and left the sidecars.
    /// Returns whether there was a staged build.
    pub fn discard(&self, build_name: &str) -> Result<bool, QueueError> {
        let stem = names::build_stem(build_name)?;
        let was_staged = self.state(build_name)? == StagedState::Staged;
        for suffix in names::SIDECARS {
            let sidecar = format!("{stem}{suffix}");
            remove(&self.staged_path(&sidecar))?;
            let visible = self.published_path(&sidecar);
            if is_there(&visible)? && !is_there(&self.published_path(build_name))? {
                remove(&visible)?;
            }
        }
        // The build last, so that a crash before leaves it to be discarded again.
        remove(&self.staged_path(build_name))?;
        self.fsync()?;
        Ok(was_staged)
    }

    /// The names of the builds of which dot-files lie here, whoever staged them.
    pub fn staged_builds(&self) -> Result<Vec<String>, QueueError> {
        let entries = fs::read_dir(&self.dir).map_err(io_error("list", &self.dir))?;
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let mut builds: Vec<String> =
            names.filter_map(|name| Some(format!("{}{}", names::stem_of_dot_name(&name)?, names::BUILD))).collect();
        builds.sort();
        builds.dedup();
        Ok(builds)
    }

    /// Removes dot-files of our pattern whose build (`*.build.3mf`) is not in `keep`. Returns their names.
    pub fn sweep(&self, keep: &[String]) -> Result<Vec<String>, QueueError> {
        self.check()?;
        let mut swept = Vec::new();
        for entry in fs::read_dir(&self.dir).map_err(io_error("list", &self.dir))? {
            let entry = entry.map_err(io_error("list", &self.dir))?;
            let Ok(name) = entry.file_name().into_string() else { continue };
            let Some(stem) = names::stem_of_dot_name(&name) else { continue };
            if !keep.iter().any(|k| k.strip_suffix(names::BUILD) == Some(stem)) {
                remove(&entry.path())?;
                swept.push(name);
            }
        }
        swept.sort();
        Ok(swept)
    }

    /// Whether it is still the folder that was opened. An unmounted or replaced folder looks like one from which the printer
    /// took everything: its marker tells.
    pub fn check(&self) -> Result<(), QueueError> {
        let unavailable = |why: String| QueueError::Unavailable { dir: self.dir.clone(), why };
        match marker::read(&self.dir) {
            Ok(Some(id)) if id == self.id => Ok(()),
            Ok(Some(_)) => Err(unavailable("its marker .nestd-queue is another one; it was replaced".to_owned())),
            Ok(None) => Err(unavailable("its marker .nestd-queue is missing; is it mounted?".to_owned())),
            Err(error) => Err(unavailable(error.to_string())),
        }
    }

    fn fsync(&self) -> Result<(), QueueError> {
        File::open(&self.dir).and_then(|dir| dir.sync_all()).map_err(io_error("fsync", &self.dir))
    }
}

fn is_there(path: &Path) -> Result<bool, QueueError> {
    match fs::symlink_metadata(path) {
        Ok(_) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(io_error("stat", path)(error)),
    }
}

fn remove(path: &Path) -> Result<(), QueueError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(io_error("remove", path)(error)),
        _ => Ok(()),
    }
}

/// One rename that overwrites nothing. Where the file system cannot promise that (NFS, old kernels), it is looked first and
/// then renamed. Not link and unlink: a crash between them, and a printer that takes the file, would publish it twice.
fn rename_noreplace(from: &Path, to: &Path) -> io::Result<()> {
    match renameat_with(CWD, from, CWD, to, RenameFlags::NOREPLACE) {
        Err(Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP) => match fs::symlink_metadata(to) {
            Ok(_) => Err(io::ErrorKind::AlreadyExists.into()),
            Err(_) => fs::rename(from, to),
        },
        other => Ok(other?),
    }
}
