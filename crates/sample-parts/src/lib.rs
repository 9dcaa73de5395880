//! The project's own sample parts, made by code: for the demo, the tests and the benches. Millimetres.
//!
//! Parts with sharp edges are built exactly, from outlines that are extruded or swept. Unions and lattices come from
//! signed distance functions and marching tetrahedra. Every sample is one closed, consistently oriented surface.

pub mod fixtures;
mod making;
mod parts;
mod workload;

use solids::Mesh;

pub use making::implicit::{connecting_rod, gyroid_ball, pipe_tee};
pub use parts::blocks::{lattice_block, tray};
pub use parts::boulder::boulder;
pub use parts::extruded::{bracket, clip, cuboid, frame, hinge, honeycomb, rail, ribbed_bracket, spur_gear, wheel};
pub use parts::fan::axial_fan;
pub use parts::figure::random_figure;
pub use parts::revolved::{lampshade, pawn, pulley, ring};
pub use parts::swept::{duct, hook, knob, spring};
pub use workload::{
    COMPARED_ROOM_MM, COMPARED_WORKLOADS, ComparedWorkload, SampleWorkload, WorkloadFile, random_part, workload_parts,
};

/// A sample part, with the name of its file.
#[derive(Debug, Clone)]
pub struct SamplePart {
    /// File name without extension, ASCII.
    pub name: &'static str,
    /// The solid, mm.
    pub mesh: Mesh,
}

/// One sample of every kind, the largest 180 mm long.
pub fn all_samples() -> Vec<SamplePart> {
    let sample = |name, mesh| SamplePart { name, mesh };
    vec![
        sample("axial_fan", axial_fan(65.0, 22.0, 7)),
        sample("bracket", bracket(60.0, 24.0, 4.0, 5.0)),
        sample("ribbed_bracket", ribbed_bracket(40.0, 36.0, 3.5, 4)),
        sample("duct", duct(30.0, 2.5, 32.0, 90.0, 18.0)),
        sample("ring", ring(40.0, 28.0, 8.0)),
        sample("spur_gear", spur_gear(24, 2.0, 10.0, 10.0)),
        sample("lattice_block", lattice_block([3, 3, 3], 10.0, 2.5)),
        sample("clip", clip(22.0, 2.4, 14.0)),
        sample("hinge", hinge(50.0, 24.0, 9.0, 4.0, 3)),
        sample("knob", knob(42.0, 20.0, 6)),
        sample("hook", hook(16.0, 8.0, 30.0)),
        sample("tray", tray([4, 2], 22.0, 18.0, 2.0)),
        sample("lampshade", lampshade(80.0, 40.0, 55.0, 2.0)),
        sample("pulley", pulley(44.0, 12.0, 8.0)),
        sample("pipe_tee", pipe_tee(56.0, 32.0, 24.0, 3.5)),
        sample("honeycomb", honeycomb(8, 7, 8.0, 1.6, 6.0)),
        sample("pawn", pawn(26.0, 48.0)),
        sample("rail", rail(180.0, 35.0, 10.0, 2.5)),
        sample("spring", spring(24.0, 4.0, 9.0, 5.0)),
        sample("connecting_rod", connecting_rod(60.0, 30.0, 20.0, 12.0)),
        sample("gyroid_ball", gyroid_ball(36.0, 18.0, 3.2)),
    ]
}

#[cfg(test)]
mod mend_tests;
#[cfg(test)]
mod tests;
