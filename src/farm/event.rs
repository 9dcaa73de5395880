//! Everything that can happen to the farm.

use super::{
    current::Compared,
    ending::ClaimEnd,
    holds::Holds,
    jobs::JobKey,
    nest::Nested,
    prove::Written,
    read::ReadOutcome,
    receive::{Gate, Received},
    staged::Step,
};
use crate::ledger::{BuildId, PartId, PartRow};

/// What the event loop hears from its jobs and from the watcher.
#[derive(Debug)]
pub enum Event {
    /// Something changed in a hot folder.
    Look,
    /// A hot folder has been looked through.
    Received {
        /// Which.
        profile: String,
        /// The memory of the hot folder, back from the job.
        gate: Box<Gate>,
        /// What was found.
        received: Received,
    },
    /// A part's file has been read.
    Read {
        /// Which part.
        part: PartId,
        /// What came out.
        outcome: ReadOutcome,
    },
    /// The search for an open build's layout has ended.
    Improved {
        /// Whose open build.
        profile: String,
        /// Which search of that profile.
        round: u64,
        /// What came out.
        nested: anyhow::Result<Nested>,
    },
    /// A build is written and proved, or could not be.
    Written {
        /// Which build.
        build: BuildId,
        /// What came out.
        written: anyhow::Result<Box<Written>>,
    },
    /// A verified build came a step further into the queue, or could not.
    Published {
        /// Which build.
        build: BuildId,
        /// How far it came.
        step: anyhow::Result<Step>,
    },
    /// It was shown that a profile's folders are served, or somebody else serves them.
    Held {
        /// Which profile.
        profile: String,
        /// The holds, with what is wrong with each.
        holds: Box<Holds>,
    },
    /// A machine's folders were held against the ledger.
    Compared {
        /// Which profile.
        profile: String,
        /// What came of it.
        compared: Compared,
    },
    /// Stored files that were damaged are whole again, by content.
    Whole(Vec<String>),
    /// A claimed file was put where it belongs, or could not be.
    Ended {
        /// Its part.
        part: Box<PartRow>,
        /// How; what the disk said.
        ended: anyhow::Result<ClaimEnd>,
    },
    /// A waiting part's original was copied into the error folder, or could not be.
    Copied {
        /// Which part.
        part: PartId,
        /// What the disk said.
        copied: anyhow::Result<()>,
    },
    /// There was no thread for a job: nothing was done.
    NotStarted {
        /// Which.
        key: JobKey,
        /// Why.
        why: String,
    },
    /// The archives have been gone through.
    Purged,
    /// What lies beside the hot folders, for people.
    Stray(Vec<String>),
    /// A hot folder has been told.
    Told {
        /// Which.
        profile: String,
    },
    /// A job panicked.
    Panicked {
        /// Which.
        key: JobKey,
        /// What it said.
        message: String,
    },
}
