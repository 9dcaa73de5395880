//! What is told of a finished nesting, for people and programs.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use solids::{Bounds, Mesh, Pose};

use super::{
    Body, Instance, Interlock, LayerAreas, LayerCap, Solution, TakenApart, drawing_gap_mm, lower_bound_mm,
    settle::packing, take_apart,
};

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

/// A placed copy.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedCopy {
    /// Name of the item.
    pub part: String,
    /// Copy number, from 0.
    pub copy: u32,
}

/// A copy that can be drawn out of the build, after all that are told before it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DrawnCopy {
    /// Name of the item.
    pub part: String,
    /// Copy number, from 0.
    pub copy: u32,
    /// The straight line that it takes: a unit vector in the machine's frame.
    pub way: [f64; 3],
}

/// Whether and how a build comes apart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Separability {
    /// Distance that a copy keeps at least from all that are still there while it is drawn out, mm (for parts with a
    /// clearance of their own half of that, at most half a millimetre).
    pub gap_mm: f64,
    /// Copies that cannot be drawn out: locked into each other.
    pub locked: Vec<NamedCopy>,
    /// The others in an order in which they can be drawn out.
    pub order: Vec<DrawnCopy>,
}

impl Separability {
    /// What the judge found, for a build of a clearance (mm); `name` gives an index's part and copy.
    pub fn new(apart: &TakenApart, clearance_mm: f64, name: impl Fn(usize) -> (String, u32)) -> Self {
        let drawn = |&(body, way): &(usize, DVec3)| {
            let (part, copy) = name(body);
            DrawnCopy { part, copy, way: way.to_array() }
        };
        let locked = |&body: &usize| {
            let (part, copy) = name(body);
            NamedCopy { part, copy }
        };
        Self {
            gap_mm: drawing_gap_mm(clearance_mm),
            locked: apart.locked.iter().map(locked).collect(),
            order: apart.order.iter().map(drawn).collect(),
        }
    }

    /// Takes bodies apart as far as a rule asks for it: `None` where nobody looks.
    pub fn apart(rule: Interlock, bodies: &[Body]) -> Option<TakenApart> {
        (rule != Interlock::Allow).then(|| take_apart(bodies))
    }

    /// What [`Separability::apart`] finds, with names.
    pub fn look(
        rule: Interlock,
        bodies: &[Body],
        clearance_mm: f64,
        name: impl Fn(usize) -> (String, u32),
    ) -> Option<Self> {
        Self::apart(rule, bodies).map(|apart| Self::new(&apart, clearance_mm, name))
    }

    /// Whether a rule lets pass what was found.
    pub fn obeys(&self, rule: Interlock) -> bool {
        rule != Interlock::Forbid || self.locked.is_empty()
    }

    /// How many are locked, and who.
    pub fn in_words(&self) -> String {
        format!("{} parts are locked into each other: {}", self.locked.len(), self.locked_text())
    }

    /// The locked copies in one line, the first few by name.
    pub fn locked_text(&self) -> String {
        const NAMED: usize = 5;
        let names = self.locked.iter().take(NAMED).map(|c| format!("{} #{}", c.part, c.copy + 1));
        let more = match self.locked.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        names.collect::<Vec<_>>().join(", ") + &more
    }
}

/// How a search went, as seen from outside; what [`Report::new`] needs beside the solution.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Course {
    /// Least distance found by the proof of the written file, mm; `None` when no two parts are near.
    pub clearance_proved_mm: Option<f64>,
    /// Whether the written file comes apart; `None` when nobody looked.
    pub separable: Option<Separability>,
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
    /// Whether and how the written file comes apart; `null` when locked parts are allowed and nobody looked.
    pub separable: Option<Separability>,
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
            separable: course.separable,
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
