//! Inserts quoted parts into a copy of the open build's layout, within a time limit. The farm's own layout stays as it is.

use std::{
    collections::{BTreeSet, HashMap},
    sync::{Arc, mpsc},
    thread,
    time::{Duration, Instant},
};

use anyhow::{Result, ensure};
use build_file::ReadLimits;
use intake::ContentStore;
use ledger::{PartId, PartRow, WaitingPart};
use nester::{PreparedMeshCache, PreparedMeshes};
use settings::{MachineProfile, Settings};
use solids::Mesh;
use tracing::debug;

use super::quoted_part::QuotedPart;
use crate::{
    decisions::layout::{LayoutPlacement, NestingBatch, NestingPart},
    files::{disk_cache::DiskCacheReader, isolated_read::READS_IN_THE_DAEMON, mesh_cache::MeshCache},
    nesting::{layout_search::LayoutSearch, search_policy::SearchPolicy},
};

/// The meshes of waiting parts, for quotes.
#[derive(Debug, Clone)]
pub struct QuoteMeshes {
    meshes: MeshCache,
    prepared: PreparedMeshes,
    store: ContentStore,
    limits: ReadLimits,
}

/// What is inserted where.
#[derive(Debug)]
pub struct QuoteInsertion {
    /// The machine.
    pub profile: Arc<MachineProfile>,
    /// The waiting parts.
    pub waiting: Vec<WaitingPart>,
    /// The layout of the open build.
    pub placed: Vec<LayoutPlacement>,
    /// The parts that are quoted.
    pub parts: Vec<QuotedPart>,
}

impl QuoteMeshes {
    /// Reads from the folders of a farm, and writes nothing there.
    pub fn of_farm(settings: &Settings) -> Self {
        let cache =
            DiskCacheReader::of_farm(settings).map(|cache| Arc::new(cache) as Arc<dyn PreparedMeshCache + Send>);
        Self {
            meshes: MeshCache::default(),
            prepared: PreparedMeshes::default().with_cache(cache),
            store: ContentStore::from_dir(settings.state_dir.join("store")),
            limits: settings.limits.clone(),
        }
    }

    /// Forgets the meshes of all parts but these.
    pub fn keep_only(&self, waiting: &[WaitingPart]) {
        let needed: BTreeSet<&str> = waiting.iter().map(|line| line.part.file.content_hash.as_str()).collect();
        self.meshes.retain(|key| needed.contains(key.content_hash.as_str()));
    }

    /// The mesh of a waiting part.
    fn load_mesh(&self, part: &PartRow) -> Result<Arc<Mesh>> {
        if let Some(mesh) = self.meshes.find_mesh(part) {
            return Ok(mesh);
        }
        ensure!(part.file.reads <= READS_IN_THE_DAEMON, "reading part {} has ended nestd before", part.id);
        self.meshes.read_mesh(&self.store.file_path(&part.file.content_hash)?, part, &self.limits)
    }
}

impl QuoteInsertion {
    /// The height of the layout with the quoted parts, mm; `None` = they found no place in it, or not in this time. `busy` is
    /// dropped when the work has ended, which may be later.
    pub fn find_height_mm(self, meshes: &QuoteMeshes, within: Duration, busy: impl Send + 'static) -> Option<f64> {
        let (meshes, began, (done, found)) = (meshes.clone(), Instant::now(), mpsc::channel());
        let work = move || {
            let _busy = busy;
            let until = began + within;
            let policy = SearchPolicy::Quote { until };
            policy.lower_priority();
            let height_mm =
                self.load_batch(&meshes, until).and_then(|batch| self.insert_quoted(batch, policy, &meshes));
            meshes.keep_only(&self.waiting);
            // Nobody waits for it any more, if it took too long.
            let _ = done.send(height_mm);
        };
        thread::Builder::new().name("quote".to_owned()).spawn(work).ok()?;
        match found.recv_timeout(within).ok()? {
            Ok(height_mm) => height_mm,
            Err(failure) => {
                debug!("A quote goes by an estimate: {failure:#}.");
                None
            }
        }
    }

    fn insert_quoted(&self, batch: NestingBatch, policy: SearchPolicy, meshes: &QuoteMeshes) -> Result<Option<f64>> {
        let search = LayoutSearch::begin(policy);
        let layout = search.run(&self.profile, batch, std::slice::from_ref(&self.placed), &meshes.prepared)?.layout;
        Ok((layout.unplaced.is_empty() && !layout.placed.is_empty()).then_some(layout.height_mm))
    }

    /// The copies that stand in the open build, and those that are quoted.
    fn load_batch(&self, meshes: &QuoteMeshes, until: Instant) -> Result<NestingBatch> {
        let mut standing: HashMap<PartId, Vec<u32>> = HashMap::new();
        for LayoutPlacement { copy: (part, copy), .. } in &self.placed {
            standing.entry(*part).or_default().push(*copy);
        }
        let mut parts = Vec::with_capacity(standing.len() + self.parts.len());
        for line in &self.waiting {
            let Some(copies) = standing.remove(&line.part.id) else { continue };
            ensure!(Instant::now() < until, "its time was up while meshes were read");
            let mesh = meshes.load_mesh(&line.part)?;
            parts.push(NestingPart { part: line.part.clone(), mesh, copies });
        }
        let quoted = self.parts.iter().map(|QuotedPart { row, mesh }| NestingPart {
            part: (**row).clone(),
            mesh: mesh.clone(),
            copies: (0..row.owed.copies).collect(),
        });
        parts.extend(quoted);
        Ok(NestingBatch { parts })
    }
}
