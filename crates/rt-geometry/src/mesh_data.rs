//! The plain arrays that meshes are made from.

use rt_math::transcendental::atan2;
use rt_math::{DVec3, Vec3};
use std::collections::HashMap;

/// The plain arrays of a mesh, as files hold them. Vertices stay `f32` in local space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Vertex indices of each triangle; counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// One normal for each position (any non-zero length), or empty for flat shading.
    pub normals: Vec<Vec3>,
    /// One texture coordinate for each position, `v` upwards, or empty.
    pub uvs: Vec<[f32; 2]>,
}

impl MeshData {
    /// Replaces the normals by smooth ones: the mean of the normals of all triangles around a vertex, weighted by
    /// their angle there (Thürmer, Wüthrich, "Computing Vertex Normals from Polygonal Facets", 1998), so that it does
    /// not depend on how a flat face was cut into triangles.
    ///
    /// Vertices at the same position share their normal, lest seams between texture charts show. Triangles that name
    /// missing vertices are passed over; vertices that only they or no triangles touch get a zero normal, which
    /// [`TriangleMesh::build`](crate::TriangleMesh::build) mends where it matters.
    pub fn smooth_normals(&mut self) {
        let mut sums: HashMap<[u32; 3], DVec3> = HashMap::new();
        for triangle in &self.triangles {
            let Some(corners) = corner_positions(&self.positions, *triangle) else { continue };
            for k in 0..3 {
                let [at, next, last] = [0, 1, 2].map(|i| corners[(k + i) % 3].as_dvec3());
                let (e, f) = (next - at, last - at);
                let area = e.cross(f);
                if let Some(normal) = area.try_normalize() {
                    let angle = atan2(area.length(), e.dot(f));
                    *sums.entry(place(corners[k])).or_default() += normal * angle;
                }
            }
        }
        let smooth = |p: &Vec3| sums.get(&place(*p)).map_or(Vec3::ZERO, |sum| sum.normalize_or_zero().as_vec3());
        self.normals = self.positions.iter().map(smooth).collect();
    }
}

/// The corners of a triangle; `None` if it names a vertex that is not there.
fn corner_positions(positions: &[Vec3], triangle: [u32; 3]) -> Option<[Vec3; 3]> {
    let corner = |i: u32| positions.get(i as usize).copied();
    Some([corner(triangle[0])?, corner(triangle[1])?, corner(triangle[2])?])
}

/// A position as a key: equal for equal coordinates, 0 and −0 included.
fn place(position: Vec3) -> [u32; 3] {
    position.to_array().map(|x| (x + 0.0).to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit cube of twelve triangles; its faces are cut along diagonals that leave some corners with one triangle
    /// of a face, others with two.
    fn cube() -> MeshData {
        let positions = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        MeshData { positions, triangles, ..MeshData::default() }
    }

    #[test]
    fn corners_of_a_cube_point_along_its_diagonals_however_the_faces_are_cut() {
        let mut cube = cube();
        cube.smooth_normals();
        for (position, normal) in cube.positions.iter().zip(&cube.normals) {
            let diagonal = (*position - Vec3::splat(0.5)).normalize();
            assert!((*normal - diagonal).length() < 1e-6, "{normal} at {position}");
        }
    }

    #[test]
    fn seams_between_texture_charts_do_not_show() {
        let mut cut = cube();
        let smooth = {
            let mut whole = cube();
            whole.smooth_normals();
            whole.normals
        };
        // Each triangle gets vertices of its own, as after splitting by texture coordinate.
        cut.positions = cut.triangles.iter().flatten().map(|&i| cut.positions[i as usize]).collect();
        let corners: Vec<u32> = cut.triangles.iter().flatten().copied().collect();
        cut.triangles = (0..12).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        cut.positions[0] = -cut.positions[0].abs(); // −0 is the same place as 0.
        cut.smooth_normals();
        for (normal, corner) in cut.normals.iter().zip(corners) {
            assert_eq!(*normal, smooth[corner as usize]);
        }
    }

    #[test]
    fn bad_triangles_are_passed_over() {
        let mut data = MeshData {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NAN, Vec3::ONE],
            triangles: vec![[0, 1, 2], [0, 1, 99], [0, 1, 1], [0, 1, 3]],
            ..MeshData::default()
        };
        data.smooth_normals();
        assert_eq!(data.normals, [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::ZERO, Vec3::ZERO]);
    }
}
