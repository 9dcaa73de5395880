//! A search: a batch of parts becomes a layout. Runs on a job's thread.

use std::sync::{Arc, Mutex, PoisonError};

use anyhow::Result;
use nester::{SearchBudget, Solution};

use super::{
    layout::{Batch, BatchPart, Layout, PlacedCopy},
    meshes::Meshes,
};
use crate::{ledger::PartRow, settings::Profile};

/// The best layout of a running search; other threads look at it and take it when the search is cancelled.
pub type Best = Arc<Mutex<Option<Layout>>>;

/// What to nest.
#[derive(Debug)]
pub struct NestOrder {
    /// The machine.
    pub profile: Arc<Profile>,
    /// Parts and the copies of them that are wanted, in order of precedence.
    pub wanted: Vec<(PartRow, Vec<u32>)>,
    /// An earlier layout to go on from.
    pub start: Vec<PlacedCopy>,
    /// How long.
    pub budget: SearchBudget,
    /// Seed of the search.
    pub seed: u64,
    /// Receives every better layout.
    pub best: Best,
}

/// What came out of it.
#[derive(Debug)]
pub struct Nested {
    /// Parts with their meshes.
    pub batch: Batch,
    /// The layout.
    pub layout: Layout,
    /// No layout of the placed copies can be lower, mm.
    pub lower_bound_mm: f64,
    /// CPU seconds of the search.
    pub cpu_secs: f64,
    /// Wall seconds of the search.
    pub wall_secs: f64,
    /// (wall seconds, build height in mm) of every improvement.
    pub curve: Vec<(f64, f64)>,
}

impl NestOrder {
    /// Nests; returns when the budget is spent or cancelled.
    pub fn run(&self, meshes: &Meshes) -> Result<Nested> {
        let batch = self.batch(meshes)?;
        let instance = batch.instance(&self.profile)?;
        let mut config = self.profile.search.nest.clone();
        config.seed = self.seed;
        let start = batch.placements(&self.start);
        let cpu = cpu_secs(config.threads);
        let mut curve = Vec::new();
        let mut listener = |solution: &Solution, _evaluations: u64| {
            curve.push((self.budget.elapsed_secs(), solution.height_mm));
            *self.best.lock().unwrap_or_else(PoisonError::into_inner) = Some(batch.layout(&instance, solution));
        };
        let solution = nester::nest_with(&instance, &config, &start, &meshes.prepared, &self.budget, &mut listener);
        let layout = batch.layout(&instance, &solution);
        *self.best.lock().unwrap_or_else(PoisonError::into_inner) = Some(layout.clone());
        let lower_bound_mm =
            nester::lower_bound_mm(&batch.placed_only(&layout).instance(&self.profile).unwrap_or(instance));
        let wall_secs = self.budget.elapsed_secs();
        Ok(Nested { batch, layout, lower_bound_mm, cpu_secs: cpu_secs(config.threads) - cpu, wall_secs, curve })
    }

    fn batch(&self, meshes: &Meshes) -> Result<Batch> {
        let part = |(part, copies): &(PartRow, Vec<u32>)| -> Result<BatchPart> {
            let mesh = meshes.mesh(&self.profile, part)?;
            Ok(BatchPart { part: part.clone(), mesh, copies: copies.clone() })
        };
        Ok(Batch { parts: self.wanted.iter().map(part).collect::<Result<_>>()? })
    }
}

/// CPU seconds so far: of this thread where it searches alone, else of the process, for then no other search runs.
fn cpu_secs(threads: usize) -> f64 {
    use rustix::time::{ClockId, clock_gettime};
    let time = clock_gettime(if threads == 1 { ClockId::ThreadCPUTime } else { ClockId::ProcessCPUTime });
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
