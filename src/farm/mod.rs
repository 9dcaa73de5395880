//! The service: one file per step of a part's life, and one event loop.
//!
//! `farm` and `state` hold what the steps share. A step is a file of functions that take what they need: the ledger, the
//! settings, the machines, the alerts or the jobs; or the whole farm. What a step decides is a function without a farm
//! (`trigger`, `batch_decision`, `nest_decision`, `night_decision`, `publish_decision`, `tick_tasks`), and what it does off the loop is a `BackgroundJob` in the same file. `hot_folder_scanner`
//! `scan_jobs` and `intake_jobs` claim and read dropped files, `batch` keeps the open build up to date and fires it, `nest` searches,
//! writes and proves, `publish` publishes, `commands` carries out commands of operators. Only `event_loop` knows all
//! steps.

mod adopt;
mod alert;
mod alert_registry;
mod alert_summary;
mod arriving_lines;
mod batch;
mod batch_decision;
mod build_move;
mod build_record;
mod cake;
mod claim_completion;
mod claim_note;
mod clock_changes;
mod command_answer;
mod commands;
mod control_files;
mod cpu_meter;
mod crash_guard;
mod damaged_files;
mod deferred_refusal;
mod disk_cache;
mod doubtful_drops;
#[cfg(test)]
mod driven_tests;
mod due_dates;
mod duplicates;
mod error_folder;
mod event_loop;
mod failure;
mod farm;
mod fetch_originals;
mod file_fault;
mod file_request;
mod fire_forecast;
mod folder_builds;
mod folder_check;
mod folder_comparison;
mod folder_lease;
mod folder_leases;
mod forget;
mod forgettable;
mod forgotten_files;
mod hot_folder_scan;
mod hot_folder_scanner;
mod hurried_scans;
mod intake_jobs;
mod invariants;
mod isolated_read;
mod job_events;
mod jobs;
mod judged_file;
mod kept_build;
mod kept_layouts;
mod known_folders;
mod lane_job;
mod lane_problem;
mod lane_search;
mod late_tickets;
mod layout;
mod lease_clock;
mod lease_holder;
mod lease_marker;
mod lease_renewal;
mod ledger_changes;
mod ledger_copy;
mod ledger_freshness;
mod ledger_service;
mod left_out;
mod lost_ledger;
mod machine_availability;
mod machine_fit;
mod machine_setup;
mod machine_state;
mod mark_note;
mod mesh_cache;
mod mesh_source;
mod nest;
mod nest_decision;
mod nesting_search;
mod newer_decisions;
mod night_decision;
mod night_search;
mod night_text;
mod node_content;
mod obeyed_controls;
mod open;
mod open_night;
mod operate;
mod order_notes;
mod own_machines;
mod part_changes;
mod part_questions;
mod planning;
mod print_times;
mod printer_choice;
mod printer_outlook;
mod printer_state;
mod printers;
mod publish;
mod publish_decision;
mod queue_alerts;
mod queue_depth;
mod queue_files;
mod queue_look;
mod queues;
mod read;
mod read_again;
mod read_turn;
mod ready_files;
mod reconcile;
mod reconcile_report;
mod refused_files;
mod refused_part;
mod release_preview;
mod restore;
mod retry_backoff;
mod revisions;
mod scan_jobs;
mod search;
mod second_copies;
mod signals;
mod staged_build;
mod standing_claim;
mod state;
mod state_lock;
mod status;
mod status_alerts;
mod systemd;
mod thread_priority;
mod tick_tasks;
mod tidy;
mod time_source;
mod time_text;
mod trigger;
mod wall_clock;
mod watching;
mod withdrawal;
mod withdrawal_decision;
mod write_build;

pub use adopt::adopt_claims;
pub use alert::{AlertKind, FarmAlert};
pub use alert_registry::{ServiceBridge, ServicePhase, read_stored_alerts};
pub use alert_summary::AlertSummary;
pub use cake::{
    CakeContents, CakeCopy, CakePart, count_copies_in_layout, find_proved_file, load_placed_parts, locate_build_file,
    resolve_volume_mm,
};
pub use disk_cache::DiskPreparationCache;
pub use event_loop::run;
pub use farm::halt_summary;
pub use fire_forecast::{FireForecast, forecast_fire};
pub use folder_check::{check_readable, watch_other_holders};
pub use folder_lease::LeaseError;
pub use invariants::{
    AskedCopies, Invariant, InvariantExpectations, InvariantReport, InvariantViolation, check_invariants,
};
pub use isolated_read::{SUBCOMMAND as READ_PART, answer_read_request};
pub use judged_file::judge_file;
pub use known_folders::is_known_folder;
pub use ledger_copy::copy_ledger;
pub use ledger_freshness::{find_abandoned_claims, find_unknown_to_ledger as unknown_to_ledger};
pub use lost_ledger::{detect_lost_ledger as lost_ledger, lost_ledger_text};
pub use night_text::{night_gain_text, night_text};
pub use node_content::find_kept_content;
pub use operate::operate;
pub use order_notes::{note_order, update_order_notes};
pub use own_machines::machines_of_other_nodes;
pub use part_questions::PartQuestion;
pub use planning::{
    DateRisk, DueAnswer, MachinePlan, OrderQuote, PlanStage, PlannedBuild, PlannedPart, QUOTE_SEARCH_TIME, QuoteError,
    QuoteMeshes, QuoteQuestion, QuotedFile, RiskCause, plan_machine, quote_order, read_plan, read_quoted_files,
};
pub use print_times::PrintTimes;
pub use printers::{PrinterView, printer_views};
pub use queue_depth::held_text;
pub use reconcile_report::ReconcileReport;
pub use refused_files::dismiss_refused;
pub use release_preview::{LatePreview, ReleasePreview, awaits_release, preview_release};
pub use restore::{RestoreOutcome, repair_ledger, restore_ledger};
pub use search::{FoundNames, FoundRows, search_names};
pub use state::Load;
pub use status::farm_summary;
pub use trigger::FireTrigger;
