//! The shelf: meshes of waiting parts, kept in memory while they are needed.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
};

use build_file::Unit;
use solids::Mesh;

/// What makes a mesh: the file's content, which solid of it, and the unit it is read in.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct MeshKey {
    /// BLAKE3 of the file.
    pub content_hash: String,
    /// Which solid of the file.
    pub object_index: u32,
    /// The profile's unit for files that do not say theirs.
    pub default_unit: Unit,
    /// The unit that the ticket says.
    pub unit: Option<Unit>,
}

/// Meshes by what they were read from; shared by all threads.
#[derive(Debug, Clone, Default)]
pub struct Shelf(Arc<Mutex<HashMap<MeshKey, Arc<Mesh>>>>);

impl Shelf {
    /// The mesh, if it is on the shelf.
    pub fn mesh(&self, key: &MeshKey) -> Option<Arc<Mesh>> {
        self.lock().get(key).cloned()
    }

    /// Puts a mesh on the shelf and gives back the one that stands there now (an equal one may be there already).
    pub fn put(&self, key: MeshKey, mesh: Mesh) -> Arc<Mesh> {
        self.lock().entry(key).or_insert_with(|| Arc::new(mesh)).clone()
    }

    /// Keeps only the meshes that are still needed.
    pub fn keep(&self, needed: impl Fn(&MeshKey) -> bool) {
        self.lock().retain(|key, _| needed(key));
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<MeshKey, Arc<Mesh>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
