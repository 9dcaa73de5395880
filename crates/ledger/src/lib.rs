//! The database, the only source of truth. All SQL of nestd is in this crate, one file per kind of row.
//!
//! Each change of state is one function: a short `BEGIN IMMEDIATE` transaction that checks the transition against the
//! state machines of [`PartState`] and [`BuildState`], changes the rows and writes an event. No other crate contains
//! SQL, save tests and benches; the schema is in `migrations/` and `migrations/postgres/`.

pub use base::close_order_error::CloseOrderError;
pub use base::error::LedgerError;
pub use base::event_kind::EventKind;
pub use base::id::{BuildId, CommandId, PartId};
pub use base::in_queue_error::InQueueError;
pub use base::material_error::MaterialError;
pub use base::name_pattern::NamePattern;
pub use base::refusal_cause::RefusalCause;
pub use base::server_error::ServerError;
pub use base::state::{BuildState, IllegalMove, PartState};
pub use base::time::UtcTimestamp;
pub use builds::night_search::{NightSearchRow, NightState};
pub use builds::placement::{PlacementRow, PoseColumns, ProvedPlacement, RemovalColumns, RemovalStep};
pub use builds::take_back::{FoundPlace, TakeBackEnd};
pub use keep::backup::prove_backup;
pub use keep::build_record::ImportOutcome;
pub use keep::copy::{CopyError, CopyReport, ExistingRows};
pub use keep::decisions::ClaimDecisions;
pub use keep::deep_check::{BuiltPartRow, PartFileRow};
pub use keep::replace::{aside_path, clear_unfinished, replace_ledger, restoring_path};
pub use orders::customer_order::{OrderClosing, OrderQuery, OrderRow, OrderState, OrderSummary};
pub use orders::name_search::{NamedBuildRow, NamedPartRow};
pub use orders::order_line::{LineCopies, OrderLine};
pub use orders::order_request::{NewOrderRequest, OrderedLine, RecordedRequest};
pub use orders::request_key::AnsweredRequest;
pub use parts::due_dates::DuePartRow;
pub use parts::edit::EditedPart;
pub use parts::material::{LoadedMaterial, material_key};
pub use parts::part::Namesake;
pub use parts::part_edit::PartEdit;
pub use parts::part_list::PartQuery;
pub use parts::part_question::{QuestionKind, QuestionedPart};
pub use parts::part_size::is_same_size;
pub use parts::waiting::{WaitingPart, rank_waiting_copies};
pub use rows::build_row::{
    BuildDocuments, BuildMeasures, BuildRow, BuildTimes, FinalSearch, OpenLayout, PrinterPlace, ProvedFile,
    ProvedMeasures, SearchEffort, StagedFile, Verified,
};
pub use rows::part_measures::{MEND_BY_SETTING, MEND_BY_TICKET, PartMeasures, PartMending, PartTimes};
pub use rows::part_row::{
    ClaimedFile, DroppedFile, NewPartRow, NewTerms, NewTicketRow, OwedCopies, PartRefusal, PartRow, PartTerms,
    RequiredTilts, SolidOfFile, TicketSource, is_missing_file, missing_file_claim,
};
pub use rows::precedence::compare_precedence;
pub use rows::recorded_part::{RecordedAs, RecordedPart};
pub use rows::solid_facts::{MendedFacts, RequestedTerms, SolidFacts};
pub use service::cost_basis::{CostQuery, CostedBuild, OrderedCopies};
pub use service::event::EventRow;
pub use service::experience::PublishedExperience;
pub use service::history::{BuildResult, HeightSummary, HistoryQuery, HistoryRow, HistorySort};
pub use service::machine::{MachineRow, ObservedMachine};
pub use service::month::{BadCopies, LatePart, UntoldPrint};
pub use service::node::{HEARTBEAT_VALID_SECS, LOCK_NAME, NodeHeartbeat, NodeRow};
pub use service::person::{PersonChange, PersonRow, PersonSecrets};
pub use service::printer::{BuildsAhead, DownPrinter, OccupyingBuild, QueuedBuild, ToldPrint};
pub use service::receiver::{ReceiverKind, ReceiverRow};
pub use service::session::{MAX_WRONG_PINS, SESSION_HOURS, SessionRow};
pub use service::status::{
    AwaitedMaterial, DueArrival, MachineStatus, NestingBuild, OpenBuildForecast, PauseStatus, PublishedBuild,
    RETRY_PERIOD,
};
pub use service::totals::{BuildCount, FarmTotals, MeasuredBuild};
pub use store::address::{DAEMON_CONNECTIONS, LedgerAddress, ServerAddress};
pub use store::consistency::RuleScope;
pub use store::ledger::Ledger;
pub use store::location::find_network_file_system;
pub use store::on_demand::LedgerOnDemand;
pub use store::service::{LedgerUser, LiveRights, ServiceState, ServingNode, ServingRight, SharedFarm};
pub use words::command::{CommandArgument, CommandKind, CommandRow, CommandState, NewCommand, PauseCause};
pub use words::finishing::{FinishingStep, PartFinishing};
pub use words::operator_word::TakenBackFor;
pub use words::outcome::{OutcomeRow, PrintOutcome, ToldOutcome};
pub use words::pick::{BreakOutAnswer, PickMark, PickMarkRow};
pub use words::put_back::{PartCopies, PutBackReport, ReprintTarget};
pub use words::said::{OperatorWord, SeenFile, SeenFiles, WordAnswer};
pub use words::withdrawal::WITHDRAWN_BY_NESTD;

#[cfg(test)]
extern crate self as ledger; // for the fixtures, which know it by that name

mod base;
mod builds;
mod keep;
mod orders;
mod parts;
mod rows;
mod service;
mod store;
#[cfg(test)]
mod tests;
mod words;

#[cfg(test)]
#[path = "../../ledger-fixtures/src/ledgers.rs"]
mod fixtures;
#[cfg(test)]
#[allow(dead_code, reason = "tests of other crates need more of it")]
#[path = "../../ledger-fixtures/src/postgres_cluster.rs"]
mod postgres_cluster;
#[cfg(test)]
#[allow(dead_code, reason = "tests of other crates need more of it")]
#[path = "../../ledger-fixtures/src/server_link.rs"]
mod server_link;
