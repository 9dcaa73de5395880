//! What is told of a finished nesting, for people and programs.

use serde::{Deserialize, Serialize};

use super::{Instance, LayerAreas, LayerCap, Solution, lower_bound_mm, settle::packing};
use crate::geometry::{Bounds, Mesh, Pose};

/// Where one copy stands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlacedPart {
    /// Name of the item.
    pub part: String,
    /// Copy number, from 0.
    pub copy: u32,
    /// Row-major 4x4 matrix on column vectors: mesh frame -> machine frame, mm.
    pub pose: [[f64; 4]; 4],
}

/// A copy that found no place.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct UnplacedPart {
    /// Name of the item.
    pub part: String,
    /// Copy number, from 0.
    pub copy: u32,
}

/// How a search went, as seen from outside; what [`Report::new`] needs beside the solution.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Course {
    /// Least distance found by the proof of the written file, mm; `None` when no two parts are near.
    pub clearance_proved_mm: Option<f64>,
    /// Seed of the search.
    pub seed: u64,
    /// CPU seconds of the whole process.
    pub cpu_secs: f64,
    /// Wall seconds of the search.
    pub wall_secs: f64,
    /// (wall seconds, build height in mm) of every improvement.
    pub curve: Vec<(f64, f64)>,
}

/// The report on one build.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Top of the highest placement, mm.
    pub height_mm: f64,
    /// Part volume / (base area x build height).
    pub density: f64,
    /// Part volume / volume of the packed box, from the corner of the box that may be filled to the farthest of all parts.
    pub packed_density: f64,
    /// Mean distance of the middles of the parts' bounds from the corner of the box that may be filled, mm.
    pub mean_distance_mm: f64,
    /// What is filled in each layer.
    pub layers: LayerAreas,
    /// A height that no layout of all copies can beat, mm.
    pub lower_bound_mm: f64,
    /// Clearance asked, mm.
    pub clearance_mm: f64,
    /// By how much either of two parts may be raised without breaking it, mm.
    pub clearance_z_extra_mm: f64,
    /// Least distance between any two parts, mm, proved on the triangles of the written file; `null` when none are near.
    pub clearance_proved_mm: Option<f64>,
    /// Copies placed.
    pub placed: usize,
    /// Copies that found no place.
    pub unplaced: Vec<UnplacedPart>,
    /// Seed of the search.
    pub seed: u64,
    /// Evaluations made.
    pub evaluations: u64,
    /// CPU seconds of the whole process.
    pub cpu_secs: f64,
    /// Wall seconds of the search.
    pub wall_secs: f64,
    /// (wall seconds, build height in mm) of every improvement.
    pub curve: Vec<(f64, f64)>,
    /// Where every copy stands.
    pub placements: Vec<PlacedPart>,
}

impl Report {
    /// Measures density, closeness and layers of placed meshes that stand in the box that may be filled, its corner at the
    /// origin.
    pub fn measured(mut self, placed: &[(&Mesh, Pose)], cap: LayerCap) -> Self {
        let bounds: Vec<Bounds> = placed.iter().map(|(mesh, pose)| mesh.bounds_at(pose)).collect();
        let volume_mm3 = placed.iter().map(|(mesh, _)| mesh.volume_mm3()).sum();
        (self.packed_density, self.mean_distance_mm) = packing(volume_mm3, bounds.iter().copied());
        self.layers = LayerAreas::of(placed.iter().copied(), cap);
        self
    }

    /// Puts together what was asked, what was found and how the search went; what stands where is measured by
    /// [`Report::measured`].
    pub fn new(instance: &Instance, solution: &Solution, course: Course) -> Self {
        let name = |item: usize| instance.items()[item].name.clone();
        let placed = |p: &super::Placement| PlacedPart { part: name(p.item), copy: p.copy, pose: p.pose.rows() };
        Self {
            height_mm: solution.height_mm,
            density: solution.density(instance),
            packed_density: 0.0,
            mean_distance_mm: 0.0,
            layers: LayerAreas::default(),
            lower_bound_mm: lower_bound_mm(instance),
            clearance_mm: instance.clearance_mm(),
            clearance_z_extra_mm: instance.clearance_z_extra_mm(),
            clearance_proved_mm: course.clearance_proved_mm,
            placed: solution.placements.len(),
            unplaced: (solution.unplaced.iter()).map(|&(i, copy)| UnplacedPart { part: name(i), copy }).collect(),
            seed: course.seed,
            evaluations: solution.evaluations,
            cpu_secs: course.cpu_secs,
            wall_secs: course.wall_secs,
            curve: course.curve,
            placements: solution.placements.iter().map(placed).collect(),
        }
    }
}
