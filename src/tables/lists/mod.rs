//! The tables that people see, one file each.

pub(super) mod cost_list;
pub(super) mod event_list;
pub(super) mod history;
pub(super) mod month;
pub(super) mod node_list;
pub(super) mod order_list;
pub(super) mod part_list;
pub(super) mod people_list;
pub(super) mod pick_list;
pub(super) mod plan_list;
pub(super) mod printer_list;
