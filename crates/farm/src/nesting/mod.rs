//! One driver makes all searches of the farm: `search_policy` says what an arrival, a build that waits, a fired build and a quote differ
//! in (time, threads, priority, begin, stop, and what becomes of the result), `layout_search` runs one, `running_searches` shares the
//! threads among them, `write_build` writes and proves what the last one found.
//!
//! Works off the loop and touches no state of the farm.

pub(super) mod layout_search;
pub(super) mod nest_decision;
pub(super) mod node_client;
pub(super) mod node_content;
pub(super) mod open_night;
pub(super) mod part_mesh;
pub(super) mod running_searches;
pub(super) mod search_policy;
pub(super) mod write_build;
