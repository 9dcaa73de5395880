//! What a person changes on a page, form by form; a handler returns an answer in words.

pub(super) mod build_forms;
pub(super) mod drop_form;
pub(super) mod finish_forms;
pub(super) mod machine_forms;
pub(super) mod operate_form;
pub(super) mod order_cancel;
pub(super) mod order_forms;
pub(super) mod part_forms;
