//! Welding: merges vertices that files split by normals or texture coordinates.

use rt_geometry::{MeshData, TriangleMesh};
use rt_math::{DVec3, Vec3};

/// Triangles of a mesh after merging vertices at the same position.
#[derive(Debug)]
pub(crate) struct Welded {
    /// For each corner the lowest index of a vertex at its position.
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Welded {
    pub(crate) fn new(data: &MeshData) -> Self {
        // Adding 0 makes −0 a 0.
        let bits = |x: f32| (x + 0.0).to_bits();
        let key = |(p, i): (&Vec3, u32)| [bits(p.x), bits(p.y), bits(p.z), i];
        let mut vertices: Vec<_> = data.positions.iter().zip(0..).map(key).collect();
        vertices.sort_unstable();
        let mut first = vec![0; vertices.len()];
        for same in vertices.chunk_by(|a, b| a[..3] == b[..3]) {
            for &[.., vertex] in same {
                first[vertex as usize] = same[0][3];
            }
        }
        Self { triangles: data.triangles.iter().map(|corners| corners.map(|i| first[i as usize])).collect() }
    }

    /// For each triangle its corners in increasing order, and 1 if that reverses its orientation, else 0; sorted.
    pub(crate) fn sorted_keys(&self) -> Vec<[u32; 4]> {
        let key = |triangle: &[u32; 3]| {
            let mut corners = *triangle;
            let first = (0..3).fold(0, |i, k| if corners[k] < corners[i] { k } else { i });
            corners.rotate_left(first);
            match corners {
                [a, b, c] if b > c => [a, c, b, 1],
                [a, b, c] => [a, b, c, 0],
            }
        };
        let mut keys: Vec<_> = self.triangles.iter().map(key).collect();
        keys.sort_unstable();
        keys
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
