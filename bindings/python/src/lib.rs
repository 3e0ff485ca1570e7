//! Extension module `rt._rt`: rays and images for numpy arrays. Users import the package `rt`, which wraps it.
//!
//! `arrays` turns numpy arrays into batches, and `rays` traces them slice by slice on `threads`. `geometry` holds meshes and
//! spheres, `scene` the queries, `crossings` those of trimesh, `render` images.

mod arrays;
mod crossings;
mod error;
mod geometry;
mod rays;
mod render;
mod scene;
mod threads;

/// Exact rays on triangle meshes, and images.
#[pyo3::pymodule]
mod _rt {
    /// Version of the package.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");

    #[pymodule_export]
    use crate::crossings::{crossings, first_triangles};
    #[pymodule_export]
    use crate::geometry::{PyMesh, PySpheres};
    #[pymodule_export]
    use crate::render::{PyRendering, render};
    #[pymodule_export]
    use crate::scene::{PyScene, check_quality};
}
