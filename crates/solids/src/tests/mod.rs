//! Tests of several files.

#[cfg(test)]
pub(super) mod clearance_tests;
#[cfg(test)]
pub(super) mod speed_tests;
#[cfg(test)]
pub(super) mod sweep_tests;
