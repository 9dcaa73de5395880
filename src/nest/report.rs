//! What is told of a finished nesting, for people and programs.

use serde::{Deserialize, Serialize};

use super::{Instance, Solution, lower_bound_mm};

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
    /// A height that no layout of all copies can beat, mm.
    pub lower_bound_mm: f64,
    /// Clearance asked, mm.
    pub clearance_mm: f64,
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
    /// Puts together what was asked, what was found and how the search went.
    pub fn new(instance: &Instance, solution: &Solution, course: Course) -> Self {
        let name = |item: usize| instance.items()[item].name.clone();
        let placed = |p: &super::Placement| PlacedPart { part: name(p.item), copy: p.copy, pose: p.pose.rows() };
        Self {
            height_mm: solution.height_mm,
            density: solution.density(instance),
            lower_bound_mm: lower_bound_mm(instance),
            clearance_mm: instance.clearance_mm(),
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
