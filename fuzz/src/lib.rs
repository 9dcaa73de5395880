//! The entries of the fuzz targets; the tests of nestd replay the corpus through the same.
#![allow(dead_code)] // a target uses one of them

#[path = "../../tests/fuzz/entries.rs"]
pub mod entries;
#[path = "../../tests/fuzz/samples.rs"]
mod samples;
