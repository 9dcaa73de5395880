//! One thing with all its fields: a build, a part, a machine.

pub(super) mod build_sheet;
pub(super) mod machine_status;
pub(super) mod part_sheet;
pub(super) mod record_sheet;
