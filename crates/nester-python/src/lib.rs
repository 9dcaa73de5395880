//! The native half of the Python package `nestd_nester`. Python checks the arguments and holds what the user gave;
//! this half reads meshes, searches, proves and writes. What takes time is done without the interpreter's lock.

mod beside;
mod errors;
mod found_layout;
mod layout;
mod layout_file;
mod layout_proof;
mod mesh_input;
mod request;
mod search;

/// The native half of `nestd_nester`. It is not a public interface.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::layout::PackedLayout;
    #[pymodule_export]
    use crate::mesh_input::{InputMesh, mesh_from_arrays, read_file};
    #[pymodule_export]
    use crate::search::search;
}
