//! Source of the meshes of parts: memory, or else the content-addressed store.

use std::{
    collections::HashMap,
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use anyhow::Result;
use build_file::ReadLimits;
use intake::{ContentStore, StoreError};
use ledger::PartRow;
use nester::PreparedMeshes;
use solids::Mesh;

use super::{
    disk_cache::DiskPreparationCache,
    judged_file::JudgedFiles,
    mesh_cache::{MeshCache, MeshCacheKey},
};
use crate::alerts::failure::LostFileError;

/// Source of meshes.
#[derive(Debug, Clone)]
pub struct MeshSource {
    /// Meshes in memory.
    pub mesh_cache: MeshCache,
    /// The content-addressed store.
    pub store: ContentStore,
    /// Limits of the readers.
    pub limits: ReadLimits,
    /// Work on meshes: in memory as long as they are on the shelf, and on disk where there is room for it.
    pub prepared: PreparedMeshes,
    /// The disk cache that `prepared` uses.
    pub preparation_cache: Option<Arc<DiskPreparationCache>>,
    /// What was read of files when their orders were taken.
    pub judged: JudgedFiles,
    /// Since when stored files have not been readable, by content.
    pub unreadable_since: Arc<Mutex<HashMap<String, Instant>>>,
}

/// A stored file that cannot be read for this long counts as damaged; cables and shares fail for shorter times.
const UNREADABLE_FOR: Duration = Duration::from_secs(60);

impl MeshSource {
    /// The path of a part's stored file, after comparing it with what was dropped. A damaged file is set aside.
    pub fn verified_file(&self, part: &PartRow) -> Result<PathBuf> {
        let hash = &part.file.content_hash;
        let verified = self.store.verify_hash(hash);
        let is_unreadable = verified.as_ref().is_err_and(StoreError::is_unreadable);
        let is_lasting = self.is_persistently_unreadable(hash, is_unreadable);
        match verified {
            Ok(()) => Ok(self.store.file_path(hash)?),
            Err(error) if error.is_lost() || is_lasting => {
                let aside = self.store.move_damaged_aside(hash)?;
                Err(LostFileError { name: part.name.clone(), content_hash: hash.clone(), aside }.into())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Whether a stored file has not been readable for a long time.
    fn is_persistently_unreadable(&self, hash: &str, is_unreadable: bool) -> bool {
        let mut unreadable = self.unreadable_since.lock().unwrap_or_else(PoisonError::into_inner);
        if !is_unreadable {
            unreadable.remove(hash);
            return false;
        }
        unreadable.entry(hash.to_owned()).or_insert_with(Instant::now).elapsed() >= UNREADABLE_FOR
    }

    /// Whether the stored file of a part is there, with the bytes that were dropped.
    pub fn has_file(&self, part: &PartRow) -> bool {
        self.store.verify_hash(&part.file.content_hash).is_ok()
    }

    /// Keeps a mesh of a part in memory.
    pub fn insert_mesh(&self, part: &PartRow, mesh: Mesh) {
        self.mesh_cache.insert(MeshCacheKey::of_solid(part, part.solid.object_index), Arc::new(mesh));
    }

    /// The mesh of a part, from memory or from the store, in the size in which it was read first.
    pub fn load_mesh(&self, part: &PartRow) -> Result<Arc<Mesh>> {
        if let Some(mesh) = self.mesh_cache.find_mesh(part) {
            return Ok(mesh);
        }
        let file = self.verified_file(part)?;
        self.mesh_cache.read_mesh(&file, part, &self.limits)
    }
}
