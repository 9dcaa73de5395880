//! The mesh cache: meshes of waiting parts, kept in memory while they are needed.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
};

use build_file::LengthUnit;
use solids::Mesh;

/// Key of a mesh: content of the file, index of the solid, and the unit that it is read in.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct MeshCacheKey {
    /// BLAKE3 of the file.
    pub content_hash: String,
    /// Index of the solid in the file.
    pub object_index: u32,
    /// The profile's unit, for files that do not give one.
    pub default_unit: LengthUnit,
    /// Unit given in the ticket.
    pub unit: Option<LengthUnit>,
}

/// Meshes by key; shared by all threads.
#[derive(Debug, Clone, Default)]
pub struct MeshCache(Arc<Mutex<HashMap<MeshCacheKey, Arc<Mesh>>>>);

impl MeshCache {
    /// The mesh, if it is in the cache.
    pub fn get(&self, key: &MeshCacheKey) -> Option<Arc<Mesh>> {
        self.lock_meshes().get(key).cloned()
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
