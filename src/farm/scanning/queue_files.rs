//! The build files that lie visible in the queue folders of a machine, and whether they should. The entries of the folders are the list,
//! and the ledger is asked by name, so that a look costs no more with a long history.

use anyhow::Result;
use ledger::{BuildRow, BuildState};

use super::{
    machine_fit::find_misfit,
    queue_contents::{self, ContentReader},
};
use crate::{
    queue::{FileState, OpenQueue, PrinterQueue},
    settings::MachineProfile,
};

/// Maximum number of files of which one look reads the content.
const MAX_READ_PER_LOOK: usize = 8;

/// What a look found.
#[derive(Debug, Default)]
pub(crate) struct QueueFileFindings {
    /// What must not be printed as it is, a clause each.
    pub(crate) wrong: Vec<String>,
    /// Builds that were taken and lie in a queue again, each with its printer and the marker of the folder.
    pub(crate) back: Vec<(BuildRow, String, String)>,
}

/// A look at the visible files of a machine.
pub(crate) struct QueueFileLook<'a> {
    /// The machine.
    pub(crate) profile: &'a MachineProfile,
    /// Its open queues, by the names of its printers.
    pub(crate) queues: &'a [(String, OpenQueue)],
    /// Finds the build of a machine that has a file of this name.
    pub(crate) find_build: &'a dyn Fn(&str) -> Result<Option<BuildRow>>,
    /// Whether copies of a build were told bad.
    pub(crate) has_bad_copies: &'a dyn Fn(&BuildRow) -> Result<bool>,
}

impl QueueFileLook<'_> {
    /// Looks at every visible file.
    pub(crate) fn look(&self) -> Result<QueueFileFindings> {
        let (mut found, mut reader) = (QueueFileFindings::default(), ContentReader::new(MAX_READ_PER_LOOK));
        for (printer, queue) in self.queues {
            // A folder that is away keeps nobody from looking into the others.
            let Ok(names) = queue.names(FileState::Visible) else { continue };
            for name in &names {
                self.look_at((printer, &**queue), name, &mut reader, &mut found)?;
            }
            queue_contents::forget_others(&**queue, &names);
        }
        found.wrong.sort();
        Ok(found)
    }

    fn look_at(
        &self,
        (printer, queue): (&String, &dyn PrinterQueue),
        name: &str,
        reader: &mut ContentReader,
        found: &mut QueueFileFindings,
    ) -> Result<()> {
        let row = if name.ends_with(".build.3mf") { (self.find_build)(name)? } else { None };
        // After the row was read: what lies there now was not taken back before that.
        let Some(stamp) = queue.stamp(name) else { return Ok(()) };
        let wrong = match row {
            Some(build) if build.place.is_on_its_way() => None,
            Some(build) if build.machine != self.profile.name => Some(match build.state {
                BuildState::Published => {
                    format!("is build {} of {}: take it to a queue of {1}", build.id, build.machine)
                }
                _ => format!(
                    "is the file of build {} of {} ({}): take it out, or its copies are printed a second time",
                    build.id,
                    build.machine,
                    build.state_word()
                ),
            }),
            Some(build) if build.state == BuildState::Published => {
                let is_proved = queue_contents::is_proved(&build, (queue, name, stamp), reader);
                let wrong = self.find_fault_of_published(&build, queue, is_proved);
                if wrong.is_none() && build.place.taken_at.is_some() {
                    found.back.push((build, printer.clone(), queue.id().to_owned()));
                }
                wrong
            }
            Some(build) => self.find_fault_of_told(&build)?,
            None => match reader.own_name(queue, name, stamp) {
                Some(own) => (self.find_build)(&own)?.map(|build| self.describe_copy(&build, &own)),
                None => None,
            },
        };
        found.wrong.extend(wrong.map(|wrong| format!("{name} at {printer} {wrong}")));
        Ok(())
    }

    fn find_fault_of_published(&self, build: &BuildRow, queue: &dyn PrinterQueue, is_proved: bool) -> Option<String> {
        let id = build.id;
        if !is_proved {
            return Some(format!(
                "is not the file that was proved as build {id}: take it out, look whether it was printed, and tell the outcome of build {id}"
            ));
        }
        let is_own = |queue: &dyn PrinterQueue| Some(queue.id()) == build.staged.queue_id.as_deref();
        let name = build.staged.file_name.as_deref().unwrap_or_default();
        let own = self.queues.iter().find(|(_, other)| is_own(&**other) && !is_own(queue));
        if let Some((printer, _)) = own.filter(|(_, own)| own.stamp(name).is_some()) {
            return Some(format!("is a second file of build {id}, which lies at {printer}: take it out"));
        }
        let why = find_misfit(self.profile, build)?;
        Some(format!(
            "does not fit, for {why}. `nestd withdraw {id}` takes it out, and its copies are nested for the machine as it is now"
        ))
    }

    /// What is wrong with the file of a build that is not to be printed any more. Where people leave files in the queue when they have
    /// printed them, one that never left it is no fault.
    fn find_fault_of_told(&self, build: &BuildRow) -> Result<Option<String>> {
        let (id, state) = (build.id, build.state_word());
        Ok(match build.state {
            BuildState::Failed => Some(format!(
                "is the file of build {id}, which is {state}: take it out, or its copies are printed a second time"
            )),
            BuildState::Printing | BuildState::Complete | BuildState::Interrupted
                if build.place.taken_at.is_some() || (self.has_bad_copies)(build)? =>
            {
                Some(format!("is the file of build {id} ({state}), which was out of the queue before: take it out"))
            }
            _ => None,
        })
    }

    /// What is wrong with a file that holds the copies of a build under another name.
    fn describe_copy(&self, build: &BuildRow, own: &str) -> String {
        let is_wanted = build.state == BuildState::Published && build.machine == self.profile.name;
        let is_alone = self.queues.iter().all(|(_, queue)| queue.stamp(own).is_none());
        let or_rename = if is_wanted && is_alone { ", or give it that name back" } else { "" };
        let (id, state) = (build.id, build.state_word());
        format!("holds the copies of build {id} ({state}), whose file is {own}: take it out{or_rename}")
    }
}
