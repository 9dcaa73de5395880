//! The driver of all searches: turns a batch of parts into a layout, as the search's policy says. Runs on a job's thread.

use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError},
};

use anyhow::Result;
use ledger::PartRow;
use nester::{HeightCurve, NestingSolution, PreparedMeshes, SearchBudget, SearchEnd};
use settings::MachineProfile;

use super::search_policy::{SearchPolicy, SearchProblem};
use crate::{
    decisions::layout::{BatchLayout, LayoutPlacement, NestingBatch, NestingPart},
    files::mesh_source::MeshSource,
    process::cpu_meter::CpuMeter,
};

/// A search, from its begin on. Clones of it are the same search: by each it is stopped, and each tells its best layout so far.
#[derive(Debug, Clone)]
pub struct LayoutSearch {
    /// What it is for.
    pub policy: SearchPolicy,
    budget: SearchBudget,
    best: Arc<Mutex<Option<BatchLayout>>>,
}

/// A request to nest parts.
#[derive(Debug)]
pub struct NestingRequest {
    /// The machine.
    pub profile: Arc<MachineProfile>,
    /// Parts with their wanted copies, in order of precedence; a part may be there twice.
    pub wanted: Vec<(PartRow, Vec<u32>)>,
    /// Earlier layouts, to begin from.
    pub starts: Vec<Vec<LayoutPlacement>>,
    /// The search.
    pub search: LayoutSearch,
}

/// The result of a search.
#[derive(Debug)]
pub struct NestingResult {
    /// Parts with their meshes.
    pub batch: NestingBatch,
    /// The layout.
    pub layout: BatchLayout,
    /// Different layouts of the same copies to go on from, the lowest first; empty where nothing goes on.
    pub pool: Vec<Vec<LayoutPlacement>>,
    /// Lower bound on the height of any layout of the placed copies, mm; 0 where the search was not the last one.
    pub lower_bound_mm: f64,
    /// CPU seconds of the search.
    pub cpu_secs: f64,
    /// Wall seconds of the search.
    pub wall_secs: f64,
    /// (wall seconds, build height in mm) of every improvement.
    pub curve: Vec<(f64, f64)>,
    /// Why it ended.
    pub end: SearchEnd,
}

/// The search of a fired build was stopped before its time was over: what it found is no build yet, and is kept to go on from.
#[derive(Debug, thiserror::Error)]
#[error("its search was stopped after {wall_secs:.0} s, and goes on from what it has found")]
pub(crate) struct SearchCutShort {
    /// The best layout so far, if there is one yet.
    pub(crate) layout: Option<BatchLayout>,
    /// CPU seconds of the search, where it told them.
    pub(crate) cpu_secs: f64,
    /// Wall seconds of the search.
    pub(crate) wall_secs: f64,
}

impl LayoutSearch {
    /// Begins a search: its time runs.
    pub(crate) fn begin(policy: SearchPolicy) -> Self {
        Self { policy, budget: policy.begin_budget(), best: Arc::default() }
    }

    /// Whether both are the same search.
    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.best, &other.best)
    }

    /// Stops it soon; it still has a result.
    pub(crate) fn stop(&self) {
        self.budget.cancel();
    }

    /// Whether it was stopped.
    pub(crate) fn is_stopped(&self) -> bool {
        self.budget.is_cancelled()
    }

    /// Whether it was stopped and had time left.
    pub(crate) fn is_cut_short(&self) -> bool {
        self.is_stopped() && self.budget.secs_left() != Some(0.0)
    }

    /// What is kept of it where the daemon does not wait for its end. Once its time is over, all of that was used.
    pub(crate) fn cut_short(&self) -> SearchCutShort {
        let wall_secs = self.budget.elapsed_secs() - self.secs_over();
        SearchCutShort { layout: self.best_layout(), cpu_secs: 0.0, wall_secs }
    }

    /// Seconds since its time was over; 0 before.
    pub(crate) fn secs_over(&self) -> f64 {
        self.budget.secs_over()
    }

    /// The best layout so far.
    pub(crate) fn best_layout(&self) -> Option<BatchLayout> {
        self.best.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Searches on this thread; returns when the time is over or the search was stopped.
    pub(crate) fn run(
        &self,
        profile: &MachineProfile,
        batch: NestingBatch,
        starts: &[Vec<LayoutPlacement>],
        prepared: &PreparedMeshes,
    ) -> Result<NestingResult> {
        let instance = batch.create_instance(profile)?;
        let config = self.policy.config(&profile.search.nest);
        let meter = CpuMeter::begin(&self.budget, self.policy.limit_cpu_secs());
        let mut curve = HeightCurve::default();
        let keep = |layout: BatchLayout| *self.best.lock().unwrap_or_else(PoisonError::into_inner) = Some(layout);
        let mut listener = |solution: &NestingSolution, _evaluations: u64| {
            if curve.add(solution, self.budget.elapsed_secs()) {
                self.budget.record_gain();
            }
            keep(batch.layout_from_solution(&instance, solution));
        };
        let problem = SearchProblem { batch: &batch, instance: &instance, config: &config, starts, prepared };
        let (solution, pool) = self.policy.search(&problem, &meter, &mut listener);
        let layout = batch.layout_from_solution(&instance, &solution);
        keep(layout.clone());
        let pool = pool.iter().map(|placements| batch.layout_placements(placements)).collect();
        let lower_bound_mm = match self.policy {
            SearchPolicy::Final { .. } => {
                let placed = batch.placed_only(&layout).create_instance(profile);
                nester::lower_bound_mm(&placed.unwrap_or(instance))
            }
            _ => 0.0,
        };
        let end = self.budget.why_ended(solution.is_lowest(lower_bound_mm));
        let (batch, cpu_secs, wall_secs) = (batch.merge_parts(), meter.spent_secs(), self.budget.elapsed_secs());
        Ok(NestingResult { batch, layout, pool, lower_bound_mm, cpu_secs, wall_secs, curve: curve.points, end })
    }
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
    /// Runs the search.
    pub fn run_search(&self, meshes: &MeshSource) -> Result<NestingResult> {
        self.search.run(&self.profile, self.load_batch(meshes)?, &self.starts, &meshes.prepared)
    }

    /// The parts with their meshes.
    fn load_batch(&self, meshes: &MeshSource) -> Result<NestingBatch> {
        let part = |(part, copies): &(PartRow, Vec<u32>)| -> Result<NestingPart> {
            let mesh = meshes.load_mesh(part)?;
            Ok(NestingPart { part: part.clone(), mesh, copies: copies.clone() })
        };
        Ok(NestingBatch { parts: self.wanted.iter().map(part).collect::<Result<_>>()? })
    }
}
