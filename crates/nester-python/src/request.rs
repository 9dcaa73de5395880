//! What Python asks for: the attributes of its objects become an instance, a configuration and a budget.

use glam::DVec3;
use nester::{BuildVolume, NestingConfig, NestingInstance, NestingItem, OrientationRule, SearchBudget};
use pyo3::prelude::*;

use crate::{
    errors::{InputError, parse_word},
    mesh_input::InputMesh,
};

/// A part with its copies.
#[derive(FromPyObject)]
pub(crate) struct ItemRequest {
    name: String,
    mesh: Py<InputMesh>,
    copies: u32,
    orientation: String,
    clearance: Option<f64>,
}

/// The build volume, the rules and the limits of a search. Lengths are in mm.
#[derive(FromPyObject)]
pub(crate) struct SearchRequest {
    volume: [f64; 3],
    clearance: f64,
    seconds: Option<f64>,
    evaluations: Option<u64>,
    patience: Option<f64>,
    seed: u64,
    threads: usize,
    lanes: usize,
    interlock: String,
    method: String,
}

/// Where a part comes from, for the build file.
pub(crate) struct ItemSource {
    /// Name of its file; its own name for arrays.
    pub(crate) file_name: String,
    /// BLAKE3 of its file or arrays.
    pub(crate) hash: String,
    /// The orientation rule as the build file spells it.
    pub(crate) orientation: String,
}

impl SearchRequest {
    /// Checks the instance.
    pub(crate) fn to_instance(&self, items: &[ItemRequest]) -> PyResult<NestingInstance> {
        let volume = BuildVolume { size_mm: DVec3::from_array(self.volume) };
        let items = items.iter().map(ItemRequest::to_item).collect::<PyResult<Vec<_>>>()?;
        NestingInstance::new(volume, self.clearance, items).map_err(|error| {
            InputError::new_err(format!("{error}. Give positive lengths in mm, and at least one part."))
        })
    }

    /// The parameters of the search.
    pub(crate) fn to_config(&self) -> PyResult<NestingConfig> {
        Ok(NestingConfig {
            method: parse_word("method", &self.method)?,
            seed: self.seed,
            threads: self.threads,
            lanes: self.lanes,
            interlock: parse_word("interlock", &self.interlock)?,
            ..NestingConfig::default()
        })
    }

    /// The limits of the search; its clock starts now.
    pub(crate) fn begin_budget(&self) -> SearchBudget {
        let mut budget = SearchBudget::until_cancelled();
        if let Some(secs) = self.seconds {
            budget = budget.with_secs(secs);
        }
        if let Some(evaluations) = self.evaluations {
            budget = budget.with_evaluations(evaluations);
        }
        match self.patience {
            Some(secs) => budget.with_patience(secs),
            None => budget,
        }
    }
}

impl ItemRequest {
    fn to_item(&self) -> PyResult<NestingItem> {
        let rule: OrientationRule = parse_word("orientation", &self.orientation)?;
        let item = NestingItem::new(&self.name, self.mesh.get().mesh.clone(), self.copies).with_orientation(rule);
        Ok(NestingItem { clearance_mm: self.clearance, ..item })
    }

    /// Where the part comes from.
    pub(crate) fn to_source(&self) -> ItemSource {
        let mesh = self.mesh.get();
        let file_name = if mesh.source_name.is_empty() { &self.name } else { &mesh.source_name };
        ItemSource {
            file_name: file_name.clone(),
            hash: mesh.source_hash.clone(),
            orientation: self.orientation.clone(),
        }
    }
}
