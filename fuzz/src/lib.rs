//! The entries of the fuzz targets; the tests of nestd replay the corpus through the same.
#![allow(dead_code)] // a target uses one of them

#[path = "../../tests/support/entries.rs"]
pub mod entries;
#[path = "../../tests/support/samples.rs"]
mod samples;
