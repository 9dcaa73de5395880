//! The pick map step by step, for people with gloves.

pub(super) mod break_out;
pub(super) mod break_out_card;
pub(super) mod break_out_state;
