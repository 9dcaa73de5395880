//! Rows that several nouns share: parts with their measures, builds, and the order in which parts go first.

pub(super) mod build_row;
pub(super) mod part_measures;
pub(super) mod part_row;
pub(super) mod precedence;
pub(super) mod recorded_part;
pub(super) mod solid_facts;
