//! The search for a lower layout: layouts are compressed, compete, exchange poses between lanes, and go on in rounds.
//!
//! `nester` is the door for callers. It decides when a search begins and ends; how parts move is in `separation`.
//!
//! What is aimed at: more copies first, then a lower build (`start/nesting_run::rank`, `prepare/prepared_instance::height_mm`), and of equal
//! heights the better `finish/tie_break::LayoutMerit`.

pub(super) mod compression;
pub(super) mod dominating;
pub(super) mod improvement;
pub(super) mod lane_rounds;
pub(super) mod nester;
pub(super) mod nesting_search;
pub(super) mod tournament;
