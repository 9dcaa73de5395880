//! Prepares meshes: from what is in memory, from what was kept on disk, or anew; on several threads where there are. What
//! comes out is the same whichever way it came.

use std::{
    panic::resume_unwind,
    sync::{
        Arc, Mutex, PoisonError, Weak,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use solids::{ClearanceTree, Mesh};

use super::{
    Stop,
    cache::{self, Cache},
    outline::Outline,
    shape::{Detail, Shape},
};

/// Shapes of one mesh that stay in memory at most: a coarse and a fine one, and room for a change of clearance.
const MOST_SHAPES: usize = 3;

/// Where meshes are prepared.
#[derive(Clone, Copy)]
pub(crate) struct Workshop<'a> {
    cache: Option<&'a dyn Cache>,
    threads: usize,
    /// Whose time it is, and the share of it after which nothing more is prepared.
    patience: Option<(&'a dyn Stop, f64)>,
}

/// What is in memory of one mesh.
#[derive(Default)]
struct Bench {
    mesh: Weak<Mesh>,
    /// The mesh's name by its content, once somebody asked.
    name: Option<Arc<str>>,
    outline: Option<Arc<Outline>>,
    tree: Option<Arc<ClearanceTree>>,
    shapes: Vec<(Detail, Arc<Shape>)>,
}

/// Work on meshes that are still alive: an open build asks for the same meshes again and again.
static BENCHES: Mutex<Vec<Bench>> = Mutex::new(Vec::new());

impl<'a> Workshop<'a> {
    /// A workshop that keeps its work in `cache` and works on so many threads; 0 = one per core.
    pub(crate) fn new(cache: Option<&'a dyn Cache>, threads: usize) -> Self {
        let cores = || thread::available_parallelism().map_or(1, usize::from);
        Self { cache, threads: if threads == 0 { cores() } else { threads }, patience: None }
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
        self.each(meshes, |mesh| Some(self.outline(mesh))).unwrap_or_default()
    }

    /// Shapes of meshes at a detail, in the order of the meshes; `None` when the time is over before.
    pub(crate) fn shapes(&self, meshes: &[Arc<Mesh>], detail: Detail) -> Option<Vec<Arc<Shape>>> {
        self.each(meshes, |mesh| self.shape(mesh, detail))
    }

    fn outline(&self, mesh: &Arc<Mesh>) -> Arc<Outline> {
        if let Some(known) = at_bench(mesh, |bench| bench.outline.clone()) {
            return known;
        }
        let key = self.cache.map(|cache| (cache, cache::key_of("outline", &name_of(mesh))));
        let kept = key.as_ref().and_then(|(cache, key)| cache::unpack_outline(&cache.fetch(key)?));
        let is_kept = kept.is_some();
        let outline = Arc::new(kept.unwrap_or_else(|| Outline::new(mesh)));
        if let (Some((cache, key)), false) = (key, is_kept) {
            cache.keep(&key, &cache::pack_outline(&outline));
        }
        at_bench(mesh, |bench| bench.outline.get_or_insert(outline).clone())
    }

    fn shape(&self, mesh: &Arc<Mesh>, detail: Detail) -> Option<Arc<Shape>> {
        // Exactly this detail: a finer one at hand would make a build depend on what was nested before it.
        let known =
            |bench: &mut Bench| bench.shapes.iter().find(|(of, _)| *of == detail).map(|(_, shape)| shape.clone());
        if let Some(known) = at_bench(mesh, known) {
            return Some(known);
        }
        if self.is_over() {
            return None;
        }
        let outline = self.outline(mesh);
        let tree = at_bench(mesh, |bench| bench.tree.clone()).unwrap_or_else(|| {
            let tree = Arc::new(ClearanceTree::along(mesh.clone(), outline.obb));
            at_bench(mesh, |bench| bench.tree.get_or_insert(tree).clone())
        });
        let name = self.cache.map(|_| name_of(mesh));
        let kept = self.cache.zip(name.as_deref());
        let shape = Arc::new(Shape::new(tree, &outline, detail, kept, &|| self.is_over())?);
        at_bench(mesh, |bench| {
            bench.shapes.push((detail, shape.clone()));
            let too_many = bench.shapes.len().saturating_sub(MOST_SHAPES);
            bench.shapes.drain(..too_many);
        });
        Some(shape)
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

fn name_of(mesh: &Arc<Mesh>) -> Arc<str> {
    let known = at_bench(mesh, |bench| bench.name.clone());
    known.unwrap_or_else(|| {
        let name: Arc<str> = cache::name_of(mesh).into();
        at_bench(mesh, |bench| bench.name.get_or_insert(name).clone())
    })
}

/// Looks at, or adds to, what is in memory of a mesh.
fn at_bench<T>(mesh: &Arc<Mesh>, look: impl FnOnce(&mut Bench) -> T) -> T {
    let mut benches = BENCHES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(at) = benches.iter().position(|bench| std::ptr::eq(bench.mesh.as_ptr(), Arc::as_ptr(mesh))) {
        return look(&mut benches[at]);
    }
    // The tree itself holds its mesh; another holder means that somebody may still ask.
    benches.retain(|bench| bench.mesh.strong_count() > usize::from(bench.tree.is_some()));
    benches.push(Bench { mesh: Arc::downgrade(mesh), ..Bench::default() });
    let at = benches.len() - 1;
    look(&mut benches[at])
}
