//! A search turns a batch of parts into a layout. Runs on a job's thread.

use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError},
};

use anyhow::Result;
use ledger::PartRow;
use nester::{NestingSolution, SearchBudget};

use crate::{
    farm::{
        decisions::layout::{BatchLayout, LayoutPlacement, NestingBatch, NestingPart},
        files::mesh_source::MeshSource,
        process::cpu_meter::CpuMeter,
    },
    settings::MachineProfile,
};

/// The best layout of a running search; other threads read it, and take it when the search is cancelled.
pub type SharedBestLayout = Arc<Mutex<Option<BatchLayout>>>;

/// A request to nest parts.
#[derive(Debug)]
pub struct NestingRequest {
    /// The machine.
    pub profile: Arc<MachineProfile>,
    /// Parts with their wanted copies, in order of precedence; a part may be there twice.
    pub wanted: Vec<(PartRow, Vec<u32>)>,
    /// Earlier layouts; the search continues from the lowest of those that place the most copies.
    pub starts: Vec<Vec<LayoutPlacement>>,
    /// The time budget.
    pub budget: SearchBudget,
    /// Seed of the search.
    pub seed: u64,
    /// Receives every better layout.
    pub best_layout: SharedBestLayout,
}

/// The result of a search.
#[derive(Debug)]
pub struct NestingResult {
    /// Parts with their meshes.
    pub batch: NestingBatch,
    /// The layout.
    pub layout: BatchLayout,
    /// Lower bound on the height of any layout of the placed copies, mm.
    pub lower_bound_mm: f64,
    /// CPU seconds of the search.
    pub cpu_secs: f64,
    /// Wall seconds of the search.
    pub wall_secs: f64,
    /// (wall seconds, build height in mm) of every improvement.
    pub curve: Vec<(f64, f64)>,
}

impl NestingResult {
    /// Exchanges the places of copies that an eye confuses, so that those of each order stand together.
    pub(crate) fn set_look_alikes_apart(&mut self, profile: &MachineProfile) -> Result<()> {
        let instance = self.batch.create_instance(profile)?;
        let mut placements = self.batch.matching_placements(&self.layout.placed);
        let mut known = BTreeMap::new();
        let kinds = self.batch.parts.iter().map(|NestingPart { part, .. }| {
            let next = known.len();
            *known.entry((&part.terms.order_name, &part.file.content_hash, part.solid.object_index)).or_insert(next)
        });
        let kinds: Vec<usize> = kinds.collect();
        nester::set_look_alikes_apart(&instance, &profile.search.nest, &kinds, &mut placements);
        self.layout.placed = self.batch.layout_placements(&placements);
        Ok(())
    }
}

impl NestingRequest {
    /// Runs the search; returns when the budget is spent or cancelled.
    pub fn run_search(&self, meshes: &MeshSource) -> Result<NestingResult> {
        let batch = self.load_batch(meshes)?;
        let instance = batch.create_instance(&self.profile)?;
        let mut config = self.profile.search.nest.clone();
        config.seed = self.seed;
        let start = batch.lowest_start(&self.starts);
        let meter = CpuMeter::begin(&self.budget, f64::INFINITY);
        let mut curve = Vec::new();
        let mut listener = |solution: &NestingSolution, _evaluations: u64| {
            curve.push((self.budget.elapsed_secs(), solution.height_mm));
            *self.best_layout.lock().unwrap_or_else(PoisonError::into_inner) =
                Some(batch.layout_from_solution(&instance, solution));
        };
        let solution = nester::nest_with_cache(&instance, &config, &start, &meshes.prepared, &meter, &mut listener);
        let layout = batch.layout_from_solution(&instance, &solution);
        *self.best_layout.lock().unwrap_or_else(PoisonError::into_inner) = Some(layout.clone());
        let lower_bound_mm =
            nester::lower_bound_mm(&batch.placed_only(&layout).create_instance(&self.profile).unwrap_or(instance));
        let (batch, wall_secs) = (batch.merge_parts(), self.budget.elapsed_secs());
        Ok(NestingResult { batch, layout, lower_bound_mm, cpu_secs: meter.spent_secs(), wall_secs, curve })
    }

    /// The parts with their meshes.
    pub(crate) fn load_batch(&self, meshes: &MeshSource) -> Result<NestingBatch> {
        let part = |(part, copies): &(PartRow, Vec<u32>)| -> Result<NestingPart> {
            let mesh = meshes.load_mesh(part)?;
            Ok(NestingPart { part: part.clone(), mesh, copies: copies.clone() })
        };
        Ok(NestingBatch { parts: self.wanted.iter().map(part).collect::<Result<_>>()? })
    }
}
