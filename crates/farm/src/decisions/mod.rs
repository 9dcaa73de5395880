//! What a step decides, as functions without a farm: when a build fires, who is left out, which printer, when something is taken back.
//!
//! Pure, save `kept_layouts`, which reads from the ledger; time comes in as a value.

pub(super) mod batch_decision;
pub(super) mod fire_forecast;
pub(super) mod kept_layouts;
pub(super) mod layout;
pub(super) mod left_out;
pub(super) mod night_decision;
pub(super) mod night_text;
pub(super) mod print_times;
pub(super) mod printer_choice;
pub(super) mod printer_outlook;
pub(super) mod publish_decision;
pub(super) mod queue_depth;
pub(super) mod trigger;
pub(super) mod withdrawal_decision;
