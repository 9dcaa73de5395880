//! The box trees of placed bodies: one for each mesh, built when it is first asked for. Most large parts stand alone, and a
//! pair whose bounds are far apart needs no tree.

use std::{
    collections::HashMap,
    sync::{Arc, OnceLock},
};

use solids::{ClearanceTree, Mesh};

use super::placed_solid::PlacedSolid;

/// Trees of bodies.
#[derive(Debug)]
pub(super) struct PlacedBodyTrees<'a> {
    meshes: Vec<(&'a Arc<Mesh>, OnceLock<ClearanceTree>)>,
    /// For each body the place of its mesh.
    mesh_of: Vec<usize>,
    threads: usize,
}

impl<'a> PlacedBodyTrees<'a> {
    /// The trees of bodies, none of which is built yet.
    pub(super) fn new(bodies: &'a [PlacedSolid], threads: usize) -> Self {
        let mut known: HashMap<*const Mesh, usize> = HashMap::new();
        let mut meshes = Vec::new();
        let mesh_of = (bodies.iter())
            .map(|body| {
                *known.entry(Arc::as_ptr(&body.mesh)).or_insert_with(|| {
                    meshes.push((&body.mesh, OnceLock::new()));
                    meshes.len() - 1
                })
            })
            .collect();
        Self { meshes, mesh_of, threads }
    }

    /// The tree of a body. Bodies with the same mesh share one.
    pub(super) fn tree(&self, body: usize) -> &ClearanceTree {
        let (mesh, tree) = &self.meshes[self.mesh_of[body]];
        tree.get_or_init(|| ClearanceTree::on_threads((*mesh).clone(), self.threads))
    }
}
