//! What can go wrong with the ledger.

use std::path::PathBuf;

use thiserror::Error;

use super::{BuildId, CommandId, IllegalMove, PartId};

/// Why the ledger did not do what was asked. Nothing of a failed change is kept.
#[derive(Debug, Error)]
pub enum LedgerError {
    /// There is no ledger yet.
    #[error("there is no ledger at {}: the daemon makes it when it first runs", .path.display())]
    Missing {
        /// Where it should be.
        path: PathBuf,
    },
    /// SQLite's locks do not hold there.
    #[error("the ledger {} is on a network file system ({kind}): move the state directory to a local disk", .path.display())]
    NetworkFileSystem {
        /// The ledger.
        path: PathBuf,
        /// Which file system.
        kind: &'static str,
    },
    /// The folder of the ledger cannot be made or looked at.
    #[error("cannot use the folder of the ledger {}", .path.display())]
    Folder {
        /// The ledger.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// SQLite cannot open it.
    #[error("cannot open the ledger {}: {error}", .path.display())]
    Open {
        /// The ledger.
        path: PathBuf,
        /// What SQLite said; not a source, because it tells its own source too.
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
    /// An older nestd wrote it and the daemon has not brought it up to date yet.
    #[error("the ledger {} has schema {found}, this nestd needs {known}: start the daemon, it brings the ledger up to date", .path.display())]
    OlderSchema {
        /// The ledger.
        path: PathBuf,
        /// Its schema.
        found: i64,
        /// The newest schema of this binary.
        known: i64,
    },
    /// The schema cannot be brought up to date.
    #[error("cannot bring the ledger {} up to date: {error}", .path.display())]
    Migrate {
        /// The ledger.
        path: PathBuf,
        /// What the migration said; it tells its own source too.
        error: sqlx::migrate::MigrateError,
    },
    /// It is not whole any more.
    #[error(
        "the ledger {} is damaged: {what}. Nothing is done with it: keep its files, and put back a backup with `nestd restore FILE`",
        .path.display()
    )]
    Damaged {
        /// The ledger.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The file that is open is not the one that stands there.
    #[error(
        "the ledger {} was removed or replaced while it was open: {what}. Nothing more is done with it: put it back, or start \
         this again to use the one that is there now",
        .path.display()
    )]
    Replaced {
        /// The ledger.
        path: PathBuf,
        /// Which file, and how.
        what: String,
    },
    /// SQLite came upon a page or a value that cannot be right.
    #[error(
        "the ledger is damaged: {0}. Nothing more is done with it: stop nestd, keep the ledger's files, and put back a backup \
         with `nestd restore FILE`"
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
    /// The record of a build is none.
    #[error("it is no record of a build: {0}")]
    Record(String),
    /// A query failed: the disk, the database or a fault in nestd.
    #[error("a query of the ledger failed: {0}")]
    Sql(sqlx::Error),
    /// This user may read the ledger only.
    #[error("you may read the ledger but not write it: ask as the user that the daemon runs as, or as root")]
    ReadOnly,
    /// There is no such part.
    #[error("there is no part {0}")]
    UnknownPart(PartId),
    /// There is no such build.
    #[error("there is no build {0}")]
    UnknownBuild(BuildId),
    /// There is no such order by hand, or it is answered already.
    #[error("there is no open command {0}")]
    UnknownCommand(CommandId),
    /// The state machine forbids it.
    #[error(transparent)]
    Illegal(#[from] IllegalMove),
    /// The build is not in the state that the change is for.
    #[error("build {build} is {state}, not {}", .needed.iter().map(|s| s.to_string()).collect::<Vec<_>>().join(" or "))]
    WrongState {
        /// The build.
        build: BuildId,
        /// Its state.
        state: super::BuildState,
        /// What the change needs.
        needed: &'static [super::BuildState],
    },
    /// The part is not waiting, so that no copy of it can be nested.
    #[error("part {part} is {state}, not waiting")]
    NotWaiting {
        /// The part.
        part: PartId,
        /// Its state.
        state: super::PartState,
    },
    /// The copy is in a build already.
    #[error("copy {copy} of part {part} is in build {build} already")]
    CopyTaken {
        /// The part.
        part: PartId,
        /// Its copy, from 0.
        copy: u32,
        /// Where it is.
        build: BuildId,
    },
    /// The part has fewer copies.
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
    #[error("part {part} is for {profile}, build {build} is not")]
    WrongProfile {
        /// The part.
        part: PartId,
        /// Its profile.
        profile: String,
        /// The build.
        build: BuildId,
    },
    /// A build without a copy makes no sense.
    #[error("build {0} has no copy to nest")]
    NothingToNest(BuildId),
    /// What was verified is not what was taken into the build.
    #[error("build {build} holds {taken} copies, {placed} are placed: they must be the same")]
    PlacementsDiffer {
        /// The build.
        build: BuildId,
        /// Copies taken into it.
        taken: usize,
        /// Copies with a pose.
        placed: usize,
    },
    /// Some copies are being nested at this moment.
    #[error("part {part} has copies in build {build}, which is {state}: wait until it is published")]
    BeingBuilt {
        /// The part.
        part: PartId,
        /// The build.
        build: BuildId,
        /// The state of the build.
        state: super::BuildState,
    },
    /// Nothing is left to cancel.
    #[error("part {0} is refused or cancelled already; `nestd show p{0}` says why")]
    IsOut(PartId),
    /// Nothing is left to cancel.
    #[error("part {0} is built already: all its copies are in published builds")]
    IsBuilt(PartId),
    /// Only what is out of the farm can be taken back.
    #[error("part {part} is {state}; only a part that is refused or cancelled can be taken back")]
    NotRejected {
        /// The part.
        part: PartId,
        /// Its state.
        state: super::PartState,
    },
    /// A 3MF without a solid was accepted.
    #[error("part {0} was read without a solid")]
    NoSolid(PartId),
}

impl LedgerError {
    /// Whether the disk failed or is full, not the change: trying again will help once that is mended.
    pub fn is_of_the_disk(&self) -> bool {
        match self {
            Self::ReadOnly | Self::Folder { .. } => true,
            Self::Open { error, .. } | Self::Sql(error) => {
                matches!(error, sqlx::Error::Io(_)) || matches!(sqlite_code(error), Some(SQLITE_IOERR | SQLITE_FULL))
            }
            _ => false,
        }
    }
}

impl From<sqlx::Error> for LedgerError {
    fn from(error: sqlx::Error) -> Self {
        use sqlx::Error::{ColumnDecode, Decode};
        match (sqlite_code(&error), &error) {
            (Some(SQLITE_READONLY), _) => Self::ReadOnly,
            (Some(SQLITE_CORRUPT | SQLITE_NOTADB), _) | (_, ColumnDecode { .. } | Decode(_)) => {
                Self::Corrupt(error.to_string())
            }
            _ => Self::Sql(error),
        }
    }
}

impl LedgerError {
    /// Whether the ledger's bytes are wrong, so that trying again does not help.
    pub fn is_damage(&self) -> bool {
        matches!(self, Self::Damaged { .. } | Self::Corrupt(_))
    }
}

/// Another connection holds the lock.
pub(super) const SQLITE_BUSY: i64 = 5;
/// The disk failed.
const SQLITE_IOERR: i64 = 10;
/// The disk is full.
const SQLITE_FULL: i64 = 13;
/// The file or the connection cannot be written.
const SQLITE_READONLY: i64 = 8;
/// A page does not hold what it should.
const SQLITE_CORRUPT: i64 = 11;
/// The file is no database at all.
const SQLITE_NOTADB: i64 = 26;

/// SQLite's primary result code of an error, whatever its extended form.
pub(super) fn sqlite_code(error: &sqlx::Error) -> Option<i64> {
    let code = error.as_database_error()?.code()?.parse::<i64>().ok()?;
    Some(code & 0xff)
}

/// Result of whatever the ledger does.
pub type Result<T, E = LedgerError> = std::result::Result<T, E>;
