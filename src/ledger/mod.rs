//! The database, the only source of truth. All SQL of nestd is in this module, one file per kind of row.
//!
//! Each change of state is one function: a short `BEGIN IMMEDIATE` transaction that checks the transition against the
//! state machines of [`PartState`] and [`BuildState`], changes the rows and writes an event. No other module contains
//! SQL.

mod address;
mod backup;
mod build;
mod build_record;
mod build_row;
mod change;
mod claim;
mod command;
mod consistency;
mod copy;
mod customer_order;
mod damaged;
mod decisions;
mod deep_check;
mod due_dates;
mod edit;
mod error;
mod error_class;
mod event;
mod event_kind;
mod experience;
mod file_guard;
mod health;
mod history;
mod id;
mod in_queue_error;
mod lane;
mod last_change;
mod late_ticket;
mod ledger;
mod location;
mod lock_wait;
mod machine;
mod month;
mod move_build;
mod name_search;
mod nesting;
mod night_search;
mod node;
mod operator_word;
mod order_request;
mod outcome;
mod part;
mod part_list;
mod part_measures;
mod part_question;
mod part_row;
mod part_size;
mod pick;
mod placement;
mod postgres;
mod precedence;
mod printer;
mod publish;
mod put_back;
mod receiver;
mod refusal_cause;
mod replace;
mod request_key;
mod requeue;
mod revision;
mod schema;
mod server_error;
mod service;
mod sql;
mod sqlite_code;
mod sqlite_store;
mod state;
mod status;
mod text_column;
mod time;
mod totals;
mod unknown;
mod waiting;
mod withdrawal;

pub use address::{LedgerAddress, ServerAddress};
pub use backup::prove_backup;
pub use build_record::ImportOutcome;
pub use build_row::{
    BuildDocuments, BuildMeasures, BuildRow, BuildTimes, FinalSearch, OpenLayout, PrinterPlace, ProvedFile,
    ProvedMeasures, SearchEffort, StagedFile, Verified,
};
pub use command::{CommandArgument, CommandKind, CommandRow, CommandState, NewCommand, PauseCause};
pub use consistency::RuleScope;
pub use copy::{CopyError, CopyReport, ExistingRows};
pub use customer_order::{LineCopies, OrderLine, OrderQuery, OrderRow, OrderState, OrderSummary};
pub use decisions::ClaimDecisions;
pub use deep_check::{BuiltPartRow, PartFileRow};
pub use due_dates::DuePartRow;
pub use edit::{EditedPart, PartEdit};
pub use error::LedgerError;
pub use event::EventRow;
pub use event_kind::EventKind;
pub use experience::PublishedExperience;
pub use history::{BuildResult, HeightSummary, HistoryQuery, HistoryRow, HistorySort};
pub use id::{BuildId, CommandId, PartId};
pub use in_queue_error::InQueueError;
pub use lane::{LaneId, LaneProgress, LaneRow, LaneSearchRow, TakenLane};
pub use ledger::Ledger;
pub use location::find_network_file_system;
pub use machine::{MachineRow, ObservedMachine};
pub use month::{BadCopies, LatePart};
pub use move_build::{FoundPlace, MoveEnd};
pub use name_search::{NamePattern, NamedBuildRow, NamedPartRow};
pub use night_search::{NightSearchRow, NightState};
pub use node::{HEARTBEAT_VALID_SECS, LOCK_NAME, NodeHeartbeat, NodeRow};
pub use operator_word::{OperatorWord, TakenBackFor, WordAnswer};
pub use order_request::{NewOrderRequest, OrderedLine, RecordedRequest};
pub use outcome::{OutcomeRow, PrintOutcome, ToldOutcome};
pub use part::Namesake;
pub use part_list::PartQuery;
pub use part_measures::{PartMeasures, PartTimes};
pub use part_question::{QuestionKind, QuestionedPart};
pub use part_row::{
    ClaimedFile, DroppedFile, NewPartRow, NewTerms, NewTicketRow, OwedCopies, PartRejection, PartRow, PartTerms,
    RecordedPart, RequestedTerms, RequiredTilts, SolidFacts, SolidOfFile, TicketSource,
};
pub use part_size::is_same_size;
pub use pick::{BreakOutAnswer, PickMark, PickMarkRow};
pub use placement::{PlacementRow, PoseColumns, ProvedPlacement, RemovalColumns, RemovalStep};
pub use precedence::compare_precedence;
pub use printer::{BuildsAhead, DownPrinter, OccupyingBuild, QueuedBuild, ToldPrint};
pub use put_back::{PartCopies, PutBackReport, ReprintTarget};
pub use receiver::{ReceiverKind, ReceiverRow};
pub use refusal_cause::RefusalCause;
pub use replace::{aside_path, clear_unfinished, replace_ledger, restoring_path};
pub use request_key::AnsweredRequest;
pub use server_error::ServerError;
pub use service::{LiveRights, ServiceState, ServingNode, ServingRight, SharedFarm};
pub use state::{BuildState, IllegalMove, PartState};
pub use status::{
    DueArrival, NestingBuild, OpenBuildForecast, PauseStatus, ProfileStatus, PublishedBuild, RETRY_PERIOD,
};
pub use time::UtcTimestamp;
pub use totals::{BuildCount, FarmTotals, MeasuredBuild};
pub use waiting::{WaitingPart, rank_waiting_copies};
pub use withdrawal::{WITHDRAWN_BY_NESTD, WithdrawalEnd};

#[cfg(test)]
pub(crate) mod fixtures;
#[cfg(test)]
mod tests;
