//! Meshes of files and of numpy arrays. An array is read where it lies: the only copy is the mesh itself.

use std::{fs::File, path::PathBuf, sync::Arc};

use build_file::{LengthUnit, ReadLimits, read_part_file};
use glam::DVec3;
use numpy::{Element, PyReadonlyArray2};
use pyo3::prelude::*;
use solids::Mesh;

use crate::{
    beside::run_beside,
    errors::{InputError, mesh_error, os_error, parse_word, read_error},
};

/// A mesh to pack, in mm.
#[pyclass(frozen, name = "Mesh")]
pub(crate) struct InputMesh {
    /// Name of the solid in its file; empty for arrays.
    #[pyo3(get)]
    name: String,
    /// Copies that the file itself asks for, at least 1.
    #[pyo3(get)]
    copies: u32,
    /// What a person should know about it; sentences without a full stop.
    #[pyo3(get)]
    warnings: Vec<String>,
    /// Name of the file; empty for arrays.
    pub(crate) source_name: String,
    /// BLAKE3 of the file, or of the arrays.
    pub(crate) source_hash: String,
    /// The solid.
    pub(crate) mesh: Arc<Mesh>,
}

/// Reads all solids of a part file. `unit` counts where the file states none. Returns warnings about the whole file, too.
#[pyfunction]
pub(crate) fn read_file(py: Python<'_>, path: PathBuf, unit: &str) -> PyResult<(Vec<InputMesh>, Vec<String>)> {
    let unit: LengthUnit = parse_word("unit", unit)?;
    run_beside(py, move || {
        let mut hasher = blake3::Hasher::new();
        let hashed = File::open(&path).and_then(|file| hasher.update_reader(file).map(|_| ()));
        hashed.map_err(|error| os_error(&error, &path))?;
        let source_hash = hasher.finalize().to_hex().to_string();
        let source_name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let contents = read_part_file(&path, &source_name, None, unit, &ReadLimits::default())
            .map_err(|error| read_error(&error, &path))?;
        let to_input = |solid: build_file::PartFileSolid| InputMesh {
            warnings: solid.warnings.into_iter().chain(solid.question).chain(open_warning(&solid.mesh)).collect(),
            name: solid.name,
            copies: solid.copies,
            source_name: source_name.clone(),
            source_hash: source_hash.clone(),
            mesh: solid.mesh,
        };
        Ok((contents.solids.into_iter().map(to_input).collect(), contents.warnings))
    })
}

/// Makes a mesh of vertices (n x 3, float64 or float32, mm) and faces (m x 3, int64, int32 or uint32).
#[pyfunction]
pub(crate) fn mesh_from_arrays(
    py: Python<'_>,
    vertices: &Bound<'_, PyAny>,
    faces: &Bound<'_, PyAny>,
    name: String,
) -> PyResult<InputMesh> {
    let vertices = match vertices.extract::<PyReadonlyArray2<'_, f64>>() {
        Ok(array) => read_vertices(&array),
        Err(_) => read_vertices(&vertices.extract::<PyReadonlyArray2<'_, f32>>()?),
    };
    let triangles = if let Ok(array) = faces.extract::<PyReadonlyArray2<'_, i64>>() {
        read_triangles(&array, &name)?
    } else if let Ok(array) = faces.extract::<PyReadonlyArray2<'_, i32>>() {
        read_triangles(&array, &name)?
    } else {
        read_triangles(&faces.extract::<PyReadonlyArray2<'_, u32>>()?, &name)?
    };
    run_beside(py, move || {
        let mesh = Mesh::new(vertices, triangles).map_err(|error| mesh_error(&error, &name))?;
        Ok(InputMesh {
            name: String::new(),
            copies: 1,
            warnings: open_warning(&mesh).into_iter().collect(),
            source_name: String::new(),
            source_hash: hash_of(&mesh),
            mesh: Arc::new(mesh),
        })
    })
}

fn read_vertices<T: Element + Copy + Into<f64>>(array: &PyReadonlyArray2<'_, T>) -> Vec<DVec3> {
    array.as_array().rows().into_iter().map(|row| DVec3::new(row[0].into(), row[1].into(), row[2].into())).collect()
}

/// Fails where an index is negative or does not fit 32 bits.
fn read_triangles<T>(array: &PyReadonlyArray2<'_, T>, name: &str) -> PyResult<Vec<[u32; 3]>>
where
    T: Element + Copy + TryInto<u32> + std::fmt::Display,
{
    let index = |face: usize, value: T| {
        value.try_into().map_err(|_| {
            InputError::new_err(format!(
                "{name}: face {face} names vertex {value}, which cannot exist. Give faces as rows of three indices into \
                 the vertices, from 0."
            ))
        })
    };
    let rows = array.as_array();
    let rows = rows.rows().into_iter().enumerate();
    rows.map(|(face, row)| Ok([index(face, row[0])?, index(face, row[1])?, index(face, row[2])?])).collect()
}

/// A warning about a surface that is not closed.
fn open_warning(mesh: &Mesh) -> Option<String> {
    let edges = mesh.faulty_edges().len();
    (edges > 0).then(|| {
        format!(
            "the surface is not closed ({edges} open or faulty edges), so that nobody knows what lies inside: repair the \
             mesh"
        )
    })
}

/// Identifies a mesh by its content.
fn hash_of(mesh: &Mesh) -> String {
    let mut hasher = blake3::Hasher::new();
    for vertex in mesh.vertices() {
        vertex.to_array().iter().for_each(|coordinate| _ = hasher.update(&coordinate.to_le_bytes()));
    }
    mesh.triangles().iter().flatten().for_each(|corner| _ = hasher.update(&corner.to_le_bytes()));
    hasher.finalize().to_hex().to_string()
}
