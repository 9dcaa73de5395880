//! A found layout, as Python sees it.

use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

use build_file::Viewpoint;
use nester::{PreparedMeshes, examine_left_out};
use numpy::{PyArray2, PyReadonlyArray3, ToPyArray, ndarray::arr2};
use pyo3::{prelude::*, types::PyBytes};

use crate::{
    beside::run_beside,
    errors::InputError,
    found_layout::FoundLayout,
    layout_file::{FileWords, draw_layout, write_proved},
    layout_proof::{ProofFigures, posed_placements, prove_placements},
};

/// A layout in which every placement keeps its clearance. Lengths are in mm.
#[pyclass(frozen, name = "Layout")]
pub(crate) struct PackedLayout {
    pub(crate) found: Arc<FoundLayout>,
}

/// Vertices and faces of a mesh.
type MeshArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>);

#[pymethods]
impl PackedLayout {
    /// Top of the highest placement; 0 when nothing is placed.
    #[getter]
    fn height(&self) -> f64 {
        self.found.solution.height_mm
    }

    /// Part volume / (base area x height).
    #[getter]
    fn density(&self) -> f64 {
        self.found.solution.density(&self.found.instance)
    }

    /// A height that no layout of all copies can beat.
    #[getter]
    fn lower_bound(&self) -> f64 {
        self.found.lower_bound_mm
    }

    /// Number of evaluations made until the layout was found.
    #[getter]
    fn evaluations(&self) -> u64 {
        self.found.solution.evaluations
    }

    /// Wall seconds of the search.
    #[getter]
    fn seconds(&self) -> f64 {
        self.found.secs
    }

    /// Why the search ended.
    #[getter]
    fn ended(&self) -> &str {
        &self.found.ended
    }

    /// (seconds, height) of every better layout.
    #[getter]
    fn heights(&self) -> Vec<(f64, f64)> {
        self.found.heights.clone()
    }

    /// (item, copy, matrix) of every placement.
    fn placements<'py>(&self, py: Python<'py>) -> Vec<(usize, u32, Bound<'py, PyArray2<f64>>)> {
        let placements = &self.found.solution.placements;
        placements.iter().map(|p| (p.item, p.copy, arr2(&p.pose.matrix_rows()).to_pyarray(py))).collect()
    }

    /// (item, copy) of every copy without a place.
    fn left_out(&self) -> Vec<(usize, u32)> {
        self.found.solution.unplaced.clone()
    }

    /// For each item of which copies are left out: where one more copy would fit.
    fn explain_left_out(&self, py: Python<'_>) -> PyResult<BTreeMap<usize, String>> {
        let found = self.found.clone();
        run_beside(py, move || {
            let fits = examine_left_out(&found.instance, &found.config, &found.solution, &PreparedMeshes::default());
            Ok(fits.into_iter().map(|(item, fit)| (item, fit.reason)).collect())
        })
    }

    /// Vertices (float64) and faces (uint32) of the mesh of an item, in its own frame.
    fn mesh<'py>(&self, py: Python<'py>, item: usize) -> PyResult<MeshArrays<'py>> {
        let items = self.found.instance.items();
        let Some(item) = items.get(item) else {
            return Err(InputError::new_err(format!("there is no part {item}; there are {}", items.len())));
        };
        let vertices: Vec<[f64; 3]> = item.mesh.vertices().iter().map(|vertex| vertex.to_array()).collect();
        Ok((arr2(&vertices).to_pyarray(py), arr2(item.mesh.triangles()).to_pyarray(py)))
    }

    /// Proves the placements on their triangles at these poses (n x 4 x 4): (height, least distance, locked placements,
    /// removal order).
    fn verify(&self, py: Python<'_>, matrices: PyReadonlyArray3<'_, f64>) -> PyResult<ProofFigures> {
        let found = self.found.clone();
        let placements = posed_placements(&found, &matrices)?;
        run_beside(py, move || prove_placements(&found, &placements))
    }

    /// Writes a 3MF, proves what was written, and gives it its name. `created` is the time in RFC 3339; `shared` says
    /// whether the copies of a part share one object.
    fn write_3mf(&self, py: Python<'_>, path: PathBuf, title: String, created: String, shared: bool) -> PyResult<()> {
        let found = self.found.clone();
        run_beside(py, move || write_proved(&found, &path, FileWords { title, created, is_shared: shared }))
    }

    /// A picture of the layout as a PNG; `size` is in pixels, `view` is `iso`, `top` or `front`.
    fn picture<'py>(&self, py: Python<'py>, view: &str, size: (u32, u32)) -> PyResult<Bound<'py, PyBytes>> {
        let view = match view {
            "iso" => Viewpoint::Iso,
            "top" => Viewpoint::Top,
            "front" => Viewpoint::Front,
            other => {
                return Err(InputError::new_err(format!("view={other:?}: give one of \"iso\", \"top\", \"front\".")));
            }
        };
        let found = self.found.clone();
        Ok(PyBytes::new(py, &run_beside(py, move || Ok(draw_layout(&found, view, size)))?))
    }
}
