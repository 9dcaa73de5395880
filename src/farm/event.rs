//! Everything that can happen to the farm.

use super::{
    holds::Holds,
    jobs::JobKey,
    nest::Nested,
    prove::Written,
    read::ReadOutcome,
    receive::{Gate, Received},
};
use crate::ledger::{BuildId, PartId};

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
    /// A verified build was published, or could not be.
    Published {
        /// Which build.
        build: BuildId,
        /// What the queue folder said.
        published: anyhow::Result<crate::queue::Published>,
    },
    /// It was shown that a profile's folders are served, or somebody else serves them.
    Held {
        /// Which profile.
        profile: String,
        /// The holds, with what is wrong with each.
        holds: Box<Holds>,
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
