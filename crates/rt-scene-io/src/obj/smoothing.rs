//! Normals for files that give none.

use std::collections::HashMap;

use rt_geometry::MeshData;
use rt_math::{DVec3, Vec3};

use crate::limits;

/// Smoothness of a surface in the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Smoothing {
    /// Not specified. Edges are smoothed below an angle of 41°, so that curved models are smooth and boxes keep their
    /// edges.
    #[default]
    Unspecified,
    /// `s off` or `s 0`: flat faces.
    Off,
    /// Faces of the same group share normals, however sharp the edge.
    Group(u32),
}

/// Cosine of the maximum angle between two faces whose edge is smoothed by default. The angle is below the 45° of chamfers
/// and octagonal prisms, and above the 30° of a twelve-sided cylinder.
const CREASE_COSINE: f64 = 0.75;

/// Adds normals to those of `meshes` without normals. Together, the meshes are one surface.
///
/// A normal is the area-weighted sum over the faces around the corner. Faces are adjacent where their positions are equal, so
/// that texture seams, unshared vertices and boundaries of meshes do not show. A vertex with several normals is duplicated.
pub(super) fn add_normals(mut meshes: Vec<&mut MeshData>, smoothing: Smoothing) {
    let crease = match smoothing {
        Smoothing::Off => return,
        Smoothing::Unspecified => Some(CREASE_COSINE),
        Smoothing::Group(_) => None,
    };
    if meshes.iter().all(|mesh| !mesh.normals.is_empty()) {
        return;
    }
    let faces = FaceAdjacency::new(&meshes);
    let (mut face, mut first_vertex) = (0, 0);
    for mesh in &mut meshes {
        let [face_count, vertex_count] = [mesh.triangles.len(), mesh.positions.len()];
        if mesh.normals.is_empty() {
            **mesh = with_normals(mesh, |i, vertex| faces.normal_at(face + i, first_vertex + vertex, crease).as_vec3());
        }
        face += face_count;
        first_vertex += vertex_count;
    }
}

/// A mesh with the normals of `normal_at`, a function of indices of a triangle and one of its vertices.
fn with_normals(mesh: &MeshData, normal_at: impl Fn(usize, usize) -> Vec3) -> MeshData {
    let mut out = MeshData { triangles: mesh.triangles.clone(), ..MeshData::default() };
    let mut known: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    for (face, triangle) in out.triangles.iter_mut().enumerate() {
        for vertex in triangle {
            let normal = normal_at(face, *vertex as usize);
            let index = *known.entry((*vertex, normal.to_array().map(f32::to_bits))).or_insert_with(|| {
                out.positions.push(mesh.positions[*vertex as usize]);
                out.normals.push(normal);
                out.uvs.extend(mesh.uvs.get(*vertex as usize));
                out.colors.extend(mesh.colors.get(*vertex as usize));
                (out.positions.len() - 1) as u32
            });
            *vertex = index;
        }
    }
    out
}

/// Faces around each point of several meshes. Indices of faces and vertices count through all of them.
struct FaceAdjacency {
    /// Unit normal and area of each; zero for faces without area.
    normals: Vec<(DVec3, f64)>,
    /// The point at which a vertex stands.
    point_of_vertex: Vec<u32>,
    /// Faces around point `i` are `around[starts[i]..starts[i + 1]]`.
    starts: Vec<usize>,
    around: Vec<u32>,
    /// Sum over all faces around a point.
    sums: Vec<DVec3>,
}

impl FaceAdjacency {
    fn new(meshes: &[&mut MeshData]) -> Self {
        let mut points = HashMap::new();
        // Adding zero makes −0 equal to 0.
        let key = |p: &Vec3| (*p + Vec3::ZERO).to_array().map(f32::to_bits);
        let point_of_vertex: Vec<u32> = meshes
            .iter()
            .flat_map(|mesh| &mesh.positions)
            .map(|p| {
                let next = points.len() as u32;
                *points.entry(key(p)).or_insert(next)
            })
            .collect();
        let normals: Vec<(DVec3, f64)> =
            meshes.iter().flat_map(|mesh| mesh.triangles.iter().map(|t| normal_and_area(mesh, t))).collect();

        // The vertices of each triangle.
        let corners = || {
            let mut first_vertex = 0;
            meshes.iter().flat_map(move |mesh| {
                let first = first_vertex;
                first_vertex += mesh.positions.len();
                mesh.triangles.iter().map(move |triangle| triangle.map(|vertex| first + vertex as usize))
            })
        };
        let points_of = |triangle: [usize; 3]| triangle.map(|vertex| point_of_vertex[vertex] as usize);
        let mut starts = vec![0; points.len() + 1];
        let mut sums = vec![DVec3::ZERO; points.len()];
        for (triangle, (normal, area)) in corners().zip(&normals) {
            for point in points_of(triangle) {
                starts[point + 1] += 1;
                sums[point] += *normal * *area;
            }
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut around = vec![0; 3 * normals.len()];
        for (face, triangle) in corners().enumerate() {
            for point in points_of(triangle) {
                around[next[point]] = face as u32;
                next[point] += 1;
            }
        }
        Self { normals, point_of_vertex, starts, around, sums }
    }

    /// The unit normal of `face` at its `vertex`; zero if the face has no area.
    fn normal_at(&self, face: usize, vertex: usize, crease: Option<f64>) -> DVec3 {
        let point = self.point_of_vertex[vertex] as usize;
        let own = self.normals[face].0;
        let sum = match crease {
            None => self.sums[point],
            Some(cosine) => {
                let around = &self.around[self.starts[point]..self.starts[point + 1]];
                if around.len() > limits::CREASED_FACES {
                    return own;
                }
                let gentle = around.iter().map(|&i| self.normals[i as usize]).filter(|(n, _)| n.dot(own) >= cosine);
                gentle.fold(DVec3::ZERO, |sum, (normal, area)| sum + normal * area)
            }
        };
        // Opposite faces cancel each other out.
        sum.try_normalize().unwrap_or(own)
    }
}

fn normal_and_area(mesh: &MeshData, triangle: &[u32; 3]) -> (DVec3, f64) {
    let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
    let cross = (b - a).cross(c - a);
    match cross.try_normalize() {
        Some(normal) => (normal, cross.length() / 2.0),
        None => (DVec3::ZERO, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two unit squares that meet along the y axis; the second rises by a slope.
    fn roof(slope: f32) -> MeshData {
        MeshData {
            positions: [[0., 0., 0.], [-1., 0., 0.], [-1., 1., 0.], [0., 1., 0.], [1., 0., slope], [1., 1., slope]]
                .map(Vec3::from)
                .to_vec(),
            triangles: vec![[1, 0, 3], [1, 3, 2], [0, 4, 5], [0, 5, 3]],
            ..MeshData::default()
        }
    }

    fn smoothed(mut mesh: MeshData, smoothing: Smoothing) -> MeshData {
        add_normals(vec![&mut mesh], smoothing);
        mesh
    }

    #[test]
    fn gentle_edges_are_smoothed_and_sharp_ones_kept() {
        let gentle = smoothed(roof(0.5), Smoothing::Unspecified);
        assert_eq!(gentle.positions.len(), 6, "no vertex is repeated");
        let ridge = gentle.normals[1].as_dvec3();
        // The sum of (0, 0, 1) and (−1/2, 0, 1), which is area times normal of each side.
        assert!((ridge - DVec3::new(-0.5, 0.0, 2.0).normalize()).length() < 0.13);
        assert!(ridge.x < -0.1);

        let sharp = smoothed(roof(2.0), Smoothing::Unspecified);
        assert_eq!(sharp.positions.len(), 8, "the two vertices of the ridge are repeated");
        let flat = DVec3::new(-2.0, 0.0, 1.0).normalize().as_vec3();
        assert!(sharp.normals.iter().all(|n| (*n - Vec3::Z).length() < 1e-6 || (*n - flat).length() < 1e-6));
    }

    /// The normals of files were replaced by computed ones.
    #[test]
    fn normals_that_a_file_gives_are_kept() {
        let tilted = Vec3::new(0.6, 0.0, 0.8);
        let given = MeshData { normals: vec![tilted; 6], ..roof(0.5) };
        for smoothing in [Smoothing::Unspecified, Smoothing::Group(1), Smoothing::Off] {
            assert_eq!(smoothed(given.clone(), smoothing), given);
        }
    }

    #[test]
    fn a_smoothing_group_ignores_the_angle_and_off_ignores_all() {
        let group = smoothed(roof(2.0), Smoothing::Group(1));
        assert_eq!(group.positions.len(), 6);
        assert!(group.normals[1].x < -0.1);
        assert_eq!(smoothed(roof(2.0), Smoothing::Off), roof(2.0));
    }

    #[test]
    fn vertices_at_the_same_place_smooth_across_a_seam() {
        let shared = roof(0.5);
        let corners: Vec<u32> = shared.triangles.iter().flatten().copied().collect();
        let soup = MeshData {
            positions: corners.iter().map(|&i| shared.positions[i as usize]).collect(),
            triangles: (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            uvs: (0..12).map(|i| [i as f32, 0.0]).collect(),
            ..MeshData::default()
        };
        let (a, b) = (smoothed(shared, Smoothing::Unspecified), smoothed(soup, Smoothing::Unspecified));
        for (s, t) in a.triangles.iter().flatten().zip(b.triangles.iter().flatten()) {
            assert_eq!(a.normals[*s as usize], b.normals[*t as usize]);
        }
        assert_eq!(b.uvs.len(), b.positions.len());
    }

    #[test]
    fn a_hub_of_many_faces_takes_linear_time() {
        let rim = 200_000;
        let mut positions = vec![Vec3::ZERO];
        positions.extend((0..rim).map(|i| Vec3::new(1.0, i as f32, (i % 3) as f32)));
        let triangles = (1..rim).map(|i| [0, i, i + 1]).collect();
        let mesh = MeshData { positions, triangles, ..MeshData::default() };
        let smooth = smoothed(mesh, Smoothing::Unspecified);
        assert_eq!(smooth.normals.len(), smooth.positions.len());
    }
}
