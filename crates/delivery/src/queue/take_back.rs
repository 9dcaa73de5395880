//! Takes a published build back out of a queue folder. The first step is one rename of the visible file, which either succeeds or finds
//! that the printer took the file: never both.

use std::{fs, io};

use super::{
    PrinterQueue, QueueError, TakeBackOutcome, file_names,
    printer_queue::IsProved,
    queue_folder::{QueueFolder, io_error, path_exists, rename_noreplace},
};

impl QueueFolder {
    /// `step` is called wherever a crash, or a printer, could come between two operations; tests act there.
    pub(super) fn take_back_with_hook(
        &self,
        build_name: &str,
        is_proved: IsProved<'_>,
        step: &mut dyn FnMut(),
    ) -> Result<TakeBackOutcome, QueueError> {
        let stem = file_names::build_stem(build_name)?;
        self.check()?;
        let (visible, withdrawn) = (self.published_path(build_name), self.withdrawn_path(build_name));
        step();
        match rename_noreplace(&visible, &withdrawn) {
            Ok(()) => {}
            // It was taken back before. What lies under its name now is a second file, and stays there.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            // Also where a share carried out the rename, lost the answer and tried again.
            Err(_) if !path_exists(&visible)? => {}
            Err(error) => return Err(io_error("take back", &visible)(error)),
        }
        step();
        // An unmounted folder would look as if the printer had taken the build.
        self.check()?;
        self.sync_folder()?;
        if !path_exists(&withdrawn)? {
            return Ok(TakeBackOutcome::Gone);
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
        match is_proved(&withdrawn).map_err(io_error("read", &withdrawn))? {
            true => Ok(TakeBackOutcome::TakenBack),
            false => self.give_back(build_name),
        }
    }

    /// What was taken back and is not the proved file is visible again as it was.
    fn give_back(&self, build_name: &str) -> Result<TakeBackOutcome, QueueError> {
        for name in file_names::files_of_build(build_name)? {
            let from = self.withdrawn_path(&name);
            if path_exists(&from)? {
                rename_noreplace(&from, &self.published_path(&name)).map_err(io_error("give back", &from))?;
            }
        }
        self.sync_folder()?;
        Ok(TakeBackOutcome::Altered)
    }
}
