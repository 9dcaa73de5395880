//! Takes a published build back out of a queue folder, so that another folder can have it. The first step is one rename
//! of the visible file, which either succeeds or finds that the printer took the file: never both.

use std::{
    fs::{self, File},
    io,
    path::{Path, PathBuf},
};

use super::{
    QueueError, QueueFolder,
    file_names::{self, MOVING},
    queue_folder::{io_error, path_exists, remove_if_exists, rename_noreplace},
};

/// Result of taking a build back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WithdrawalOutcome {
    /// The file is under a dot-name: the printer cannot take it any more.
    TakenBack,
    /// It is not in the folder: the printer took it.
    Gone,
    /// What lies there under its name is not the file that was proved. It stays where it is.
    Altered,
}

impl QueueFolder {
    /// Path of a file that was taken back: `.<name>.moving`.
    pub fn withdrawn_path(&self, name: &str) -> PathBuf {
        self.folder_path().join(format!(".{name}{MOVING}"))
    }

    /// Takes a visible build back, and then its sidecars. The result is on disk when this returns. Safe to repeat.
    pub fn withdraw(&self, build_name: &str) -> Result<WithdrawalOutcome, QueueError> {
        self.withdraw_with_hook(build_name, &mut || {})
    }

    /// `step` is called wherever a crash, or a printer, could come between two operations; tests act there.
    pub(super) fn withdraw_with_hook(
        &self,
        build_name: &str,
        step: &mut dyn FnMut(),
    ) -> Result<WithdrawalOutcome, QueueError> {
        let stem = file_names::build_stem(build_name)?;
        self.check_marker()?;
        let (visible, withdrawn) = (self.published_path(build_name), self.withdrawn_path(build_name));
        step();
        match rename_noreplace(&visible, &withdrawn) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                return Err(QueueError::NameTaken(withdrawn));
            }
            // Also where a share carried out the rename, lost the answer and tried again.
            Err(_) if !path_exists(&visible)? => {}
            Err(error) => return Err(io_error("take back", &visible)(error)),
        }
        step();
        // An unmounted folder would look as if the printer had taken the build.
        self.check_marker()?;
        self.sync_folder()?;
        if !path_exists(&withdrawn)? {
            return Ok(WithdrawalOutcome::Gone);
        }
        for suffix in file_names::SIDECARS {
            let sidecar = format!("{stem}{suffix}");
            let from = self.published_path(&sidecar);
            if path_exists(&from)? {
                step();
                fs::rename(&from, self.withdrawn_path(&sidecar)).map_err(io_error("take back", &from))?;
            }
        }
        self.sync_folder()?;
        step();
        Ok(WithdrawalOutcome::TakenBack)
    }

    /// Takes a visible build back if it is the proved one, as `is_proved` says of a path; what is not goes back under its name.
    pub fn withdraw_proved<E: From<QueueError>>(
        &self,
        build_name: &str,
        is_proved: impl Fn(&Path) -> Result<bool, E>,
    ) -> Result<WithdrawalOutcome, E> {
        let outcome = self.withdraw(build_name)?;
        let withdrawn = self.withdrawn_path(build_name);
        if outcome != WithdrawalOutcome::TakenBack || is_proved(&withdrawn)? {
            return Ok(outcome);
        }
        let stem = file_names::build_stem(build_name)?;
        let sidecars = file_names::SIDECARS.map(|suffix| format!("{stem}{suffix}"));
        for name in sidecars.iter().map(String::as_str).chain([build_name]) {
            let from = self.withdrawn_path(name);
            if path_exists(&from)? {
                rename_noreplace(&from, &self.published_path(name)).map_err(io_error("give back", &from))?;
            }
        }
        self.sync_folder()?;
        Ok(WithdrawalOutcome::Altered)
    }

    /// The names of the builds that were taken back and are still here.
    pub fn withdrawn_builds(&self) -> Result<Vec<String>, QueueError> {
        let dir = self.folder_path();
        let entries = fs::read_dir(dir).map_err(io_error("list", dir))?;
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let build = |name: String| {
            let build = name.strip_prefix('.')?.strip_suffix(MOVING)?;
            file_names::build_stem(build).is_ok().then(|| build.to_owned())
        };
        Ok(names.filter_map(build).collect())
    }

    /// Stages what was taken back out of a folder in this one, which may be the same: the sidecars first.
    pub fn stage_withdrawn(&self, from: &QueueFolder, build_name: &str) -> Result<(), QueueError> {
        let stem = file_names::build_stem(build_name)?;
        from.check_marker()?;
        let sidecars = file_names::SIDECARS.map(|suffix| format!("{stem}{suffix}"));
        for name in sidecars.iter().map(String::as_str).chain([build_name]) {
            let source = from.withdrawn_path(name);
            if path_exists(&source)? {
                self.stage(name, |file| io::copy(&mut File::open(&source)?, file).map(drop))?;
            }
        }
        Ok(())
    }

    /// Removes what was taken back; afterwards nothing tells that it ever was here.
    pub fn remove_withdrawn(&self, build_name: &str) -> Result<(), QueueError> {
        let stem = file_names::build_stem(build_name)?;
        self.check_marker()?;
        for suffix in file_names::SIDECARS {
            remove_if_exists(&self.withdrawn_path(&format!("{stem}{suffix}")))?;
        }
        remove_if_exists(&self.withdrawn_path(build_name))?;
        self.sync_folder()
    }
}
