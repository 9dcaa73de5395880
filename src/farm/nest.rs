//! The step "nested": a batch of parts becomes a layout. Runs on a job's thread; meshes come from the shelf or are read
//! again from the store.

use std::{
    collections::HashMap,
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use anyhow::{Context, Result};

use super::{
    alone::Errand,
    budget::Budget,
    cache::DiskCache,
    layout::{Batch, BatchPart, Layout, PlacedCopy},
    read::Unread,
    shelf::{MeshKey, Shelf},
};
use crate::{
    format::{Contents, Limits, Unit},
    geometry::Mesh,
    intake::{Store, StoreError},
    ledger::PartRow,
    nest::{self, Cache, Solution},
    settings::Profile,
};

/// Reading a file is tried so often in the daemon; the attempts after these are made alone.
pub const READS_IN_THE_DAEMON: u32 = 2;

/// Where meshes come from.
#[derive(Debug, Clone)]
pub struct Meshes {
    /// Meshes in memory.
    pub shelf: Shelf,
    /// The content-addressed store.
    pub store: Store,
    /// Limits of the readers.
    pub limits: Limits,
    /// Work on meshes, kept on disk; `None` = it is done anew after each start.
    pub cache: Option<Arc<DiskCache>>,
    /// Since when stored files cannot be read, by content.
    pub unreadable: Arc<Mutex<HashMap<String, Instant>>>,
}

/// A stored file that cannot be read for so long is taken for damaged; a cable or a share fails in passing.
const UNREADABLE_FOR: Duration = Duration::from_secs(60);

/// The stored file of a part does not hold what was dropped: only the same file, dropped again, helps.
#[derive(Debug, thiserror::Error)]
#[error(
    "the stored file of {name} {}",
    aside.as_ref().map_or("is not there".to_owned(), |aside| format!("was damaged and is set aside as {}", aside.display()))
)]
pub struct Lost {
    /// Name of the part.
    pub name: String,
    /// Whose bytes are lost.
    pub content_hash: String,
    /// Where the damaged file is now; `None` = there was none.
    pub aside: Option<PathBuf>,
}

impl Lost {
    /// The lost file that a failure is about.
    pub fn of(failure: &anyhow::Error) -> Option<&Self> {
        failure.chain().find_map(|cause| cause.downcast_ref())
    }
}

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
    pub budget: Budget,
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

impl Meshes {
    fn cache(&self) -> Option<&dyn Cache> {
        self.cache.as_deref().map(|cache| cache as &dyn Cache)
    }

    /// The stored file of a part, compared with what was dropped. What is damaged is set aside.
    pub fn stored(&self, part: &PartRow) -> Result<PathBuf> {
        let hash = &part.content_hash;
        let verified = self.store.verify(hash);
        let is_unreadable = verified.as_ref().is_err_and(StoreError::is_unreadable);
        let is_lasting = self.is_lasting(hash, is_unreadable);
        match verified {
            Ok(()) => Ok(self.store.path(hash)?),
            Err(error) if error.is_lost() || is_lasting => {
                let aside = self.store.set_damaged_aside(hash)?;
                Err(Lost { name: part.name.clone(), content_hash: hash.clone(), aside }.into())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Whether a stored file has not been readable for long.
    fn is_lasting(&self, hash: &str, is_unreadable: bool) -> bool {
        let mut unreadable = self.unreadable.lock().unwrap_or_else(PoisonError::into_inner);
        if !is_unreadable {
            unreadable.remove(hash);
            return false;
        }
        unreadable.entry(hash.to_owned()).or_insert_with(Instant::now).elapsed() >= UNREADABLE_FOR
    }

    /// What a part's file holds; one whose reading has ended the process before is read in a process of its own.
    pub fn contents(&self, file: PathBuf, part: &PartRow, default_unit: Unit) -> Result<Contents, Unread> {
        let (name, unit, limits) = (part.name.clone(), part.unit, self.limits.clone());
        let errand = Errand { file, name, unit, default_unit, limits };
        if part.reads > READS_IN_THE_DAEMON { errand.read_alone() } else { errand.read() }
    }

    /// The mesh of a part, from the shelf or from the store.
    pub fn mesh(&self, profile: &Profile, part: &PartRow) -> Result<Arc<Mesh>> {
        let key = |object_index| MeshKey {
            content_hash: part.content_hash.clone(),
            object_index,
            default_unit: profile.unit,
            unit: part.unit,
        };
        if let Some(mesh) = self.shelf.mesh(&key(part.object_index)) {
            return Ok(mesh);
        }
        let file = self.stored(part)?;
        let contents = (self.contents(file, part, profile.unit))
            .with_context(|| format!("reading part {} ({}) again", part.id.0, part.name))?;
        for (index, solid) in contents.solids.into_iter().enumerate() {
            self.shelf.put(key(index as u32), solid.mesh);
        }
        self.shelf
            .mesh(&key(part.object_index))
            .with_context(|| format!("part {} ({}) has no solid {}", part.id.0, part.name, part.object_index))
    }
}

impl NestOrder {
    /// Nests; returns when the budget is spent or cancelled.
    pub fn run(&self, meshes: &Meshes) -> Result<Nested> {
        let batch = self.batch(meshes)?;
        let instance = batch.instance(&self.profile)?;
        let mut config = self.profile.nest.clone();
        config.seed = self.seed;
        let start = batch.placements(&self.start);
        let cpu = cpu_secs(config.threads);
        let mut curve = Vec::new();
        let mut listener = |solution: &Solution, _evaluations: u64| {
            curve.push((self.budget.elapsed_secs(), solution.height_mm));
            *self.best.lock().unwrap_or_else(PoisonError::into_inner) = Some(batch.layout(&instance, solution));
        };
        let solution = nest::nest_with(&instance, &config, &start, meshes.cache(), &self.budget, &mut listener);
        let layout = batch.layout(&instance, &solution);
        *self.best.lock().unwrap_or_else(PoisonError::into_inner) = Some(layout.clone());
        let lower_bound_mm =
            nest::lower_bound_mm(&batch.placed_only(&layout).instance(&self.profile).unwrap_or(instance));
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
