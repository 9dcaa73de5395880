//! The service: one file per step of a part's life, and one event loop.
//!
//! `core` holds what the steps share, and says what each may touch. A step is a file of functions that take what they need: the ledger,
//! the settings, the machines, the alerts or the jobs; or a desk with the parts of the farm that this kind of step owns. What a step
//! decides is a function without a farm (`decisions`), and what it does off the loop is a `BackgroundJob` of its folder. `scanning` claims
//! dropped files, `receive` reads them, `open_build` keeps the waiting parts nested, fires and searches, `nesting` writes and proves,
//! `publish` publishes, `operate` carries out what people say. Only `run/event_loop` knows all steps.
//!
//! A folder knows only earlier ones, in the order of ARCHITECTURE.md.

mod again;
mod alerts;
mod core;
mod decisions;
#[cfg(test)]
mod driven_tests;
mod facts;
mod files;
mod leases;
mod nesting;
mod nodes;
mod open_build;
mod operate;
mod planning;
mod printers;
mod process;
mod publish;
mod receive;
mod records;
mod recover;
mod run;
mod scanning;
mod search;

pub use crate::core::farm::halt_summary;
pub use crate::core::state::Load;

pub use again::part_questions::PartQuestion;
pub use alerts::alert::{AlertKind, FarmAlert};
pub use alerts::alert_summary::AlertSummary;
pub use alerts::service_bridge::{ServiceBridge, ServicePhase};
pub use alerts::stored_alerts::{alerts_of_farm, read_stored_alerts};
pub use decisions::fire_forecast::FireForecast;
pub use decisions::night_text::{night_gain_text, night_text};
pub use decisions::print_times::PrintTimes;
pub use decisions::queue_depth::held_text;
pub use decisions::trigger::FireTrigger;
pub use facts::build_fact::{BuildFact, DatedBuild, build_fact, build_of_copy, build_of_search};
pub use facts::copy_fact::{CopyWord, copy_counts, copy_fact, counted_words};
pub use facts::cost_fact::{CostReport, CostShare, MM3_PER_LITRE, OrderCost, cake_litres};
pub use facts::customer_note::customer_note;
pub use facts::late_fact::read_late_parts;
pub use facts::machine_fact::{MachineFact, MachineWord, asked_text, machine_fact};
pub use facts::material_fact::{MaterialReading, with_lot};
pub use facts::order_fact::{DatedOrder, OrderFact, OrderWord, delay_text};
pub use facts::part_fact::{part_fact, read_part_facts, said_state};
pub use facts::part_record::{RecordedBuild, RecordedCopy, read_part_record};
pub use facts::printer_fact::{PrinterFact, PrinterWord};
pub use facts::read_facts::{FarmReading, dates_at_risk, read_plans};
pub use files::disk_cache::DiskPreparationCache;
pub use files::isolated_read::{SUBCOMMAND as READ_PART, answer_read_request};
pub use files::judged_file::{JudgedFile, JudgedFiles, judge_file};
pub use files::refused_files::dismiss_refused;
pub use leases::folder_check::{check_readable, watch_other_holders};
pub use leases::folder_lease::LeaseError;
pub use leases::known_folders::is_known_folder;
pub use leases::own_machines::{machines_of_other_nodes, with_other_nodes};
pub use nesting::node_client::{NODE_HEADER, NodeClient, node_secret, was_not_sent};
pub use nesting::node_content::{fetch_put_content, find_kept_content};
pub use nesting::part_mesh::load_part_mesh;
pub use nodes::adopt::adopt_claims;
pub use operate::operate::{operate, see_own_file};
pub use planning::{
    DateRisk, DatesKept, DueAnswer, FarmRows, MachinePlan, OrderQuote, PlanStage, PlannedBuild, PlannedPart,
    QUOTE_SEARCH_TIME, QuoteError, QuoteMeshes, QuoteQuestion, QuotedFile, RiskCause, awaits_release, quote_order,
    read_plan, read_quoted_files,
};
pub use printers::printers::fate_of_queued;
pub use printers::release_preview::{LatePreview, ReleasePreview, preview_release};
pub use records::cake::{
    CakeContents, CakeCopy, CakePart, count_copies_in_layout, find_proved_file, load_placed_parts, locate_build_file,
    resolve_volume_mm,
};
pub use records::invariants::{
    AskedCopies, Invariant, InvariantExpectations, InvariantReport, InvariantViolation, check_invariants,
};
pub use records::ledger_freshness::{find_abandoned_claims, find_unknown_to_ledger as unknown_to_ledger};
pub use records::lost_ledger::{detect_lost_ledger as lost_ledger, lost_ledger_text};
pub use records::order_notes::{note_order, update_order_notes};
pub use records::reconcile_report::ReconcileReport;
pub use recover::ledger_copy::copy_ledger;
pub use recover::restore::{RestoreOutcome, repair_ledger, restore_ledger};
pub use run::event_loop::run;
pub use run::status::farm_summary;
pub use search::{FoundNames, FoundRows, search_names};
