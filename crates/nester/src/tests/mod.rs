//! Tests of whole searches.

#[cfg(test)]
pub(super) mod compression_tests;
#[cfg(test)]
pub(super) mod dominating_tests;
#[cfg(test)]
pub(super) mod first_layout_tests;
#[cfg(test)]
pub(super) mod improvement_tests;
#[cfg(test)]
pub(super) mod interlock_tests;
#[cfg(test)]
pub(super) mod nester_tests;
#[cfg(test)]
pub(super) mod open_build_tests;
#[cfg(test)]
pub(super) mod precedence_tests;
#[cfg(test)]
pub(super) mod separation_tests;
#[cfg(test)]
pub(super) mod testing;
#[cfg(test)]
pub(super) mod tie_break_tests;
