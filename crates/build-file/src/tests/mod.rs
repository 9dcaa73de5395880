//! Tests of several files.

#[cfg(test)]
pub(super) mod build_tests;
#[cfg(test)]
pub(super) mod camspec_tests;
#[cfg(test)]
pub(super) mod delivery_tests;
#[cfg(test)]
pub(super) mod item_contact_tests;
#[cfg(test)]
pub(super) mod polygon_tests;
#[cfg(test)]
mod second_reader_tests;
#[cfg(test)]
pub(super) mod slicer_project_tests;
#[cfg(test)]
pub(super) mod test_package;
#[cfg(test)]
pub(super) mod unfinished_tests;
