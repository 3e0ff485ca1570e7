//! A closed mesh of small triangles.

use std::collections::HashMap;

use rt_geometry::{MeshData, TriangleMesh};
use rt_math::{DVec3, Vec3, transcendental::sin};

use super::{Scene, mesh, nearest};
use crate::error::TaskError;

/// A subdivided icosahedron with bumps. Each subdivision makes four triangles of one.
pub(crate) fn rock(wanted: usize) -> Result<Scene<TriangleMesh>, TaskError> {
    Ok(Scene::whole("rock", mesh(data(wanted))?))
}

/// The mesh of a rock with a radius of about 1.
pub(crate) fn data(wanted: usize) -> MeshData {
    let subdivisions = nearest(wanted, 0..10, |subdivisions| 20 << (2 * subdivisions));
    let (mut points, mut triangles) = icosahedron();
    for _ in 0..subdivisions {
        triangles = subdivide(&mut points, &triangles);
    }
    let positions = points.iter().map(|&point| bumpy(point).as_vec3()).collect::<Vec<Vec3>>();
    MeshData { positions, triangles, ..MeshData::default() }
}

/// The point of a sphere moved in and out by waves of two lengths.
fn bumpy(point: DVec3) -> DVec3 {
    let wave = |count: f64| sin(count * point.x) * sin(count * point.y + 1.0) * sin(count * point.z + 2.0);
    point * (1.0 + 0.2 * wave(5.0) + 0.03 * wave(31.0))
}

/// Twelve unit points and twenty triangles, counter-clockwise from outside.
fn icosahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points = Vec::new();
    for (a, b) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        points.extend([DVec3::new(a, b, 0.0), DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a)].map(DVec3::normalize));
    }
    // The faces are the triples at the least distance from each other.
    let edge = 2.1 / (1.0 + golden * golden).sqrt();
    let near = |i: usize, j: usize| points[i].distance(points[j]) < edge;
    let mut triangles = Vec::new();
    for i in 0..points.len() {
        for j in i + 1..points.len() {
            for k in j + 1..points.len() {
                if near(i, j) && near(j, k) && near(k, i) {
                    let outwards = (points[j] - points[i]).cross(points[k] - points[i]).dot(points[i]) > 0.0;
                    let [i, j, k] = [i, j, k].map(|index| index as u32);
                    triangles.push(if outwards { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    (points, triangles)
}

/// Cuts each triangle in four at the middles of its edges, which move to the sphere.
fn subdivide(points: &mut Vec<DVec3>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            points.push((points[a as usize] + points[b as usize]).normalize());
            points.len() as u32 - 1
        })
    };
    let mut smaller = Vec::with_capacity(4 * triangles.len());
    for &[a, b, c] in triangles {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        smaller.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    smaller
}

#[cfg(test)]
mod tests {
    use rt_geometry::Primitives;

    use super::*;

    #[test]
    fn subdivisions_are_whole() {
        assert_eq!(rock(80_000).unwrap().primitives.len(), 20 << 12);
    }

    #[test]
    fn the_icosahedron_is_closed() {
        let (points, triangles) = icosahedron();
        assert_eq!((points.len(), triangles.len()), (12, 20));
        let edges: Vec<_> = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))));
    }
}
