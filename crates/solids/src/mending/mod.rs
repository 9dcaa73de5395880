//! Mends a surface that is not closed, where there is one way only to read it: doubled and hanging triangles left out, triangles turned,
//! small holes closed.
//!
//! Decides what is certain enough to be offered; never whether it is done. What is ambiguous is an error with its reason.

mod crossing;
mod edges;
mod fill;
pub(super) mod mend;
mod orient;
mod rims;
mod tidy;
