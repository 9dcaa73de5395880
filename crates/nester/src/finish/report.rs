//! The report on a finished nesting, for people and programs.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use solids::{Bounds, Mesh, Pose};

use super::tie_break::packing_measures;
use crate::{
    Disassembly, InterlockRule, LayerAreaCap, LayerAreas, LayoutProver, LeftOutFit, NestingInstance, NestingSolution,
    PlacedSolid, lower_bound_mm, removal_gap_mm,
};

/// The pose of one copy.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlacedPart {
    /// Name of the item.
    pub part: String,
    /// Copy number, from 0.
    pub copy: u32,
    /// Row-major 4x4 matrix on column vectors: mesh frame -> machine frame, mm.
    pub pose: [[f64; 4]; 4],
}

/// A copy that could not be placed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnplacedPart {
    /// Name of the item.
    pub part: String,
    /// Copy number, from 0.
    pub copy: u32,
    /// Where it would fit, if that was examined: see [`examine_left_out`](crate::examine_left_out).
    #[serde(default)]
    pub fits: Option<LeftOutFit>,
}

/// A locked copy.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LockedCopy {
    /// Name of the item.
    pub part: String,
    /// Copy number, from 0.
    pub copy: u32,
}

/// A copy that can be removed from the build after all copies before it in the list.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RemovedCopy {
    /// Name of the item.
    pub part: String,
    /// Copy number, from 0.
    pub copy: u32,
    /// The direction of removal: a unit vector in the machine's frame.
    #[serde(rename = "way")]
    pub direction: [f64; 3],
}

/// Whether a build can be taken apart, and in which order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Separability {
    /// Least distance that a copy keeps from all remaining copies while it is removed, mm (for parts with their own
    /// clearance half of that, at most half a millimetre).
    pub gap_mm: f64,
    /// Copies that cannot be removed: they are interlocked.
    pub locked: Vec<LockedCopy>,
    /// The other copies, in an order in which they can be removed.
    pub order: Vec<RemovedCopy>,
}

impl Separability {
    /// Creates the result from a disassembly, for a build with a clearance (mm); `name` returns the part and copy of an
    /// index.
    pub fn new(disassembly: &Disassembly, clearance_mm: f64, name: impl Fn(usize) -> (String, u32)) -> Self {
        let removed_copy = |&(body, direction): &(usize, DVec3)| {
            let (part, copy) = name(body);
            RemovedCopy { part, copy, direction: direction.to_array() }
        };
        let locked = |&body: &usize| {
            let (part, copy) = name(body);
            LockedCopy { part, copy }
        };
        Self {
            gap_mm: removal_gap_mm(clearance_mm),
            locked: disassembly.locked.iter().map(locked).collect(),
            order: disassembly.order.iter().map(removed_copy).collect(),
        }
    }

    /// Takes bodies apart if a rule requires it; `None` if interlocking is not checked.
    pub fn disassemble_under(rule: InterlockRule, layout: &LayoutProver<'_>) -> Option<Disassembly> {
        (rule != InterlockRule::Allow).then(|| layout.find_removal_order())
    }

    /// The result of [`Separability::disassemble_under`], with names.
    pub fn examine_bodies(
        rule: InterlockRule,
        bodies: &[PlacedSolid],
        clearance_mm: f64,
        name: impl Fn(usize) -> (String, u32),
    ) -> Option<Self> {
        Self::disassemble_under(rule, &LayoutProver::new(bodies, 1)).map(|found| Self::new(&found, clearance_mm, name))
    }

    /// Whether the result obeys a rule.
    pub fn obeys_rule(&self, rule: InterlockRule) -> bool {
        rule != InterlockRule::Forbid || self.locked.is_empty()
    }

    /// A sentence with the number and the names of the locked copies.
    pub fn in_words(&self) -> String {
        format!("{} parts are locked into each other: {}", self.locked.len(), self.locked_text())
    }

    /// The locked copies on one line, the first few by name.
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

/// Data about a search that [`NestingReport::new`] needs in addition to the solution.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SearchSummary {
    /// Least distance measured by the proof of the written file, mm; `None` when no two parts are near.
    pub clearance_proved_mm: Option<f64>,
    /// Disassembly of the written file; `None` when interlocking was not checked.
    pub separable: Option<Separability>,
    /// Where copies of the items would fit that found no place, if that was examined; the keys are indices of items.
    pub left_out: BTreeMap<usize, LeftOutFit>,
    /// Seed of the search.
    pub seed: u64,
    /// CPU seconds of the whole process.
    pub cpu_secs: f64,
    /// Wall seconds of the search.
    pub wall_secs: f64,
    /// (wall seconds, build height in mm) of every improvement: see [`HeightCurve`](crate::HeightCurve).
    pub curve: Vec<(f64, f64)>,
    /// Why the search ended, in words: see [`SearchEnd`](crate::SearchEnd).
    pub ended: String,
}

impl UnplacedPart {
    /// The copies that a solution lacks; `name` returns the name of an item.
    pub fn name_copies(
        unplaced: &[(usize, u32)],
        fits: &BTreeMap<usize, LeftOutFit>,
        name: impl Fn(usize) -> String,
    ) -> Vec<Self> {
        let named = |&(item, copy): &(usize, u32)| Self { part: name(item), copy, fits: fits.get(&item).cloned() };
        unplaced.iter().map(named).collect()
    }
}

/// The report on one build. In JSON, its groups are one flat object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NestingReport {
    /// How well the parts are packed.
    #[serde(flatten)]
    pub packing: PackingMeasures,
    /// Required and measured distances between parts.
    #[serde(flatten)]
    pub clearance: ClearanceMeasures,
    /// Disassembly of the written file; `null` when locked parts are allowed and were not checked.
    pub separable: Option<Separability>,
    /// Copies placed.
    pub placed: usize,
    /// Copies that could not be placed.
    pub unplaced: Vec<UnplacedPart>,
    /// What the search cost.
    #[serde(flatten)]
    pub search: SearchCost,
    /// The pose of every copy.
    pub placements: Vec<PlacedPart>,
}

/// How well the parts of a build are packed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PackingMeasures {
    /// Top of the highest placement, mm.
    pub height_mm: f64,
    /// Part volume / (base area x build height).
    pub density: f64,
    /// Part volume / volume of the packed box, which reaches from the corner of the usable box to the farthest part.
    pub packed_density: f64,
    /// Mean distance of the centers of the parts' bounds from the corner of the usable box, mm.
    pub mean_distance_mm: f64,
    /// The filled areas of the layers.
    pub layers: LayerAreas,
    /// A height that no layout of all copies can beat, mm.
    pub lower_bound_mm: f64,
}

/// Required and measured distances between the parts of a build.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClearanceMeasures {
    /// Required clearance, mm.
    pub clearance_mm: f64,
    /// Height by which either of two parts may be raised without breaking the clearance, mm.
    pub clearance_z_extra_mm: f64,
    /// Least distance between any two parts, mm, proved on the triangles of the written file; `null` when none are near.
    pub clearance_proved_mm: Option<f64>,
}

/// What a search cost, and how it went on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchCost {
    /// Seed of the search.
    pub seed: u64,
    /// Evaluations made.
    pub evaluations: u64,
    /// CPU seconds of the whole process.
    pub cpu_secs: f64,
    /// Wall seconds of the search.
    pub wall_secs: f64,
    /// (wall seconds, build height in mm) of every improvement, with as many copies as the build has.
    pub curve: Vec<(f64, f64)>,
    /// Why the search ended.
    #[serde(default)]
    pub ended: String,
}

impl NestingReport {
    /// Measures density, closeness and layers of placed meshes, given in the frame of the usable box, with its corner
    /// at the origin.
    pub fn with_measurements(mut self, placed: &[(&Mesh, Pose)], cap: LayerAreaCap) -> Self {
        let bounds: Vec<Bounds> = placed.iter().map(|(mesh, pose)| mesh.bounds_at(pose)).collect();
        let volume_mm3 = placed.iter().map(|(mesh, _)| mesh.volume_mm3()).sum();
        (self.packing.packed_density, self.packing.mean_distance_mm) =
            packing_measures(volume_mm3, bounds.iter().copied());
        self.packing.layers = LayerAreas::from_meshes(placed.iter().copied(), cap);
        self
    }

    /// Combines the instance, the solution and the data about the search. Measures of the placed meshes are added by
    /// [`NestingReport::with_measurements`].
    pub fn new(instance: &NestingInstance, solution: &NestingSolution, summary: SearchSummary) -> Self {
        let name = |item: usize| instance.items()[item].name.clone();
        let placed =
            |p: &crate::ItemPlacement| PlacedPart { part: name(p.item), copy: p.copy, pose: p.pose.matrix_rows() };
        Self {
            packing: PackingMeasures {
                height_mm: solution.height_mm,
                density: solution.density(instance),
                lower_bound_mm: lower_bound_mm(instance),
                ..PackingMeasures::default()
            },
            clearance: ClearanceMeasures {
                clearance_mm: instance.clearance_mm(),
                clearance_z_extra_mm: instance.clearance_z_extra_mm(),
                clearance_proved_mm: summary.clearance_proved_mm,
            },
            separable: summary.separable,
            placed: solution.placements.len(),
            unplaced: UnplacedPart::name_copies(&solution.unplaced, &summary.left_out, name),
            search: SearchCost {
                seed: summary.seed,
                evaluations: solution.evaluations,
                cpu_secs: summary.cpu_secs,
                wall_secs: summary.wall_secs,
                curve: summary.curve,
                ended: summary.ended,
            },
            placements: solution.placements.iter().map(placed).collect(),
        }
    }
}
