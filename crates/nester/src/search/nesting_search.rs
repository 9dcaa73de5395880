//! A search with its optional inputs by name.

use std::fmt;

use crate::{
    ImprovedLayouts, ItemPlacement, NestingConfig, NestingInstance, NestingSolution, PreparedMeshes, ProgressListener,
    StopCondition, improve_layouts, insert_copies, nest_with_cache,
};

/// A search of an instance: configuration, prepared meshes and listener are given by name, and only where the defaults do not
/// fit. Each method that searches does what the function does to which its text refers.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use nester::{BuildVolume, NestingConfig, NestingInstance, NestingItem, NestingSearch, SearchBudget};
/// use solids::Mesh;
///
/// let ring = Arc::new(Mesh::tube(30.0, 20.0, 6.0)?);
/// let volume = BuildVolume { size_mm: DVec3::new(60.0, 60.0, 200.0) };
/// let asked = |copies| NestingInstance::new(volume, 2.0, vec![NestingItem::new("ring", ring.clone(), copies)]);
///
/// let first = NestingSearch::new(&asked(4)?).nest(&SearchBudget::of_evaluations(500));
/// assert_eq!(first.placements.len(), 4);
///
/// // Two more rings, and another seed.
/// let more = asked(6)?;
/// let search = NestingSearch::new(&more).with_config(NestingConfig { seed: 7, ..NestingConfig::default() });
/// let second = search.insert_copies(&first.placements, &SearchBudget::of_evaluations(500));
/// assert_eq!(second.placements.len(), 6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct NestingSearch<'a> {
    instance: &'a NestingInstance,
    config: NestingConfig,
    prepared: PreparedMeshes,
    listener: Option<&'a mut dyn ProgressListener>,
}

impl fmt::Debug for NestingSearch<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NestingSearch").field("config", &self.config).finish_non_exhaustive()
    }
}

impl<'a> NestingSearch<'a> {
    /// A search with the default configuration that begins without prepared meshes and tells nobody of its progress.
    pub fn new(instance: &'a NestingInstance) -> Self {
        let (config, prepared) = (NestingConfig::default(), PreparedMeshes::default());
        Self { instance, config, prepared, listener: None }
    }

    /// The same search with this configuration.
    #[must_use]
    pub fn with_config(self, config: NestingConfig) -> Self {
        Self { config, ..self }
    }

    /// The same search that reuses meshes prepared for other searches, and adds its own to them.
    #[must_use]
    pub fn with_prepared(self, prepared: &PreparedMeshes) -> Self {
        Self { prepared: prepared.clone(), ..self }
    }

    /// The same search that tells `listener` of every better layout.
    #[must_use]
    pub fn with_listener(self, listener: &'a mut dyn ProgressListener) -> Self {
        Self { listener: Some(listener), ..self }
    }

    /// Nests the instance from nothing until `stop` ends the search: see [`nest`](crate::nest).
    pub fn nest(self, stop: &dyn StopCondition) -> NestingSolution {
        self.continue_from(&[], stop)
    }

    /// Continues from an earlier layout of the instance, or of a part of it: see `start` of [`nest`](crate::nest).
    pub fn continue_from(self, start: &[ItemPlacement], stop: &dyn StopCondition) -> NestingSolution {
        let (mut nobody, listener) = ((), self.listener);
        let listener = listener.unwrap_or(&mut nobody);
        nest_with_cache(self.instance, &self.config, start, &self.prepared, stop, listener)
    }

    /// Inserts the copies that `standing` lacks: see [`insert_copies`].
    pub fn insert_copies(self, standing: &[ItemPlacement], stop: &dyn StopCondition) -> NestingSolution {
        let (mut nobody, listener) = ((), self.listener);
        let listener = listener.unwrap_or(&mut nobody);
        insert_copies(self.instance, &self.config, standing, &self.prepared, stop, listener)
    }

    /// Lowers the layouts of a pool: see [`improve_layouts`].
    pub fn improve_layouts(self, pool: &[Vec<ItemPlacement>], stop: &dyn StopCondition) -> ImprovedLayouts {
        let (mut nobody, listener) = ((), self.listener);
        let listener = listener.unwrap_or(&mut nobody);
        improve_layouts(self.instance, &self.config, pool, &self.prepared, stop, listener)
    }
}
