//! The answers to commands of operators. Whether a command was carried out follows from the answer; its text is for
//! people.

use std::fmt;

use build_file::format_count;

use ledger::{AwaitedMaterial, BuildId, LedgerError, PartId};

/// The answer to a command.
#[derive(Debug)]
pub(crate) enum CommandAnswer {
    /// The waiting parts of a machine are in this build now, with so many copies.
    BuildFired(BuildId, usize),
    /// Nothing waits in the machine.
    NothingWaits(String),
    /// Nothing of the machine can be in a build: what waits is of materials that are not loaded.
    AwaitsMaterial(String, Vec<AwaitedMaterial>),
    /// The machine was paused.
    Paused(String),
    /// The machine was paused before.
    PausedAlready(String),
    /// The machine was resumed.
    Resumed(String),
    /// The machine was not paused.
    NotPaused(String),
    /// The hot folders are scanned.
    ScanStarted,
    /// The part is read again.
    PartRetried(PartId),
    /// The part is read again, and its mesh is mended.
    PartMended(PartId),
    /// Refused: the part was not refused because of its mesh.
    NothingToMend(PartId),
    /// The part is cancelled.
    PartCancelled(PartId),
    /// So many copies of the part are cancelled.
    CopiesCancelled(PartId, u32),
    /// The part was changed, in these words.
    PartEdited(PartId, Vec<String>),
    /// The parts are on this machine now, and are read again.
    PartMoved(Vec<PartId>, String),
    /// The part was on this machine already.
    PartIsThere(PartId, String),
    /// The part is printed as it is.
    PartConfirmed(PartId),
    /// The part did not wait for a yes.
    NothingToConfirm(PartId),
    /// Refused: there is no such machine.
    UnknownMachine(String),
    /// Refused: a paused machine fires nothing.
    MachinePaused(String),
    /// Refused: all printers of the machine are down, this one among them.
    NoPrinterInUse(String, String),
    /// Refused: the command names no part.
    NoPartNamed,
    /// Refused: another version of nestd wrote the command, and it cannot be read.
    OtherVersion,
    /// Refused: there is no such part.
    UnknownPart(PartId),
    /// Refused: it is not known how many copies of the part are wanted.
    CopiesUnknown(PartId),
    /// The part must be read again, and its file is missing.
    FileMissing(PartId),
    /// Refused: the ledger does not allow it.
    NotAllowed(LedgerError),
}

impl CommandAnswer {
    /// Whether the command was carried out; otherwise it was refused.
    pub(crate) fn is_done(&self) -> bool {
        match self {
            Self::BuildFired(..)
            | Self::NothingWaits(_)
            | Self::AwaitsMaterial(..)
            | Self::Paused(_)
            | Self::PausedAlready(_)
            | Self::Resumed(_)
            | Self::NotPaused(_)
            | Self::ScanStarted
            | Self::PartRetried(_)
            | Self::PartMended(_)
            | Self::PartCancelled(_)
            | Self::CopiesCancelled(..)
            | Self::PartEdited(..)
            | Self::PartMoved(..)
            | Self::PartIsThere(..)
            | Self::PartConfirmed(_)
            | Self::NothingToConfirm(_) => true,
            Self::UnknownMachine(_)
            | Self::MachinePaused(_)
            | Self::NoPrinterInUse(..)
            | Self::NoPartNamed
            | Self::OtherVersion
            | Self::UnknownPart(_)
            | Self::CopiesUnknown(_)
            | Self::NothingToMend(_)
            | Self::FileMissing(_)
            | Self::NotAllowed(_) => false,
        }
    }
}

impl fmt::Display for CommandAnswer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BuildFired(build, copies) => {
                write!(f, "build {build} is being nested with {}", format_count(*copies, "copy", "copies"))
            }
            Self::NothingWaits(name) => write!(f, "nothing waits in {name}"),
            Self::AwaitsMaterial(name, awaited) => {
                let each = awaited
                    .iter()
                    .map(|of| format!("{} for {}", format_count(of.copies, "copy", "copies"), of.material));
                let all = each.collect::<Vec<_>>().join(", ");
                write!(f, "nothing is built in {name}: its loaded material is not what is waited for ({all})")
            }
            Self::Paused(name) => write!(f, "{name} is paused"),
            Self::PausedAlready(name) => write!(f, "{name} was paused already"),
            Self::Resumed(name) => write!(f, "{name} runs again"),
            Self::NotPaused(name) => write!(f, "{name} was not paused"),
            Self::ScanStarted => f.write_str("the hot folders are being looked through"),
            Self::CopiesCancelled(part, copies) => {
                write!(f, "{} of part {part} cancelled", format_count(*copies, "copy", "copies"))
            }
            Self::PartEdited(part, changes) if changes.is_empty() => write!(f, "part {part} has these values already"),
            Self::PartEdited(part, changes) => write!(f, "part {part}: {}", changes.join(", ")),
            Self::PartMoved(parts, name) => {
                let numbers: Vec<String> = parts.iter().map(ToString::to_string).collect();
                let word = if parts.len() == 1 { "part" } else { "parts" };
                write!(f, "{word} {} moved to {name}, and read again there", numbers.join(", "))
            }
            Self::PartIsThere(part, name) => write!(f, "part {part} is for {name} already"),
            Self::PartConfirmed(part) => write!(f, "part {part} is printed as it is"),
            Self::NothingToConfirm(part) => write!(f, "part {part} waits for no confirmation"),
            Self::PartRetried(part) => write!(f, "part {part} is read again"),
            Self::PartMended(part) => write!(f, "part {part} is read again, and its mesh is mended"),
            Self::NothingToMend(part) => {
                write!(
                    f,
                    "part {part} was not refused because of its mesh: `nestd retry {part}` reads it again as it is"
                )
            }
            Self::PartCancelled(part) => write!(f, "part {part} is cancelled"),
            Self::UnknownMachine(name) => write!(f, "there is no machine {name}"),
            Self::MachinePaused(name) => write!(f, "{name} is paused; resume it first"),
            Self::NoPrinterInUse(name, printer) => {
                write!(f, "no printer of {name} is in use; `nestd printer {printer} up` puts one into use again")
            }
            Self::NoPartNamed => f.write_str("no part was named"),
            Self::OtherVersion => {
                f.write_str("another version of nestd wrote this, and it cannot be read: say it again")
            }
            Self::UnknownPart(part) => write!(f, "there is no part {part}"),
            Self::CopiesUnknown(part) => {
                write!(f, "the ticket of part {part} could not be read: mend it and drop both again")
            }
            Self::FileMissing(part) => {
                write!(
                    f,
                    "part {part} waits for its file: drop that once more, and give the command again when it is read"
                )
            }
            Self::NotAllowed(error) => write!(f, "{error}"),
        }
    }
}
