//! A machine and its printers as their file describes them, with their calendar and the zones that stay free.

pub(super) mod cost_rules;
pub(super) mod farm_zone;
pub(super) mod keep_out;
pub(super) mod materials;
pub(super) mod printer;
pub(super) mod profile;
pub(super) mod profile_inputs;
pub(super) mod work_calendar;
