//! Prepares the meshes of a search: from what is in memory, from what was kept on disk, or anew; on several threads where there
//! are. What comes out is the same whichever way it came.

use std::{
    panic::resume_unwind,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use solids::Mesh;

use super::{
    PreparedMeshes, Stop,
    outline::Outline,
    shape::{Detail, Shape},
};

/// Where meshes are prepared.
#[derive(Clone, Copy)]
pub(crate) struct Workshop<'a> {
    prepared: &'a PreparedMeshes,
    threads: usize,
    /// Whose time it is, and the share of it after which nothing more is prepared.
    patience: Option<(&'a dyn Stop, f64)>,
}

impl<'a> Workshop<'a> {
    /// A workshop that takes from `prepared`, adds to it, and works on so many threads; 0 = one per core.
    pub(crate) fn new(prepared: &'a PreparedMeshes, threads: usize) -> Self {
        let cores = || thread::available_parallelism().map_or(1, usize::from);
        Self { prepared, threads: if threads == 0 { cores() } else { threads }, patience: None }
    }

    /// The same, which prepares nothing more once this share of a budget is used up. What was prepared until then is kept.
    pub(crate) fn until(self, stop: &'a dyn Stop, share: f64) -> Self {
        Self { patience: Some((stop, share)), ..self }
    }

    fn is_over(&self) -> bool {
        self.patience.is_some_and(|(stop, share)| stop.spent(0) >= share)
    }

    /// Outlines of meshes, in their order.
    pub(crate) fn outlines(&self, meshes: &[Arc<Mesh>]) -> Vec<Arc<Outline>> {
        // Without them there is no layout at all: they are always worked out.
        self.each(meshes, |mesh| Some(self.prepared.outline(mesh))).unwrap_or_default()
    }

    /// Shapes of meshes at a detail, in the order of the meshes; `None` when the time is over before.
    pub(crate) fn shapes(&self, meshes: &[Arc<Mesh>], detail: Detail) -> Option<Vec<Arc<Shape>>> {
        self.each(meshes, |mesh| self.prepared.shape(mesh, detail, &|| self.is_over()))
    }

    /// Does the same work on every distinct mesh, each on whichever thread is free; `None` when any was not done.
    fn each<T: Send + Sync>(
        &self,
        meshes: &[Arc<Mesh>],
        work: impl Fn(&Arc<Mesh>) -> Option<Arc<T>> + Sync,
    ) -> Option<Vec<Arc<T>>> {
        let mut distinct: Vec<&Arc<Mesh>> = meshes.iter().collect();
        distinct.sort_by_key(|mesh| Arc::as_ptr(mesh));
        distinct.dedup_by_key(|mesh| Arc::as_ptr(mesh));
        // Large ones first, so that no thread is left alone with one in the end.
        distinct.sort_by_key(|mesh| std::cmp::Reverse(mesh.triangles().len()));
        let next = AtomicUsize::new(0);
        let labour = || {
            let mut done: Vec<(usize, Arc<T>)> = Vec::new();
            while let Some(mesh) = distinct.get(next.fetch_add(1, Ordering::Relaxed)) {
                done.push((Arc::as_ptr(mesh) as usize, work(mesh)?));
            }
            Some(done)
        };
        let threads = self.threads.min(distinct.len());
        let mut made = if threads <= 1 {
            labour()?
        } else {
            thread::scope(|scope| {
                let handles: Vec<_> = (0..threads).map(|_| scope.spawn(labour)).collect();
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
