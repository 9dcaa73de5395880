//! Errors of the ledger.

use std::path::PathBuf;

use thiserror::Error;

use super::{lock_wait::BUSY_TIMEOUT, sqlite_code::query_failure};
use crate::{BuildId, CommandId, IllegalMove, InQueueError, PartId, ServerError};

/// Why an operation of the ledger failed. A failed change leaves nothing behind.
#[derive(Debug, Error)]
pub enum LedgerError {
    /// A build that was to be released does not fit its machine any more.
    #[error("build {build} is not released: it is made again, for {why}")]
    MadeAgain {
        /// The build.
        build: BuildId,
        /// Why it does not fit.
        why: String,
    },
    /// There is no ledger.
    #[error("there is no ledger at {}; a daemon that starts for the first time makes it", .path.display())]
    Missing {
        /// Where it should be.
        path: PathBuf,
    },
    /// The ledger is on a network file system, where SQLite's locks do not work.
    #[error("the ledger {} is on a network file system ({kind}): move the state directory to a local disk", .path.display())]
    NetworkFileSystem {
        /// The ledger.
        path: PathBuf,
        /// Which file system.
        kind: &'static str,
    },
    /// The folder of the ledger cannot be created or inspected.
    #[error("cannot use the folder of the ledger {}", .path.display())]
    Folder {
        /// The ledger.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// SQLite cannot open it.
    #[error("cannot open the ledger {}: {error}", .path.display())]
    Open {
        /// The ledger.
        path: PathBuf,
        /// The error of SQLite. It is not a `source`, because its text already contains its own source.
        error: sqlx::Error,
    },
    /// A newer nestd wrote it.
    #[error("the ledger {} has schema {found}, this nestd knows up to {known}: use the newer nestd", .path.display())]
    NewerSchema {
        /// The ledger.
        path: PathBuf,
        /// Its schema.
        found: i64,
        /// The newest schema of this binary.
        known: i64,
    },
    /// An older nestd wrote it, and the daemon has not migrated it yet.
    #[error("the ledger {} has schema {found}, this nestd needs {known}: start the daemon, it brings the ledger up to date", .path.display())]
    OlderSchema {
        /// The ledger.
        path: PathBuf,
        /// Its schema.
        found: i64,
        /// The newest schema of this binary.
        known: i64,
    },
    /// The schema migration failed.
    #[error("cannot bring the ledger {} up to date: {error}", .path.display())]
    Migrate {
        /// The ledger.
        path: PathBuf,
        /// The error of the migration. Its text already contains its own source.
        error: sqlx::migrate::MigrateError,
    },
    /// The ledger is damaged.
    #[error(
        "the ledger {} is damaged: {what}. nestd does not use it: keep its files, and restore a backup with \
         `nestd restore FILE`",
        .path.display()
    )]
    Damaged {
        /// The ledger.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The open file is not the file at that path any more.
    #[error(
        "the ledger {} was removed or replaced while it was open: {what}. nestd stopped using it: put the original \
         back, or start this again to use the new one",
        .path.display()
    )]
    Replaced {
        /// The ledger.
        path: PathBuf,
        /// Which file changed, and how.
        what: String,
    },
    /// The content of the open file is not the one that this process has changed.
    #[error(
        "the ledger {} was overwritten while it was open: {what}. nestd does not use it any more: stop nestd, put the newest backup back \
         with `nestd restore FILE`, and start nestd",
        .path.display()
    )]
    Overwritten {
        /// The ledger.
        path: PathBuf,
        /// What is missing in it.
        what: String,
    },
    /// Another process holds the write lock.
    #[error(
        "the ledger cannot be changed now: {by} has been changing it for {} s and longer. Wait until that has ended, or end \
         it, and try again",
        BUSY_TIMEOUT.as_secs()
    )]
    Locked {
        /// Which process, in words.
        by: String,
    },
    /// SQLite found an invalid page or value.
    #[error(
        "the ledger is damaged: {0}. nestd does not use it any more: stop nestd, keep the ledger's files, and restore \
         a backup with `nestd restore FILE`"
    )]
    Corrupt(String),
    /// The backup could not be written.
    #[error("cannot write the backup {}: {what}", .path.display())]
    Backup {
        /// The backup.
        path: PathBuf,
        /// What went wrong.
        what: String,
    },
    /// The text is not a valid record of a build.
    #[error("it is not a valid record of a build: {0}")]
    InvalidRecord(String),
    /// A query failed: the disk, the database or a fault in nestd.
    #[error("a query of the ledger failed: {}", query_failure(.0))]
    Sql(sqlx::Error),
    /// A ledger on a server.
    #[error(transparent)]
    Server(#[from] ServerError),
    /// This user may only read the ledger.
    #[error("you may read the ledger but not write to it: run this as the user of the daemon, or as root")]
    ReadOnly,
    /// There is no such part.
    #[error("there is no part {0}")]
    UnknownPart(PartId),
    /// There is a person of this name.
    #[error("there is a person named {0} already: take another name, or change what {0} has")]
    PersonKnown(String),
    /// There is no such person.
    #[error("there is no person named {0}; `nestd people list` says who there is")]
    UnknownPerson(String),
    /// There is no such build.
    #[error("there is no build {0}")]
    UnknownBuild(BuildId),
    /// There is no such command, or it was answered already.
    #[error("there is no open command {0}")]
    UnknownCommand(CommandId),
    /// The state machine does not allow the transition.
    #[error(transparent)]
    IllegalMove(#[from] IllegalMove),
    /// The file of the build may lie in a queue.
    #[error(transparent)]
    InQueue(#[from] InQueueError),
    /// The build is not in a state that the change requires.
    #[error("build {build} is {state}, not {}", .needed.iter().map(|s| s.to_string()).collect::<Vec<_>>().join(" or "))]
    WrongState {
        /// The build.
        build: BuildId,
        /// Its state, as people call it.
        state: String,
        /// The states that the change requires.
        needed: &'static [crate::BuildState],
    },
    /// The build was made again since a person looked at it.
    #[error("build {0} was made again since you looked at it: look at what it is now")]
    ProvedAnew(BuildId),
    /// The part is not waiting, so none of its copies can be nested.
    #[error("part {part} is {state}, not waiting")]
    NotWaiting {
        /// The part.
        part: PartId,
        /// Its state.
        state: crate::PartState,
    },
    /// The copy is already in a build.
    #[error("copy {copy} of part {part} is in build {build} already")]
    CopyTaken {
        /// The part.
        part: PartId,
        /// Its copy, from 0.
        copy: u32,
        /// The build that holds it.
        build: BuildId,
    },
    /// The part has no copy with this number.
    #[error("part {part} has no copy {copy}")]
    NoSuchCopy {
        /// The part.
        part: PartId,
        /// The copy, from 0.
        copy: u32,
    },
    /// The copy is not in that build.
    #[error("copy {copy} of part {part} is not in build {build}")]
    NotInBuild {
        /// The part.
        part: PartId,
        /// Its copy, from 0.
        copy: u32,
        /// The build.
        build: BuildId,
    },
    /// The part is for another machine.
    #[error("part {part} is for {machine}, build {build} is not")]
    WrongMachine {
        /// The part.
        part: PartId,
        /// Its machine.
        machine: String,
        /// The build.
        build: BuildId,
    },
    /// The file of a published build cannot be taken back.
    #[error("the file of build {0} is not in the queue: its printer took it, or it is on its way to another printer")]
    NotInQueue(BuildId),
    /// The build would have no copies.
    #[error("build {0} has no copy to nest")]
    NothingToNest(BuildId),
    /// The placed copies are not the copies of the build.
    #[error("build {build} holds {taken} copies, {placed} are placed: they must be the same")]
    PlacementsDiffer {
        /// The build.
        build: BuildId,
        /// Copies taken into it.
        taken: usize,
        /// Copies with a pose.
        placed: usize,
    },
    /// Some copies are being nested now.
    #[error(
        "part {part} has copies in build {build}, which is {state} and is printed as it is: wait until it is published, and give \
         the command again for the copies that still wait. Printed copies are made anew with `nestd reprint {part}=N`"
    )]
    BeingBuilt {
        /// The part.
        part: PartId,
        /// The build.
        build: BuildId,
        /// The state of the build.
        state: crate::BuildState,
    },
    /// The part is already refused or cancelled.
    #[error("part {0} is refused or cancelled already; `nestd show p{0}` says why")]
    AlreadyRefused(PartId),
    /// All copies of the part are already in published builds.
    #[error("part {0} is built already: all its copies are in published builds")]
    AlreadyBuilt(PartId),
    /// Only a refused or cancelled part can be retried.
    #[error("part {part} is {state}; only a part that is refused or cancelled can be retried")]
    NotRefused {
        /// The part.
        part: PartId,
        /// Its state.
        state: crate::PartState,
    },
    /// An outcome was told already: another one, or the same.
    #[error("{}", .state.told_already(*.asked, *.build))]
    AlreadyTold {
        /// The build.
        build: BuildId,
        /// Its state.
        state: crate::BuildState,
        /// The outcome that was given now.
        asked: crate::BuildState,
    },
    /// Nobody printed the build: its file was taken back untouched.
    #[error(
        "the file of build {0} was taken back out of the queue untouched: it does not count as printed, and its copies are made again. If \
         somebody printed copies of its file all the same, take as many of those that wait out with `nestd cancel PART=N`; \
         `nestd show b{0}` tells when, and lists its parts"
    )]
    TakenBack(BuildId),
    /// Of a failed print, bad copies were named.
    #[error(
        "all copies of a failed print are bad: name none of them, or say `complete` or `interrupted` and name the bad ones"
    )]
    AllFailed,
    /// Fewer copies of the part are in the build than were named as bad.
    #[error("build {build} holds {} of part {part}, and {asked} were named; `nestd show b{build}` lists them", copies_text(*.placed))]
    TooFewInBuild {
        /// The part.
        part: PartId,
        /// The build.
        build: BuildId,
        /// Copies named.
        asked: u32,
        /// Its copies in the build that count.
        placed: u32,
    },
    /// Fewer copies of the part were printed than are to be printed again.
    #[error("{} of part {part} printed, and {asked} are to be printed again; `nestd show p{part}` lists them", copies_text(*.printed))]
    TooFewPrinted {
        /// The part.
        part: PartId,
        /// Copies to print again.
        asked: u32,
        /// Printed copies that count.
        printed: u32,
    },
    /// No printed copy is meant.
    #[error("no copy of it counts as printed: `nestd show` says what waits, `nestd edit PART --copies N` orders more")]
    NothingPrinted,
    /// Copies that are to be nested are about to be cancelled.
    #[error("copies of part {0} are being cancelled, and its build begins after that")]
    AskedBack(PartId),
    /// Fewer copies of the part wait than are to be taken back.
    #[error("{} of part {part} can be cancelled, not {asked}; the others are in builds: `nestd show p{part}` lists them", copies_text(*.waiting))]
    TooFewWaiting {
        /// The part.
        part: PartId,
        /// Copies to cancel.
        asked: u32,
        /// Waiting copies.
        waiting: u32,
    },
    /// Fewer copies are wanted than stand in builds.
    #[error("{} of part {part} in builds already, so the whole number cannot be {asked}; `nestd show p{part}` lists them", copies_text(*.placed))]
    TooManyPlaced {
        /// The part.
        part: PartId,
        /// Copies that are to be wanted.
        asked: u32,
        /// Copies in builds.
        placed: u32,
    },
    /// What is asked is beyond what may be asked of a part.
    #[error("{0}")]
    UnusableTerm(String),
    /// What is asked with a part cannot change any more.
    #[error("part {part} is {state}, and only what waits can be changed; {}", edit_remedy(*.part, *.state))]
    NotEditable {
        /// The part.
        part: PartId,
        /// Its state.
        state: crate::PartState,
    },
    /// Fewer copies of the part are wanted than the build holds.
    #[error("build {build} holds more of part {part} than is wanted; `nestd edit {part} --copies N` orders more")]
    FewerWanted {
        /// The part.
        part: PartId,
        /// The build.
        build: BuildId,
    },
    /// A copy of the build is in another build by now.
    #[error("copy {copy} of part {part} is in build {build} by now, so the same build cannot be issued again")]
    PrintedElsewhere {
        /// The part.
        part: PartId,
        /// Its copy, from 1.
        copy: u32,
        /// The other build.
        build: BuildId,
    },
    /// An order cannot be closed.
    #[error(transparent)]
    NotClosed(#[from] crate::base::close_order_error::CloseOrderError),
    /// A material cannot be loaded, or a part cannot be made of it.
    #[error(transparent)]
    Material(#[from] crate::MaterialError),
    /// A part was accepted without any solid.
    #[error("part {0} was read without a solid")]
    NoSolid(PartId),
}

fn copies_text(copies: u32) -> String {
    build_file::format_count(copies, "copy", "copies")
}

fn edit_remedy(part: PartId, state: crate::PartState) -> String {
    if state == crate::PartState::Refused {
        return format!("`nestd retry {part}` takes it back first");
    }
    format!("`nestd edit {part} --copies N` orders more of it")
}

/// Result of an operation of the ledger.
pub type Result<T, E = LedgerError> = std::result::Result<T, E>;
