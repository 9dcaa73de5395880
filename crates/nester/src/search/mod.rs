//! The search for a lower layout: layouts are compressed, compete, exchange poses between lanes, and go on in rounds.
//!
//! `nester` is the door for callers. It decides when a search begins and ends; how parts move is in `separation`.

pub(super) mod compression;
pub(super) mod dominating;
pub(super) mod improvement;
pub(super) mod lane_rounds;
pub(super) mod nester;
pub(super) mod nesting_search;
pub(super) mod tournament;
