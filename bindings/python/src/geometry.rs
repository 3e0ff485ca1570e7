//! Meshes and spheres.

use numpy::{IntoPyArray as _, PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use rt_accel::{DVec3, MeshError, Primitives as _, Sphere, Spheres, TriangleMesh, Vertices};
use rt_geometry::Triangle;

use crate::arrays::{Rows, RowsView, collected, with_capacity};
use crate::error::value_error;

/// Checked triangles.
#[pyclass(name = "Mesh", module = "rt._rt", frozen)]
pub(crate) struct PyMesh {
    pub(crate) mesh: TriangleMesh<'static>,
    /// Maximum magnitude of the coordinates of all vertices of triangles; 0 without triangles.
    pub(crate) largest_coordinate: f64,
}

impl PyMesh {
    fn checked(mesh: Result<TriangleMesh<'static>, MeshError>) -> PyResult<Self> {
        let mesh = mesh.map_err(value_error)?;
        let used = || mesh.triangles().as_flattened().iter().map(|vertex| *vertex as usize);
        let largest_coordinate = match mesh.vertices() {
            Vertices::F32(vertices) => {
                used().flat_map(|vertex| vertices[vertex]).fold(0.0_f32, |max, c| max.max(c.abs())).into()
            }
            Vertices::F64(vertices) => used().flat_map(|vertex| vertices[vertex]).fold(0.0, |max, c| c.abs().max(max)),
        };
        Ok(Self { mesh, largest_coordinate })
    }
}

#[pymethods]
impl PyMesh {
    #[new]
    fn new(vertices: &Bound<'_, PyAny>, faces: PyReadonlyArray2<'_, u32>) -> PyResult<Self> {
        let rows = Rows::extract("vertices", vertices)?;
        if !faces.is_aligned() {
            return Err(value_error("faces must be aligned in memory"));
        }
        let faces = faces.as_array();
        if faces.ncols() != 3 {
            return Err(value_error(format!("faces must have three columns, not {}", faces.ncols())));
        }
        let triangles = collected(faces.rows().into_iter().map(|face| [face[0], face[1], face[2]]))?;
        Self::checked(TriangleMesh::new(vertices_of(&rows)?, triangles))
    }

    /// Mesh with the triangles of this one and other vertices.
    fn with_vertices(&self, vertices: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::checked(self.mesh.with_vertices(vertices_of(&Rows::extract("vertices", vertices)?)?))
    }

    /// Coordinates of the vertices, three for each: a copy in the precision that the mesh keeps.
    fn vertices<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        match self.mesh.vertices() {
            Vertices::F32(vertices) => vertices.as_flattened().to_vec().into_pyarray(py).into_any(),
            Vertices::F64(vertices) => vertices.as_flattened().to_vec().into_pyarray(py).into_any(),
        }
    }

    /// Indices of vertices, three for each triangle: a copy.
    fn faces<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.mesh.triangles().as_flattened().to_vec().into_pyarray(py)
    }

    /// True if a triangle has an area after its vertices minus the centre are rounded to single precision, as in files for
    /// rendering.
    fn has_area(&self, centre: [f64; 3]) -> bool {
        let centre = DVec3::from_array(centre);
        let mut triangles = (0..self.mesh.len() as u32).filter_map(|i| self.mesh.triangle(i));
        triangles.any(|corners| Triangle::new(corners.map(|corner| (corner - centre).as_vec3().as_dvec3())).is_ok())
    }
}

/// Vertices in the precision of the rows.
fn vertices_of(rows: &Rows<'_>) -> PyResult<Vertices<'static>> {
    Ok(match rows.view() {
        RowsView::F32(rows) => collected(rows.rows().into_iter().map(|row| [row[0], row[1], row[2]]))?.into(),
        RowsView::F64(rows) => collected(rows.rows().into_iter().map(|row| [row[0], row[1], row[2]]))?.into(),
    })
}

/// Checked spheres.
#[pyclass(name = "SphereSet", module = "rt._rt", frozen)]
#[derive(Clone)]
pub(crate) struct PySpheres(pub(crate) Spheres);

#[pymethods]
impl PySpheres {
    #[new]
    fn new(centres: PyReadonlyArray2<'_, f64>, radii: PyReadonlyArray1<'_, f64>) -> PyResult<Self> {
        if !(centres.is_aligned() && radii.is_aligned()) {
            return Err(value_error("centres and radii must be aligned in memory"));
        }
        let (centres, radii) = (centres.as_array(), radii.as_array());
        if centres.ncols() != 3 || centres.nrows() != radii.len() {
            let message =
                format!("{} centres with {} columns for {} radii", centres.nrows(), centres.ncols(), radii.len());
            return Err(value_error(message));
        }
        let sphere = |(i, (centre, radius)): (usize, (numpy::ndarray::ArrayView1<'_, f64>, &f64))| {
            let centre = DVec3::new(centre[0], centre[1], centre[2]);
            Sphere::new(centre, *radius).map_err(|error| value_error(format!("sphere {i}: {error}")))
        };
        let mut spheres = with_capacity(radii.len())?;
        for item in centres.rows().into_iter().zip(radii).enumerate() {
            spheres.push(sphere(item)?);
        }
        Ok(Self(Spheres::new(spheres)))
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
