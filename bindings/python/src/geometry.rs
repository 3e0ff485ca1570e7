//! Meshes and spheres.

use numpy::{IntoPyArray as _, PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;
use rt_accel::{DVec3, Sphere, Spheres, TriangleMesh, Vertices};

use crate::arrays::{Rows, RowsView};

/// Points that a thread interpolates at a time.
const POINTS_PER_TASK: usize = 4096;

/// Checked triangles.
#[pyclass(name = "Mesh", frozen)]
#[derive(Clone)]
pub(crate) struct PyMesh(pub(crate) TriangleMesh<'static>);

#[pymethods]
impl PyMesh {
    #[new]
    fn new(vertices: &Bound<'_, PyAny>, faces: PyReadonlyArray2<'_, u32>) -> PyResult<Self> {
        let rows = Rows::extract("vertices", vertices)?;
        let faces = faces.as_array();
        if faces.ncols() != 3 {
            return Err(PyValueError::new_err(format!("faces must have three columns, not {}", faces.ncols())));
        }
        let triangles: Vec<[u32; 3]> = faces.rows().into_iter().map(|face| [face[0], face[1], face[2]]).collect();
        let mesh = TriangleMesh::new(vertices_of(&rows), triangles);
        mesh.map(Self).map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// The same triangles over other vertices.
    fn with_vertices(&self, vertices: &Bound<'_, PyAny>) -> PyResult<Self> {
        let mesh = self.0.with_vertices(vertices_of(&Rows::extract("vertices", vertices)?));
        mesh.map(Self).map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// Coordinates of the vertices, three for each: a copy in the precision that the mesh keeps.
    fn vertices<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        match self.0.vertices() {
            Vertices::F32(vertices) => vertices.as_flattened().to_vec().into_pyarray(py).into_any(),
            Vertices::F64(vertices) => vertices.as_flattened().to_vec().into_pyarray(py).into_any(),
        }
    }

    /// Writes points of triangles, interpolated between their vertices, into the rows of `points`. Barycentric coordinates are the
    /// weights of the second and third vertex, two for each triangle.
    fn interpolate(
        &self,
        py: Python<'_>,
        triangles: PyReadonlyArray1<'_, i64>,
        uv: PyReadonlyArray2<'_, f64>,
        mut points: PyReadwriteArray2<'_, f64>,
    ) -> PyResult<()> {
        let (triangles, mesh) = (triangles.as_slice()?, &self.0);
        let (uv, points) = (uv.as_slice()?.as_chunks().0, points.as_slice_mut()?.as_chunks_mut().0);
        if (uv.len(), points.len()) != (triangles.len(), triangles.len()) {
            let message =
                format!("{} coordinates and {} points for {} triangles", uv.len(), points.len(), triangles.len());
            return Err(PyValueError::new_err(message));
        }
        let write = |((triangle, [u, v]), point): ((&i64, &[f64; 2]), &mut [f64; 3])| {
            let corners = u32::try_from(*triangle).ok().and_then(|index| mesh.triangle(index)).ok_or(*triangle)?;
            *point = ((1.0 - (u + v)) * corners[0] + *u * corners[1] + *v * corners[2]).to_array();
            Ok(())
        };
        let items = triangles.par_iter().zip(uv).zip(points).with_min_len(POINTS_PER_TASK);
        let written: Result<(), i64> = py.detach(|| items.map(write).collect());
        written.map_err(|triangle| PyValueError::new_err(format!("there is no triangle {triangle}")))
    }

    /// Indices of vertices, three for each triangle: a copy.
    fn faces<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.0.triangles().as_flattened().to_vec().into_pyarray(py)
    }
}

/// Vertices in the precision of the rows.
fn vertices_of(rows: &Rows<'_>) -> Vertices<'static> {
    match rows.view() {
        RowsView::F32(rows) => rows.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect::<Vec<_>>().into(),
        RowsView::F64(rows) => rows.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect::<Vec<_>>().into(),
    }
}

/// Checked spheres.
#[pyclass(name = "SphereSet", frozen)]
#[derive(Clone)]
pub(crate) struct PySpheres(pub(crate) Spheres);

#[pymethods]
impl PySpheres {
    #[new]
    fn new(centres: PyReadonlyArray2<'_, f64>, radii: PyReadonlyArray1<'_, f64>) -> PyResult<Self> {
        let (centres, radii) = (centres.as_array(), radii.as_array());
        if centres.ncols() != 3 || centres.nrows() != radii.len() {
            let message =
                format!("{} centres with {} columns for {} radii", centres.nrows(), centres.ncols(), radii.len());
            return Err(PyValueError::new_err(message));
        }
        let sphere = |(i, (centre, radius)): (usize, (numpy::ndarray::ArrayView1<'_, f64>, &f64))| {
            let centre = DVec3::new(centre[0], centre[1], centre[2]);
            Sphere::new(centre, *radius).map_err(|error| PyValueError::new_err(format!("sphere {i}: {error}")))
        };
        let spheres = centres.rows().into_iter().zip(radii).enumerate().map(sphere);
        Ok(Self(Spheres::new(spheres.collect::<PyResult<_>>()?)))
    }

    /// Coordinates of the centres and the radius, four numbers for each sphere: a copy.
    fn numbers<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let numbers = |sphere: &Sphere| {
            let DVec3 { x, y, z } = sphere.centre();
            [x, y, z, sphere.radius()]
        };
        self.0.as_slice().iter().flat_map(numbers).collect::<Vec<_>>().into_pyarray(py)
    }
}
