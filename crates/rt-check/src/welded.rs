//! Welding: merges vertices that files split by normals or texture coordinates.

use rt_geometry::{MeshData, TriangleMesh};
use rt_math::DVec3;

/// Triangles of a mesh after merging vertices at the same position.
#[derive(Debug)]
pub(crate) struct Welded {
    /// For each corner the lowest index of a vertex at its position.
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Welded {
    pub(crate) fn new(data: &MeshData) -> Self {
        // Adding 0 makes −0 a 0.
        let key = |i: &u32| data.positions[*i as usize].to_array().map(|x| (x + 0.0).to_bits());
        let mut order: Vec<u32> = (0..data.positions.len() as u32).collect();
        order.sort_unstable_by_key(|i| (key(i), *i));
        let mut first = vec![0; order.len()];
        for same in order.chunk_by(|a, b| key(a) == key(b)) {
            for &vertex in same {
                first[vertex as usize] = same[0];
            }
        }
        Self { triangles: data.triangles.iter().map(|corners| corners.map(|i| first[i as usize])).collect() }
    }
}

pub(crate) fn corners(mesh: &TriangleMesh, triangle: [u32; 3]) -> [DVec3; 3] {
    triangle.map(|i| mesh.data().positions[i as usize].as_dvec3())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::Vec3;

    #[test]
    fn vertices_in_one_place_become_one() {
        let data = MeshData {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X, -Vec3::ZERO, Vec3::Z],
            triangles: vec![[0, 1, 2], [3, 4, 5]],
            ..MeshData::default()
        };
        assert_eq!(Welded::new(&data).triangles, [[0, 1, 2], [1, 0, 5]]);
    }
}
