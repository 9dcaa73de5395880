//! How parts that overlap make room: the layout that is worked on, how deep two parts overlap, and the moves that part them.
//!
//! Owns the working layout. A move changes poses; it never decides whether a search goes on.

pub(super) mod disassembly;
pub(super) mod exact_contacts;
pub(super) mod hull_penetration;
pub(super) mod interlock_check;
pub(super) mod interlock_memory;
pub(super) mod joint_motion;
pub(super) mod layout_parts;
pub(super) mod overlap_depth_grid;
pub(super) mod pair_records;
pub(super) mod proximity_grid;
pub(super) mod relocation;
pub(super) mod separation;
pub(super) mod separation_step;
pub(super) mod working_layout;
