//! The database, the only source of truth. All SQL of nestd is in this room, one file per noun.
//!
//! Each change of state is one function here: a short `BEGIN IMMEDIATE` transaction that checks the move against the
//! state machines of [`PartState`] and [`BuildState`], changes the rows and writes an event. Nothing else knows SQL.

mod backup;
mod build;
mod build_row;
mod change;
mod claim;
mod command;
mod daemon;
mod damaged;
mod decisions;
mod deep;
mod due;
mod error;
mod event;
mod health;
mod history;
mod id;
mod in_place;
mod known;
mod ledger;
mod nesting;
mod outcome;
mod part;
mod part_list;
mod part_row;
mod place;
mod placement;
mod publish;
mod receiver;
mod record;
mod refusal;
mod replace;
mod schema;
mod state;
mod station;
mod status;
mod time;
mod totals;
mod truth;
mod waiting;
mod word;

pub use backup::prove as prove_backup;
pub use build_row::{
    BuildDocuments, BuildMeasures, BuildRow, BuildTimes, FinalSearch, OpenLayout, ProvedFile, ProvedMeasures,
    SearchEffort, StagedFile, Verified,
};
pub use command::{CommandKind, CommandRow, CommandState, NewCommand};
pub use daemon::{BEAT_LASTS_SECS, Beat, DaemonRow, LOCK_NAME};
pub use decisions::Decided;
pub use deep::{BuiltPlace, PartPlace};
pub use due::DuePart;
pub use error::LedgerError;
pub use event::EventRow;
pub use history::{BuildResult, HeightSum, HistoryQuery, HistoryRow, HistorySort};
pub use id::{BuildId, CommandId, PartId};
pub use ledger::Ledger;
pub use outcome::{Outcome, OutcomeRow};
pub use part_list::PartQuery;
pub use part_row::{
    ClaimedFile, NewPart, NewTerms, NewTicket, PartMeasures, PartRow, PartTerms, PartTimes, Recorded, SolidFacts,
    SolidOfFile, TicketSource, Tilts,
};
pub use placement::{DrawnOut, PlacedCopy, PlacementRow, PoseColumns, WayColumns};
pub use receiver::{DROPPED, Receiver, ReceiverRow};
pub use record::TakenIn;
pub use refusal::Refusal;
pub use replace::{clear_unfinished, replace, restoring};
pub use state::{BuildState, IllegalMove, PartState};
pub use station::{StationRow, StationSeen};
pub use status::{NestingBuild, OpenBuild, Paused, ProfileStatus, PublishedBuild, REFUSED_COUNTS};
pub use time::Utc;
pub use totals::{BuildCount, Measured, Totals};
pub use waiting::WaitingPart;

#[cfg(test)]
pub(crate) mod fixtures;
#[cfg(test)]
mod tests;
