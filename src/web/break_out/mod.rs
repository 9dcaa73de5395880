//! The pick map step by step, for people with gloves.

pub(super) mod bins;
pub(super) mod break_out;
pub(super) mod break_out_card;
pub(super) mod break_out_state;
pub(super) mod step_plan;
pub(super) mod together;
