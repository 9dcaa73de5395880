//! Prepared data of meshes, kept for more than one search: an open build uses the same meshes again and again. The
//! caller of the search owns this data; there is no global state.

use std::{
    fmt,
    sync::{Arc, Mutex, PoisonError, Weak},
};

use solids::{ClearanceTree, Mesh};

use crate::shapes::{
    cache::{self, PreparedMeshCache},
    outline::MeshOutline,
    shape::{PreparedShape, ShapeDetail},
};

/// Greatest number of shapes kept in memory per mesh: a coarse one, a fine one, and one for a changed clearance.
const MAX_SHAPES: usize = 3;

/// Prepared meshes: their smallest boxes, distance trees and distance grids. Pass the same value to several searches,
/// and each mesh that they share (the same `Arc`) is prepared only once. Clones share the data in memory, and several
/// threads may use it at the same time. A search limited by evaluations gives the same result with and without it. A
/// search limited by time spends less of its time on preparation.
///
/// The data of a mesh is dropped when no one else holds the mesh any more. With a [`PreparedMeshCache`] the data also
/// survives the end of the process.
///
/// ```
/// use std::sync::Arc;
/// use nester::{BuildVolume, NestingConfig, NestingInstance, NestingItem, OrientationRule, PreparedMeshes, SearchBudget, nest_with_cache};
/// use solids::Mesh;
///
/// let ring = Arc::new(Mesh::tube(30.0, 20.0, 6.0)?);
/// let volume = BuildVolume { size_mm: glam::DVec3::splat(80.0) };
/// let prepared = PreparedMeshes::default();
/// for copies in [2, 4] {
///     let item = NestingItem::new("ring", ring.clone(), copies).with_orientation(OrientationRule::Upright);
///     let instance = NestingInstance::new(volume, 2.0, vec![item])?;
///     let budget = SearchBudget::of_evaluations(200);
///     let solution = nest_with_cache(&instance, &NestingConfig::default(), &[], &prepared, &budget, &mut ());
///     assert_eq!(solution.placements.len(), copies as usize);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Default)]
pub struct PreparedMeshes {
    known: Arc<Mutex<Vec<PreparationMemo>>>,
    cache: Option<Arc<dyn PreparedMeshCache + Send>>,
}

/// The data of one mesh that is kept in memory.
#[derive(Default)]
struct PreparationMemo {
    mesh: Weak<Mesh>,
    /// The mesh's content hash, computed on first use.
    name: Option<Arc<str>>,
    outline: Option<Arc<MeshOutline>>,
    tree: Option<Arc<ClearanceTree>>,
    shapes: Vec<(ShapeDetail, Arc<PreparedShape>)>,
}

impl PreparedMeshes {
    /// The same prepared meshes in memory. From now on the data is also stored in this cache and read from it. `None`
    /// = no cache.
    #[must_use]
    pub fn with_cache(self, cache: Option<Arc<dyn PreparedMeshCache + Send>>) -> Self {
        Self { cache, ..self }
    }

    /// Number of meshes in memory.
    pub fn len(&self) -> usize {
        self.known.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// Whether no mesh is in memory.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The outline of a mesh: taken from memory, read from the cache, or computed.
    pub(crate) fn outline(&self, mesh: &Arc<Mesh>) -> Arc<MeshOutline> {
        if let Some(known) = self.with_memo(mesh, |memo| memo.outline.clone()) {
            return known;
        }
        let key = self.cache().map(|cache| (cache, cache::cache_key("outline", &self.name_of(mesh))));
        let kept = key.as_ref().and_then(|(cache, key)| cache::unpack_outline(&cache.fetch_bytes(key)?));
        let is_kept = kept.is_some();
        let outline = Arc::new(kept.unwrap_or_else(|| MeshOutline::new(mesh)));
        if let (Some((cache, key)), false) = (key, is_kept) {
            cache.store_bytes(&key, &cache::pack_outline(&outline));
        }
        self.with_memo(mesh, |memo| memo.outline.get_or_insert(outline).clone())
    }

    /// The shape of a mesh at a level of detail, prepared on at most `threads` threads; `None` if it is not known and the
    /// search ends before it is prepared.
    pub(crate) fn shape(
        &self,
        mesh: &Arc<Mesh>,
        detail: ShapeDetail,
        threads: usize,
        is_over: &dyn Fn() -> bool,
    ) -> Option<Arc<PreparedShape>> {
        // Use exactly this detail: a finer one in memory would make a build depend on earlier builds.
        let known = |memo: &mut PreparationMemo| {
            memo.shapes.iter().find(|(of, _)| *of == detail).map(|(_, shape)| shape.clone())
        };
        if let Some(known) = self.with_memo(mesh, known) {
            return Some(known);
        }
        if is_over() {
            return None;
        }
        let outline = self.outline(mesh);
        let tree = self.with_memo(mesh, |memo| memo.tree.clone()).unwrap_or_else(|| {
            let tree = Arc::new(ClearanceTree::with_obb(mesh.clone(), outline.obb, threads));
            self.with_memo(mesh, |memo| memo.tree.get_or_insert(tree).clone())
        });
        let name = self.cache().map(|_| self.name_of(mesh));
        let kept = self.cache().zip(name.as_deref());
        let shape = Arc::new(PreparedShape::new(tree, &outline, detail, kept, is_over)?);
        self.with_memo(mesh, |memo| {
            memo.shapes.push((detail, shape.clone()));
            let too_many = memo.shapes.len().saturating_sub(MAX_SHAPES);
            memo.shapes.drain(..too_many);
        });
        Some(shape)
    }

    fn cache(&self) -> Option<&dyn PreparedMeshCache> {
        self.cache.as_deref().map(|cache| cache as &dyn PreparedMeshCache)
    }

    fn name_of(&self, mesh: &Arc<Mesh>) -> Arc<str> {
        let known = self.with_memo(mesh, |memo| memo.name.clone());
        known.unwrap_or_else(|| {
            let name: Arc<str> = cache::mesh_content_hash(mesh).into();
            self.with_memo(mesh, |memo| memo.name.get_or_insert(name).clone())
        })
    }

    /// Reads or changes the data that is kept in memory for a mesh.
    fn with_memo<T>(&self, mesh: &Arc<Mesh>, read_memo: impl FnOnce(&mut PreparationMemo) -> T) -> T {
        let mut memos = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = memos.iter().position(|memo| std::ptr::eq(memo.mesh.as_ptr(), Arc::as_ptr(mesh))) {
            return read_memo(&mut memos[at]);
        }
        // The tree itself holds a reference to its mesh. A further reference means that the mesh is still in use.
        memos.retain(|memo| memo.mesh.strong_count() > usize::from(memo.tree.is_some()));
        memos.push(PreparationMemo { mesh: Arc::downgrade(mesh), ..PreparationMemo::default() });
        let at = memos.len() - 1;
        read_memo(&mut memos[at])
    }
}

impl fmt::Debug for PreparedMeshes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PreparedMeshes").field("meshes", &self.len()).field("cached", &self.cache.is_some()).finish()
    }
}
