//! Vertex and index arrays of meshes.

use rt_math::transcendental::atan2;
use rt_math::{DVec3, Vec3};
use std::cmp::Ordering;
use std::collections::HashMap;

/// Arrays of a mesh, as files hold them. Vertices stay `f32` in local space.
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
    /// A second set of texture coordinates, or empty.
    pub second_uvs: Vec<[f32; 2]>,
    /// One colour for each position: linear red, green and blue, and alpha; or empty.
    pub colors: Vec<[f32; 4]>,
    /// One tangent for each position (any non-zero length), in the direction of rising `u` of the normal map, or empty.
    /// The last number is 1 if the cross product of normal and tangent points to rising `v`, and −1 otherwise.
    pub tangents: Vec<[f32; 4]>,
}

impl MeshData {
    /// Replaces the normals by smooth ones: the mean of the normals of all triangles around a vertex, weighted by their
    /// angle there. They are independent of the triangulation of flat faces (Thürmer, Wüthrich, "Computing Vertex
    /// Normals from Polygonal Facets", 1998).
    ///
    /// Vertices at the same position share their normal, so that seams between texture charts stay invisible. Triangles
    /// with invalid vertices are skipped; vertices without valid triangles get a zero normal, which
    /// [`TriangleMesh::build`](crate::TriangleMesh::build) replaces where necessary.
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

impl MeshData {
    /// True if vertices have a second set of texture coordinates, colours or tangents: the attributes of
    /// [`VertexAttributes`](crate::VertexAttributes).
    #[inline]
    pub fn has_attributes(&self) -> bool {
        !(self.second_uvs.is_empty() && self.colors.is_empty() && self.tangents.is_empty())
    }

    /// True if every edge of a triangle has a counterpart of opposite direction, so that the mesh encloses space (or is
    /// empty). Vertices at the same position are one.
    ///
    /// Each edge adds its hash and its reverse subtracts it, so that nothing is stored. The probability of taking an
    /// open mesh for closed is 2⁻⁶⁴.
    pub fn is_closed(&self) -> bool {
        let sum = self.triangles.iter().fold(0u64, |sum, triangle| {
            let Some(corners) = corner_positions(&self.positions, *triangle) else { return sum };
            let [a, b, c] = corners.map(place);
            [(a, b), (b, c), (c, a)].into_iter().fold(sum, |sum, edge| sum.wrapping_add(edge_hash(edge)))
        });
        sum == 0
    }
}

/// Minus the hash of the edge's reverse; 0 of an edge without length.
fn edge_hash((from, to): ([u32; 3], [u32; 3])) -> u64 {
    let hash = |[a, b, c]: [u32; 3], [d, e, f]: [u32; 3]| {
        let pair = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
        rt_math::random::hash(&[pair(a, b), pair(c, d), pair(e, f)])
    };
    match from.cmp(&to) {
        Ordering::Less => hash(from, to),
        Ordering::Greater => hash(to, from).wrapping_neg(),
        Ordering::Equal => 0,
    }
}

/// Corners of a triangle; `None` for an invalid vertex.
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
    fn closed_meshes_are_distinguished_from_open_ones() {
        let mut mesh = cube();
        assert!(mesh.is_closed() && MeshData::default().is_closed());
        mesh.triangles[3].swap(0, 1);
        assert!(!mesh.is_closed(), "one triangle faces the other way");
        mesh.triangles[3].swap(0, 1);
        // Seams: separate vertices for one triangle, at the same positions.
        let corners = mesh.triangles[5];
        mesh.positions.extend(corners.map(|i| mesh.positions[i as usize]));
        mesh.triangles[5] = [8, 9, 10];
        assert!(mesh.is_closed());
        mesh.triangles.pop();
        assert!(!mesh.is_closed(), "one triangle is missing");
    }

    #[test]
    fn seams_between_texture_charts_do_not_show() {
        let mut cut = cube();
        let smooth = {
            let mut whole = cube();
            whole.smooth_normals();
            whole.normals
        };
        // Separate vertices for each triangle, as after splitting by texture coordinate.
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
