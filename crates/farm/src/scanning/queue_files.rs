//! The build files that lie visible in the queue folders of a machine, and whether they should. The entries of the folders are the list,
//! and the ledger is asked by name, so that a look costs no more with a long history.

use std::collections::BTreeSet;

use anyhow::Result;
use delivery::queue::{FileState, OpenQueue, PrinterQueue};
use ledger::{BuildId, BuildRow, BuildState};
use settings::MachineProfile;

use super::{
    machine_fit::find_misfit,
    queue_contents::{self, BuildFiles, ContentReader, SoughtFile, VisibleFile, is_at, told_place},
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
    /// Second files of published builds that were not seen before: where.
    pub(crate) second: Vec<(BuildId, String)>,
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
    /// Where second files of a build were seen.
    pub(crate) second_files: &'a dyn Fn(&BuildRow) -> Result<Vec<String>>,
    /// The published builds of which second files were seen.
    pub(crate) copied: &'a [BuildRow],
}

/// A visible file that is looked at.
struct LookedAt<'a> {
    printer: &'a str,
    queue: &'a dyn PrinterQueue,
    name: &'a str,
}

impl LookedAt<'_> {
    fn place(&self) -> String {
        told_place(self.name, self.printer)
    }
}

impl QueueFileLook<'_> {
    /// Looks at every visible file.
    pub(crate) fn look(&self) -> Result<QueueFileFindings> {
        let (mut found, mut reader) = (QueueFileFindings::default(), ContentReader::new(MAX_READ_PER_LOOK));
        let (mut places, mut away) = (BTreeSet::new(), Vec::new());
        for (printer, queue) in self.queues {
            // A folder that is away keeps nobody from looking into the others.
            let Ok(names) = queue.names(FileState::Visible) else {
                away.push(printer);
                continue;
            };
            for name in &names {
                let file = LookedAt { printer, queue: &**queue, name };
                let wrong = self.find_fault(&file, &mut reader, &mut found)?;
                places.insert(file.place());
                found.wrong.extend(wrong.map(|wrong| format!("{} {wrong}", file.place())));
            }
            queue_contents::forget_others(&**queue, &names);
        }
        for build in self.copied {
            let second = (self.second_files)(build)?;
            let is_gone = |place: &&String| !places.contains(*place) && !away.iter().any(|away| is_at(place, away));
            let gone: Vec<&str> = second.iter().filter(is_gone).map(String::as_str).collect();
            if !gone.is_empty() {
                found.wrong.extend(self.describe_gone(build, &second, &gone.join(" and ")));
            }
        }
        found.wrong.sort();
        Ok(found)
    }

    /// What is wrong with a file, if something is.
    fn find_fault(
        &self,
        file: &LookedAt<'_>,
        reader: &mut ContentReader,
        found: &mut QueueFileFindings,
    ) -> Result<Option<String>> {
        let LookedAt { queue, name, .. } = *file;
        let row = if build_file::build_file_stem(name).is_some() { (self.find_build)(name)? } else { None };
        // After the row was read: what lies there now was not taken back before that.
        let Some(stamp) = queue.stamp(name) else { return Ok(None) };
        Ok(match row {
            Some(build) if build.machine != self.profile.name => Some(match build.state {
                BuildState::Published => {
                    format!("is build {} of {}: take it to a queue of {1}", build.id, build.machine)
                }
                _ => format!(
                    "is the file of build {} of {} ({}): take it out, or its copies are printed a second time{}",
                    build.id,
                    build.machine,
                    build.state_word(),
                    where_printed(&build)
                ),
            }),
            Some(build) if build.state == BuildState::Published => {
                let is_proved = queue_contents::is_proved(&build, (queue, name, stamp), reader);
                self.find_fault_of_published(file, build, is_proved, found)?
            }
            Some(build) if build.place.is_on_its_way() => None,
            Some(build) => self.find_fault_of_told(&build)?,
            None => match reader.own_name(queue, name, stamp) {
                Some(own) => match (self.find_build)(&own)? {
                    Some(build) => Some(self.describe_copy(file, &build, found)?),
                    None => None,
                },
                None => None,
            },
        })
    }

    fn find_fault_of_published(
        &self,
        file: &LookedAt<'_>,
        build: BuildRow,
        is_proved: bool,
        found: &mut QueueFileFindings,
    ) -> Result<Option<String>> {
        let (id, queue) = (build.id, file.queue);
        let second = (self.second_files)(&build)?;
        let Some(files) = self.find_files(&build, &second) else { return Ok(None) };
        if queue.stamp(file.name).is_none() {
            return Ok(None);
        }
        let is_own = files.own.as_ref().is_some_and(|own| own.printer == file.printer);
        let is_where_published = Some(queue.id()) == build.staged.queue_id.as_deref();
        let may_lie_there = match (build.place.is_on_its_way(), &build.place.move_queue_id) {
            (false, _) => is_own,
            (true, Some(moved)) => moved == queue.id() && queue.state(file.name)? == FileState::Visible,
            (true, None) => is_where_published && !queue.holds_taken_back(file.name),
        };
        if !may_lie_there {
            return Ok(Some(Self::note_second(file, &build, (&files, &second), found)));
        }
        if build.place.is_on_its_way() {
            return Ok(None);
        }
        if !is_proved {
            return Ok(Some(format!(
                "is not the file that was proved as build {id}: take it out, look whether it was printed, and tell the outcome of build {id}"
            )));
        }
        if let Some(why) = find_misfit(self.profile, &build) {
            return Ok(Some(format!(
                "does not fit, for {why}. `nestd withdraw {id}` takes it out, and its copies are nested for the machine as it is now"
            )));
        }
        if build.place.taken_at.is_some() {
            found.back.push((build, file.printer.to_owned(), queue.id().to_owned()));
        }
        Ok(None)
    }

    fn find_files(&self, build: &BuildRow, second: &[String]) -> Option<BuildFiles> {
        Some(BuildFiles::find_named(self.queues, &SoughtFile::of(build, second)?))
    }

    /// Says of a second file of a published build that it is one. It is noted as long as the other one was not taken.
    fn note_second(
        file: &LookedAt<'_>,
        build: &BuildRow,
        (files, second): (&BuildFiles, &[String]),
        found: &mut QueueFileFindings,
    ) -> String {
        let (id, place) = (build.id, file.place());
        // Of what a person moved while a word waits for it, there is no other.
        let is_elsewhere = files.own.as_ref().is_some_and(|own| own.to_string() != place);
        let is_other_there = is_elsewhere || files.taken_back.is_some() || build.place.move_to.is_some();
        if is_other_there && !second.contains(&place) {
            found.second.push((id, place));
        }
        match &files.own {
            _ if build.place.is_on_its_way() => {
                format!("is a second file of build {id}, which is on its way out of a queue: take it out")
            }
            Some(VisibleFile { printer, .. }) => {
                format!("is a second file of build {id}, which lies at {printer}: take it out")
            }
            None => format!(
                "is a second file of build {id}, which was taken out of the queue of {}: where that one is printed, take this one out; \
                 where it was only moved away, `nestd dismiss b{id}`",
                build.place.printer.as_deref().unwrap_or(&build.machine)
            ),
        }
    }

    /// What is wrong with the file of a build that is not to be printed any more. Where people leave files in the queue when they have
    /// printed them, one that never left it is no fault.
    fn find_fault_of_told(&self, build: &BuildRow) -> Result<Option<String>> {
        let (id, state) = (build.id, build.state_word());
        Ok(match build.state {
            BuildState::Failed => Some(format!(
                "is the file of build {id}, which is {state}: take it out, or its copies are printed a second time{}",
                where_printed(build)
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
    fn describe_copy(&self, file: &LookedAt<'_>, build: &BuildRow, found: &mut QueueFileFindings) -> Result<String> {
        let (id, state) = (build.id, build.state_word());
        let own = build.staged.file_name.as_deref().unwrap_or_default();
        let is_wanted = build.state == BuildState::Published && build.machine == self.profile.name;
        let mut or_rename = "";
        if is_wanted {
            let second = (self.second_files)(build)?;
            match self.find_files(build, &second).unwrap_or_default() {
                BuildFiles { own: None, taken_back: None, others } => {
                    if others.is_empty() && second.is_empty() {
                        or_rename = ", or give it that name back";
                    }
                }
                files => drop(Self::note_second(file, build, (&files, &second), found)),
            }
        }
        Ok(format!(
            "holds the copies of build {id} ({state}), whose file is {own}: take it out{or_rename}{}",
            where_printed(build)
        ))
    }

    /// What is to be done where second files of a build are gone: nobody but a person can say whether they were printed.
    fn describe_gone(&self, build: &BuildRow, second: &[String], gone: &str) -> Option<String> {
        let (id, files) = (build.id, self.find_files(build, second)?);
        let what = format!("a second file of build {id} lay in the queue as {gone}, and is gone");
        let then = match &files.own {
            Some(own) => format!("take {own} out and tell `nestd outcome {id} printing`"),
            None if build.place.taken_at.is_some() => {
                return Some(format!(
                    "{what}, and so is its own: it may be printed twice; stop one of the prints, and tell the outcome of build {id}"
                ));
            }
            None => format!("tell `nestd outcome {id} printing`"),
        };
        Some(format!("{what}: where that one is printed, {then}; where a person took it out, `nestd dismiss b{id}`"))
    }
}

/// What is to be said where the copies of a build that wait again were printed all the same.
fn where_printed(build: &BuildRow) -> String {
    let id = build.id;
    match (build.state, build.place.withdrawn_at) {
        (BuildState::Failed, Some(_)) => format!(
            "; where it was printed all the same, take as many of those that wait out with `nestd cancel PART=N` (`nestd show b{id}` lists \
             its parts)"
        ),
        (BuildState::Failed, None) => {
            format!("; where it was printed all the same, `nestd outcome {id} complete --correct` says so")
        }
        _ => String::new(),
    }
}
