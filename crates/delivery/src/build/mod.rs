//! The only way to a proved build. Machine and parts become an instance for the nester. Its solution becomes a build
//! file. The written file is read back, compared with a second reader and proved on its triangles. A report describes
//! the result.
//!
//! The farm, `nestd nest` and `nestd verify` all use this module. They decide where files are written and what they are
//! called.

mod build_part;
mod file_verification;
mod machine_spec;
mod placement_verification;
mod prove;
mod solved_build;

pub use build_part::{BuildPart, PartPlacement};
pub use file_verification::BuildFileVerification;
pub use machine_spec::MachineSpec;
pub use placement_verification::PlacementVerification;
pub use prove::{BuildProofError, ProvedBuild};
pub use solved_build::{BuildHeading, SolvedBuild, render_picture};

#[cfg(test)]
mod fixtures;
#[cfg(test)]
mod tests;
