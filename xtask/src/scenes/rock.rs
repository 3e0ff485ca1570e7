//! A closed mesh of small triangles.

use rt_geometry::{MeshData, TriangleMesh};
use rt_math::{DVec3, Vec3, transcendental::sin};
use rt_tests::icosphere;

use super::{Scene, mesh, nearest};
use crate::error::TaskError;

/// A subdivided icosahedron with bumps. Each subdivision makes four triangles of one.
pub(crate) fn rock(wanted: usize) -> Result<Scene<TriangleMesh>, TaskError> {
    Ok(Scene::whole("rock", mesh(data(wanted))?))
}

/// The mesh of a rock with a radius of about 1.
pub(crate) fn data(wanted: usize) -> MeshData {
    let subdivisions = nearest(wanted, 0..10, |subdivisions| 20 << (2 * subdivisions));
    let (points, triangles) = icosphere(subdivisions);
    let positions = points.iter().map(|&point| bumpy(point).as_vec3()).collect::<Vec<Vec3>>();
    let triangles = triangles.iter().map(|corners| corners.map(|corner| corner as u32)).collect();
    MeshData { positions, triangles, ..MeshData::default() }
}

/// The point of a sphere moved in and out by waves of two lengths.
fn bumpy(point: DVec3) -> DVec3 {
    let wave = |count: f64| sin(count * point.x) * sin(count * point.y + 1.0) * sin(count * point.z + 2.0);
    point * (1.0 + 0.2 * wave(5.0) + 0.03 * wave(31.0))
}
