//! Tangents of meshes that come without (Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008).

use core::ops::Range;
use std::collections::HashMap;

use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use rt_geometry::MeshData;
use rt_math::{random::hash, transcendental::acos};

/// Tangents of a flat or degenerate neighbourhood, which has none.
const NONE: [f32; 4] = [0.0; 4];

/// Most corners at a position that the algorithm takes at once: its time grows with the square of their number.
const MAX_CORNERS: u32 = 1024;

/// Gives each vertex the tangent along which u of `uvs` rises, and the side on which v does. A vertex whose triangles
/// disagree is split. Without normals the triangles are flat. Where more than [`MAX_CORNERS`] meet at a position, triangles are divided
/// into parts, whose tangents do not depend on each other. Triangles whose corners are not finite, or not apart, get none.
pub(crate) fn generate(data: &mut MeshData, uvs: &[[f32; 2]]) {
    let faces = valid_faces(data);
    let mut tangents = vec![[NONE; 3]; faces.len()];
    for part in parts(data, &faces) {
        let (faces, tangents) = (&faces[part.clone()], &mut tangents[part]);
        // Infallible: the error type has no values.
        if generate_tangents(&mut Corners { data, uvs, faces, tangents }).is_err() {
            return;
        }
    }
    assign(data, &faces, &tangents);
}

/// Triangles whose corners are finite and apart. For each of the others, the algorithm would search all triangles.
fn valid_faces(data: &MeshData) -> Vec<usize> {
    let is_valid = |face: &usize| {
        let [a, b, c] = data.triangles[*face].map(|index| data.positions[index as usize]);
        a != b && b != c && c != a && [a, b, c].iter().all(|p| p.is_finite())
    };
    (0..data.triangles.len()).filter(is_valid).collect()
}

/// Divides triangles into parts in which at most [`MAX_CORNERS`] meet at a position. Positions are counted by a hash.
fn parts(data: &MeshData, faces: &[usize]) -> Vec<Range<usize>> {
    let n_counts = (3 * faces.len()).next_power_of_two();
    let mut counts = vec![0; n_counts];
    let slot = |index: u32| {
        // Both zeros are one position.
        let position = data.positions[index as usize].to_array().map(|x| x + 0.0);
        hash(&position.map(|x| u64::from(x.to_bits()))) as usize % n_counts
    };
    let mut parts: Vec<Range<usize>> = Vec::new();
    let mut first = 0;
    for (at, &face) in faces.iter().enumerate() {
        let slots = data.triangles[face].map(slot);
        if slots.iter().any(|&slot| counts[slot] >= MAX_CORNERS) {
            for &index in faces[first..at].iter().flat_map(|&face| &data.triangles[face]) {
                counts[slot(index)] = 0;
            }
            parts.push(first..at);
            first = at;
        }
        for slot in slots {
            counts[slot] += 1;
        }
    }
    parts.push(first..faces.len());
    parts
}

/// Stores one tangent for each vertex of these triangles, and copies vertices that need several.
fn assign(data: &mut MeshData, faces: &[usize], tangents: &[[[f32; 4]; 3]]) {
    data.tangents = vec![NONE; data.positions.len()];
    let mut copies: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    let mut taken = vec![false; data.positions.len()];
    for (&t, corners) in faces.iter().zip(tangents) {
        for (k, &tangent) in corners.iter().enumerate() {
            let vertex = data.triangles[t][k];
            if !std::mem::replace(&mut taken[vertex as usize], true) {
                data.tangents[vertex as usize] = tangent;
            } else if data.tangents[vertex as usize] != tangent {
                let key = (vertex, tangent.map(f32::to_bits));
                data.triangles[t][k] = *copies.entry(key).or_insert_with(|| split(data, vertex, tangent));
            }
        }
    }
}

/// Appends a copy of a vertex with a tangent of its own.
fn split(data: &mut MeshData, vertex: u32, tangent: [f32; 4]) -> u32 {
    let copy = data.positions.len() as u32;
    data.positions.push(data.positions[vertex as usize]);
    again(&mut data.normals, vertex);
    again(&mut data.uvs, vertex);
    again(&mut data.second_uvs, vertex);
    again(&mut data.colors, vertex);
    data.tangents.push(tangent);
    copy
}

/// Appends a copy of an element, if there is a list.
fn again<T: Copy>(list: &mut Vec<T>, element: u32) {
    if let Some(&value) = list.get(element as usize) {
        list.push(value);
    }
}

/// View of some triangles of a mesh for the algorithm: corner by corner.
struct Corners<'a> {
    data: &'a MeshData,
    uvs: &'a [[f32; 2]],
    /// Indices of the triangles.
    faces: &'a [usize],
    tangents: &'a mut [[[f32; 4]; 3]],
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.data.triangles[self.faces[face]][corner] as usize
    }
}

impl Geometry<Portable> for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.faces.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.data.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        match self.data.normals.get(self.vertex(face, corner)) {
            Some(normal) => normal.normalize_or_zero().to_array(),
            None => {
                let [a, b, c] =
                    self.data.triangles[self.faces[face]].map(|i| self.data.positions[i as usize].as_dvec3());
                (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array()
            }
        }
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs[self.vertex(face, corner)]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let tangent = space.map_or(NONE, |space| space.tangent_encoded());
        self.tangents[face][corner] = if tangent.iter().all(|x| x.is_finite()) { tangent } else { NONE };
    }
}

/// Functions that differ between platforms.
enum Portable {}

impl Ops for Portable {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    fn acos(x: f32) -> f32 {
        acos(f64::from(x)) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::Vec3;
    use rt_math::transcendental::{cos, sin};

    /// The unit square in z = 0, seen from +z, u along y and v against x, unless mirrored.
    fn square(mirror: f32) -> MeshData {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let uvs = positions.iter().map(|p| [p.y, -p.x * mirror]).collect();
        let normals = vec![Vec3::Z; 4];
        MeshData { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], normals, uvs, ..MeshData::default() }
    }

    fn along_first(data: &mut MeshData) {
        let uvs = data.uvs.clone();
        generate(data, &uvs);
    }

    #[test]
    fn tangents_point_where_u_rises() {
        let mut data = square(1.0);
        along_first(&mut data);
        assert_eq!(data.tangents, [[0.0, 1.0, 0.0, 1.0]; 4], "n × t = −x, where v rises");
        let mut mirrored = square(-1.0);
        along_first(&mut mirrored);
        assert_eq!(mirrored.tangents, [[0.0, 1.0, 0.0, -1.0]; 4]);
    }

    #[test]
    fn flat_triangles_have_tangents_as_well() {
        let mut flat = MeshData { normals: Vec::new(), ..square(1.0) };
        along_first(&mut flat);
        assert_eq!((flat.tangents, flat.positions.len()), (vec![[0.0, 1.0, 0.0, 1.0]; 4], 4));
    }

    #[test]
    fn vertices_on_a_seam_are_split() {
        // The second triangle is mirrored in texture space, so that the shared edge has two sides.
        let mut data = square(1.0);
        data.uvs[3] = [0.0, -1.0];
        data.colors = vec![[0.5; 4]; 4];
        along_first(&mut data);
        assert_eq!(data.triangles, [[0, 1, 2], [4, 5, 3]]);
        assert_eq!(data.positions[4..], [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)]);
        let lengths = [data.normals.len(), data.uvs.len(), data.colors.len(), data.tangents.len()];
        assert_eq!((lengths, data.second_uvs.len()), ([6; 4], 0));
        assert_ne!(data.tangents[0][3], data.tangents[4][3]);
    }

    /// The time of the algorithm grows with the square of the triangles around a vertex.
    #[test]
    fn triangles_around_a_hub_are_divided_into_parts() {
        let n = 10_000u32;
        let at = |i: u32| core::f32::consts::TAU * i as f32 / n as f32;
        let rim = (0..=n).map(|i| Vec3::new(cos(f64::from(at(i))) as f32, sin(f64::from(at(i))) as f32, 0.0));
        let positions: Vec<Vec3> = core::iter::once(Vec3::ZERO).chain(rim).collect();
        let uvs = positions.iter().map(|p| [p.x, p.y]).collect();
        let triangles: Vec<[u32; 3]> = (1..=n).map(|i| [0, i, i + 1]).collect();
        // Copies of a vertex count as one.
        let positions_of_copies = triangles.iter().flatten().map(|&i| positions[i as usize]).collect();
        let copies = (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let unshared = MeshData { positions: positions_of_copies, triangles: copies, ..MeshData::default() };
        let mut fan = MeshData { positions, triangles, uvs, ..MeshData::default() };
        for data in [&fan, &unshared] {
            let parts = parts(data, &valid_faces(data));
            assert!((10..12).contains(&parts.len()), "{} parts", parts.len());
            assert!(parts.iter().all(|part| part.len() <= MAX_CORNERS as usize));
            assert_eq!((parts[0].start, parts.last().map(|part| part.end)), (0, Some(n as usize)));
            assert!(parts.windows(2).all(|pair| pair[0].end == pair[1].start));
        }
        along_first(&mut fan);
        let along_x = |[x, y, z, w]: [f32; 4]| x > 0.999 && y.abs() < 1e-3 && (z, w) == (0.0, 1.0);
        assert!(fan.tangents.iter().all(|&tangent| along_x(tangent)), "{:?}", fan.tangents);
        for (whole, count) in [(square(1.0), 2), (MeshData::default(), 0)] {
            assert_eq!(parts(&whole, &valid_faces(&whole)), vec![Range { start: 0, end: count }]);
        }
    }

    /// The algorithm compares each of them with all other triangles.
    #[test]
    fn triangles_without_extent_or_finite_corners_are_left_out() {
        let mut data = square(1.0);
        data.positions.extend([Vec3::new(f32::NAN, 0.0, 0.0), Vec3::new(0.0, -0.0, 0.0)]);
        data.normals.resize(6, Vec3::Z);
        data.uvs.resize(6, [0.0; 2]);
        data.triangles = vec![[0, 0, 1], [0, 1, 2], [0, 5, 1], [4, 1, 2], [0, 2, 3]];
        assert_eq!(valid_faces(&data), [1, 4]);
        along_first(&mut data);
        assert_eq!(data.tangents[..4], [[0.0, 1.0, 0.0, 1.0]; 4]);
        assert_eq!((data.tangents.len(), data.positions.len()), (6, 6), "no vertex is copied for them");
    }

    #[test]
    fn coordinates_that_do_not_vary_have_no_tangents() {
        let mut data = square(1.0);
        data.uvs = vec![[0.5; 2]; 4];
        data.positions[1] = Vec3::NAN;
        along_first(&mut data);
        assert!(data.tangents.iter().flatten().all(|x| x.is_finite()), "{:?}", data.tangents);
    }
}
