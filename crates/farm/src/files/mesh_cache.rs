//! The mesh cache: meshes of waiting parts, kept in memory while they are needed.

use std::{
    collections::HashMap,
    path::Path,
    sync::{Arc, Mutex, PoisonError},
};

use anyhow::{Context, Result};
use build_file::{LengthUnit, ReadLimits};
use ledger::PartRow;
use solids::Mesh;

use super::mending::mend_as_recorded;
use super::read_again::{ensure_same_size, read_in_fixed_unit};

/// Key of a mesh: content of the file, index of the solid, and the unit that it is read in.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct MeshCacheKey {
    /// BLAKE3 of the file.
    pub content_hash: String,
    /// Index of the solid in the file.
    pub object_index: u32,
    /// The unit of a file that states none, of the part's row; `None` = an earlier nestd read it.
    pub read_unit: Option<LengthUnit>,
    /// Unit given in the ticket.
    pub unit: Option<LengthUnit>,
    /// BLAKE3 of the mesh where it was mended; "" = it is as it was dropped.
    pub mended_hash: String,
}

impl MeshCacheKey {
    /// The key of a solid of a part's file.
    pub fn of_solid(part: &PartRow, object_index: u32) -> Self {
        Self {
            content_hash: part.file.content_hash.clone(),
            object_index,
            read_unit: part.measures.read_unit,
            unit: part.terms.unit,
            mended_hash: part.mending.mended_hash.clone(),
        }
    }
}

/// Meshes by key; shared by all threads.
#[derive(Debug, Clone, Default)]
pub struct MeshCache(Arc<Mutex<HashMap<MeshCacheKey, Arc<Mesh>>>>);

impl MeshCache {
    /// The mesh, if it is in the cache.
    pub fn get(&self, key: &MeshCacheKey) -> Option<Arc<Mesh>> {
        self.lock_meshes().get(key).cloned()
    }

    /// The mesh of a part, if it is in the cache, in the size in which it was read first.
    pub fn find_mesh(&self, part: &PartRow) -> Option<Arc<Mesh>> {
        let mesh = self.get(&MeshCacheKey::of_solid(part, part.solid.object_index))?;
        ensure_same_size(part, &mesh).is_ok().then_some(mesh)
    }

    /// Reads the file of a part again, keeps the meshes in it, and returns the one of the part.
    ///
    /// # Errors
    /// It cannot be read, or the part has another size than when it was first read, or is mended otherwise.
    pub fn read_mesh(&self, file: &Path, part: &PartRow, limits: &ReadLimits) -> Result<Arc<Mesh>> {
        let again = || format!("reading part {} ({}) again", part.id.0, part.name);
        let (_, contents) = read_in_fixed_unit(file, part, LengthUnit::default(), limits).with_context(again)?;
        let at = part.solid.object_index;
        let mesh = contents.solids.get(at as usize).map(|solid| solid.mesh.clone());
        let mesh = mesh.with_context(|| format!("part {} ({}) has no solid {at}", part.id.0, part.name))?;
        let mesh = mend_as_recorded(part, mesh).with_context(again)?;
        ensure_same_size(part, &mesh).with_context(again)?;
        if !part.mending.mended_hash.is_empty() {
            // What was done to the others stands in their rows.
            return Ok(self.insert(MeshCacheKey::of_solid(part, at), mesh));
        }
        for (index, solid) in contents.solids.into_iter().enumerate() {
            self.insert(MeshCacheKey::of_solid(part, index as u32), solid.mesh);
        }
        Ok(mesh)
    }

    /// Inserts a mesh and returns the cached one (an equal one may be in the cache already).
    pub fn insert(&self, key: MeshCacheKey, mesh: Arc<Mesh>) -> Arc<Mesh> {
        self.lock_meshes().entry(key).or_insert(mesh).clone()
    }

    /// Keeps only the meshes that are still needed.
    pub fn retain(&self, needed: impl Fn(&MeshCacheKey) -> bool) {
        self.lock_meshes().retain(|key, _| needed(key));
    }

    fn lock_meshes(&self) -> std::sync::MutexGuard<'_, HashMap<MeshCacheKey, Arc<Mesh>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
