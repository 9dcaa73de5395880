//! Prepares the meshes of a search: takes them from memory, reads them from the cache or computes them, on several
//! threads if there are. The result does not depend on its source.

use std::{
    panic::resume_unwind,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use solids::Mesh;

use crate::{
    PreparedMeshes, StopCondition,
    shapes::{
        outline::MeshOutline,
        shape::{PreparedShape, ShapeDetail},
    },
};

/// Prepares meshes.
#[derive(Clone, Copy)]
pub(crate) struct MeshPreparation<'a> {
    prepared: &'a PreparedMeshes,
    threads: usize,
    /// The budget, and the share of it after which nothing more is prepared.
    deadline: Option<(&'a dyn StopCondition, f64)>,
}

impl<'a> MeshPreparation<'a> {
    /// A preparation that takes from `prepared`, adds to it, and uses this number of threads.
    pub(crate) fn new(prepared: &'a PreparedMeshes, threads: usize) -> Self {
        Self { prepared, threads, deadline: None }
    }

    /// Prepares nothing more once this share of a budget is used up. Data prepared until then is kept.
    pub(crate) fn with_deadline(self, stop: &'a dyn StopCondition, share: f64) -> Self {
        Self { deadline: Some((stop, share)), ..self }
    }

    fn is_over(&self) -> bool {
        self.deadline.is_some_and(|(stop, share)| stop.spent_share_at(0) >= share)
    }

    /// Outlines of meshes, in their order.
    pub(crate) fn prepare_outlines(&self, meshes: &[Arc<Mesh>]) -> Vec<Arc<MeshOutline>> {
        // Outlines are always computed: there is no layout without them.
        self.prepare_each(meshes, |mesh, _| Some(self.prepared.outline(mesh))).unwrap_or_default()
    }

    /// Shapes of meshes at a detail, in the order of the meshes; `None` when the time runs out first.
    pub(crate) fn prepare_shapes(&self, meshes: &[Arc<Mesh>], detail: ShapeDetail) -> Option<Vec<Arc<PreparedShape>>> {
        self.prepare_each(meshes, |mesh, threads| self.prepared.shape(mesh, detail, threads, &|| self.is_over()))
    }

    /// Runs `work` on every distinct mesh, on whichever thread is free; `None` when any of them failed. `work` may use as
    /// many threads as it is told: where there are fewer meshes than threads, one mesh takes several.
    fn prepare_each<T: Send + Sync>(
        &self,
        meshes: &[Arc<Mesh>],
        work: impl Fn(&Arc<Mesh>, usize) -> Option<Arc<T>> + Sync,
    ) -> Option<Vec<Arc<T>>> {
        let mut distinct: Vec<&Arc<Mesh>> = meshes.iter().collect();
        distinct.sort_by_key(|mesh| Arc::as_ptr(mesh));
        distinct.dedup_by_key(|mesh| Arc::as_ptr(mesh));
        // Large meshes first, so that no thread is left with a large one at the end.
        distinct.sort_by_key(|mesh| std::cmp::Reverse(mesh.triangles().len()));
        let threads_each = (self.threads / distinct.len().max(1)).max(1);
        let next = AtomicUsize::new(0);
        let prepare_meshes = || {
            let mut done: Vec<(usize, Arc<T>)> = Vec::new();
            while let Some(mesh) = distinct.get(next.fetch_add(1, Ordering::Relaxed)) {
                done.push((Arc::as_ptr(mesh) as usize, work(mesh, threads_each)?));
            }
            Some(done)
        };
        let threads = self.threads.min(distinct.len());
        let mut made = if threads <= 1 {
            prepare_meshes()?
        } else {
            thread::scope(|scope| {
                let handles: Vec<_> = (0..threads).map(|_| scope.spawn(prepare_meshes)).collect();
                let join = |handle: thread::ScopedJoinHandle<'_, _>| handle.join().unwrap_or_else(|p| resume_unwind(p));
                let made: Option<Vec<_>> = handles.into_iter().map(join).collect();
                Some(made?.into_iter().flatten().collect::<Vec<_>>())
            })?
        };
        made.sort_by_key(|(mesh, _)| *mesh);
        let find = |mesh: &Arc<Mesh>| made.binary_search_by_key(&(Arc::as_ptr(mesh) as usize), |(known, _)| *known);
        Some(meshes.iter().map(|mesh| made[find(mesh).expect("every mesh was worked on")].1.clone()).collect())
    }
}
