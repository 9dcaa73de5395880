//! Where the meshes of parts come from: memory, else the content-addressed store.

use std::{
    collections::HashMap,
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use build_file::{Contents, Limits, Unit};
use nester::PreparedMeshes;
use solids::Mesh;

use super::{
    alone::Errand,
    cache::DiskCache,
    failure::{Lost, Unread},
    shelf::{MeshKey, Shelf},
};
use crate::{
    intake::{Store, StoreError},
    ledger::PartRow,
    settings::Profile,
};

/// Reading a file is tried so often in the daemon; the attempts after these are made alone.
pub const READS_IN_THE_DAEMON: u32 = 2;

/// Where meshes come from.
#[derive(Debug, Clone)]
pub struct Meshes {
    /// Meshes in memory.
    pub shelf: Shelf,
    /// The content-addressed store.
    pub store: Store,
    /// Limits of the readers.
    pub limits: Limits,
    /// Work on meshes: in memory as long as they are on the shelf, and on disk where there is room for it.
    pub prepared: PreparedMeshes,
    /// The disk cache that `prepared` uses.
    pub cache: Option<Arc<DiskCache>>,
    /// Since when stored files cannot be read, by content.
    pub unreadable: Arc<Mutex<HashMap<String, Instant>>>,
}

/// A stored file that cannot be read for so long is taken for damaged; a cable or a share fails in passing.
const UNREADABLE_FOR: Duration = Duration::from_secs(60);

impl Meshes {
    /// The stored file of a part, compared with what was dropped. What is damaged is set aside.
    pub fn stored(&self, part: &PartRow) -> Result<PathBuf> {
        let hash = &part.file.content_hash;
        let verified = self.store.verify(hash);
        let is_unreadable = verified.as_ref().is_err_and(StoreError::is_unreadable);
        let is_lasting = self.is_lasting(hash, is_unreadable);
        match verified {
            Ok(()) => Ok(self.store.path(hash)?),
            Err(error) if error.is_lost() || is_lasting => {
                let aside = self.store.set_damaged_aside(hash)?;
                Err(Lost { name: part.name.clone(), content_hash: hash.clone(), aside }.into())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Whether a stored file has not been readable for long.
    fn is_lasting(&self, hash: &str, is_unreadable: bool) -> bool {
        let mut unreadable = self.unreadable.lock().unwrap_or_else(PoisonError::into_inner);
        if !is_unreadable {
            unreadable.remove(hash);
            return false;
        }
        unreadable.entry(hash.to_owned()).or_insert_with(Instant::now).elapsed() >= UNREADABLE_FOR
    }

    /// What a part's file holds; one whose reading has ended the process before is read in a process of its own.
    pub fn contents(&self, file: PathBuf, part: &PartRow, default_unit: Unit) -> Result<Contents, Unread> {
        let (name, unit, limits) = (part.name.clone(), part.terms.unit, self.limits.clone());
        let errand = Errand { file, name, unit, default_unit, limits };
        if part.file.reads > READS_IN_THE_DAEMON { errand.read_alone() } else { errand.read() }
    }

    /// The mesh of a part, from the shelf or from the store.
    pub fn mesh(&self, profile: &Profile, part: &PartRow) -> Result<Arc<Mesh>> {
        let key = |object_index| MeshKey {
            content_hash: part.file.content_hash.clone(),
            object_index,
            default_unit: profile.intake.unit,
            unit: part.terms.unit,
        };
        if let Some(mesh) = self.shelf.mesh(&key(part.solid.object_index)) {
            return Ok(mesh);
        }
        let file = self.stored(part)?;
        let contents = (self.contents(file, part, profile.intake.unit))
            .with_context(|| format!("reading part {} ({}) again", part.id.0, part.name))?;
        for (index, solid) in contents.solids.into_iter().enumerate() {
            self.shelf.put(key(index as u32), solid.mesh);
        }
        self.shelf
            .mesh(&key(part.solid.object_index))
            .with_context(|| format!("part {} ({}) has no solid {}", part.id.0, part.name, part.solid.object_index))
    }
}
