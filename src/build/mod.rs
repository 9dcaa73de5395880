//! One way to a proved build: machine and parts -> an instance for the nester; what it found -> a build file; the written file
//! -> read back, compared with a second reader, proved on its triangles; a report on it.
//!
//! The farm, `nestd nest` and `nestd verify` all go through here. Where files are written and what they are called is theirs.

mod judgement;
mod machine;
mod part;
mod prove;
mod solved_build;
mod verdict;

pub use judgement::Judgement;
pub use machine::Machine;
pub use part::{BuildPart, PartPlacement};
pub use prove::{ProveError, ProvedBuild};
pub use solved_build::{BuildHeading, SolvedBuild, picture};
pub use verdict::Verdict;

#[cfg(test)]
pub mod tests;
