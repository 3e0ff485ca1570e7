//! Meshes from strips, fans and faces with many corners.

use crate::{MeshData, MeshError, triangulator::Face, triangulator::Triangulator};
use rt_math::Vec3;

/// Triangles of a strip: each vertex after the second forms one with the two before it. Every other one is flipped, so
/// that all have the orientation of the first.
///
/// ```text
///   0───2───4       (0 1 2) (1 3 2) (2 3 4)
///    ╲ ╱ ╲ ╱
///     1───3
/// ```
pub fn strip(order: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    order.windows(3).enumerate().map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] })
}

/// Triangles of a fan: each vertex after the second forms one with the vertex before it and the first, which is named
/// last.
pub fn fan(order: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    let (hub, rim) = order.split_at(order.len().min(1));
    rim.windows(2).flat_map(|pair| hub.iter().map(|hub| [pair[0], pair[1], *hub]))
}

impl MeshData {
    /// Maximum number of corners of a face: triangulation may take quadratic time.
    pub const MAX_CORNERS: usize = 100_000;

    /// Mesh of a triangle strip, and the number of triangles without area that are left out. Strips are joined by
    /// repeated vertices.
    pub fn from_strip(positions: Vec<Vec3>) -> (Self, usize) {
        Self::stitched(positions, |order| strip(order).collect())
    }

    /// Mesh of a triangle fan, and the number of triangles that are left out because a vertex is repeated.
    pub fn from_fan(positions: Vec<Vec3>) -> (Self, usize) {
        Self::stitched(positions, |order| fan(order).collect())
    }

    fn stitched(positions: Vec<Vec3>, triangles: impl Fn(&[u32]) -> Vec<[u32; 3]>) -> (Self, usize) {
        let order: Vec<u32> = (0..).take(positions.len()).collect();
        let mut triangles = triangles(&order);
        let all = triangles.len();
        triangles.retain(|triangle| {
            let [a, b, c] = triangle.map(|i| positions[i as usize]);
            a != b && b != c && c != a
        });
        let left_out = all - triangles.len();
        (Self { positions, triangles, ..Self::default() }, left_out)
    }

    /// Mesh of flat faces, which may be concave and have holes. They are triangulated in the planes of their outlines:
    /// convex ones as fans, others by ear clipping. Sources: Meisters, "Polygons have ears", 1975; Eberly,
    /// "Triangulation by Ear Clipping", 2002.
    ///
    /// A face whose outline has no area, or with a NaN or infinite corner, becomes the fan of its outline.
    /// [`TriangleMesh::build`](crate::TriangleMesh::build) drops and counts unusable triangles.
    ///
    /// # Errors
    /// If a ring has fewer than three corners or an invalid vertex, or a face has more than
    /// [`MAX_CORNERS`](Self::MAX_CORNERS).
    pub fn from_polygons<'a>(
        positions: Vec<Vec3>,
        faces: impl IntoIterator<Item = Face<'a>>,
    ) -> Result<Self, MeshError> {
        let mut triangulator = Triangulator::new();
        let mut triangles = Vec::new();
        for (index, face) in faces.into_iter().enumerate() {
            check_face(index, &face, positions.len())?;
            triangulator.append(&positions, &face, &mut triangles);
        }
        Ok(Self { positions, triangles, ..Self::default() })
    }
}

fn check_face(index: usize, face: &Face<'_>, vertices: usize) -> Result<(), MeshError> {
    let rings = || std::iter::once(face.outline).chain(face.holes.iter().map(Vec::as_slice));
    if let Some(short) = rings().find(|ring| ring.len() < 3) {
        return Err(MeshError::TooFewCorners { face: index, count: short.len() });
    }
    let count = rings().map(<[u32]>::len).sum();
    if count > MeshData::MAX_CORNERS {
        return Err(MeshError::TooManyCorners { face: index, count, limit: MeshData::MAX_CORNERS });
    }
    match rings().flatten().find(|&&vertex| vertex as usize >= vertices) {
        Some(&vertex) => Err(MeshError::BadCorner { face: index, vertex, count: vertices }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Hit, NoProbe, Primitives, TriangleMesh, intersect_primitive};
    use rt_math::transcendental::sincos;
    use rt_math::{DVec3, Interval, Ray, SlabRay};
    use std::f64::consts::TAU;

    #[test]
    fn strips_and_fans_keep_their_orientation() {
        let strips: Vec<_> = strip(&[0, 1, 2, 3, 4]).collect();
        assert_eq!(strips, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        let fans: Vec<_> = fan(&[9, 1, 2, 3]).collect();
        assert_eq!(fans, [[1, 2, 9], [2, 3, 9]]);
        for short in [&[][..], &[0], &[0, 1]] {
            assert_eq!((strip(short).count(), fan(short).count()), (0, 0));
        }
    }

    #[test]
    fn stitches_are_left_out_and_counted() {
        let vertex = |i: u8| Vec3::new(f32::from(i / 2), f32::from(i % 2), 0.0);
        // The strip 0 1 2 3, then 6 7 8 9 further on, joined by repeating 3 and 6.
        let positions = [0, 1, 2, 3, 3, 6, 6, 7, 8, 9].map(vertex).to_vec();
        let (data, left_out) = MeshData::from_strip(positions);
        assert_eq!((data.triangles.len(), left_out), (4, 4));
        let (mesh, repairs) = TriangleMesh::build(data).expect("a mesh");
        assert_eq!(repairs.degenerate, 0);
        for x in [0.5, 3.5] {
            for index in 0..4 {
                let ray = Ray::new(DVec3::new(x, 0.4, 1.0), DVec3::NEG_Z);
                let Some(hit) = mesh.intersect(index, &ray, Interval::FORWARD) else { continue };
                let surface = mesh.surface(&ray, &hit, crate::InteractionFlags::ALL).expect("a surface");
                assert_eq!(surface.geometric_normal, DVec3::NEG_Z, "all face the side of the first");
            }
        }
        let (fan, left_out) = MeshData::from_fan([0, 2, 3, 3, 1].map(vertex).to_vec());
        assert_eq!((fan.triangles, left_out), (vec![[1, 2, 0], [3, 4, 0]], 1));
    }

    /// A ray at the vertex of all triangles hits them all at the same parameter; the first one wins.
    #[test]
    fn the_hub_of_a_huge_fan_is_hit_on_its_first_triangle() {
        const RIM: u32 = 100_000;
        let hub = Vec3::new(0.5, 0.25, 1.0);
        let corner = |i: u32| {
            let (sin, cos) = sincos(TAU * f64::from(i) / f64::from(RIM));
            hub + Vec3::new(4.0 * cos as f32, 4.0 * sin as f32, 0.0)
        };
        let (data, _) =
            MeshData::from_fan(std::iter::once(hub).chain((0..RIM).map(corner)).chain([corner(0)]).collect());
        let (mesh, repairs) = TriangleMesh::build(data).expect("a mesh");
        assert_eq!((mesh.len(), repairs.degenerate), (RIM as usize, 0));
        let down = Ray::new(DVec3::new(0.5, 0.25, 3.0), DVec3::NEG_Z);
        let slab = SlabRay::new(&down);
        let hits = || (0..RIM).filter_map(|i| intersect_primitive(&mesh, i, &slab, Interval::FORWARD, &mut NoProbe));
        assert!(hits().all(|hit| hit.t == 2.0) && hits().count() == RIM as usize);
        let first = |best: Option<Hit>, hit: Hit| best.filter(|best| best.t <= hit.t).or(Some(hit));
        assert_eq!(hits().fold(None, first).map(|hit| hit.primitive), Some(0));
        // From the side, the ray may miss the hub by rounding, but hits some triangle.
        for k in 0..20 {
            let origin = DVec3::new(0.1 * f64::from(k), -0.3, 3.0);
            let ray = Ray::new(origin, hub.as_dvec3() - origin);
            assert!((0..RIM).any(|i| mesh.intersect(i, &ray, Interval::FORWARD).is_some()), "{k}");
        }
    }

    #[test]
    fn faces_become_triangles_of_their_vertices() {
        let positions: Vec<Vec3> =
            [[0., 0.], [4., 0.], [4., 4.], [2., 1.], [0., 4.]].map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
        let face = Face { outline: &[0, 1, 2, 3, 4], holes: &[] };
        let data = MeshData::from_polygons(positions.clone(), [face, Face { outline: &[0, 1, 2], holes: &[] }])
            .expect("faces");
        assert_eq!((data.positions.len(), data.triangles.len(), data.triangles[3]), (5, 4, [0, 1, 2]));
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            (b - a).cross(c - a).z / 2.0
        };
        assert_eq!(data.triangles[..3].iter().map(area).sum::<f32>(), 10.0, "a fan would have 14");
    }

    #[test]
    fn bad_faces_are_refused() {
        let faces = |outline: &[u32], holes: &[Vec<u32>]| {
            MeshData::from_polygons(vec![Vec3::ZERO, Vec3::X, Vec3::Y], [Face { outline, holes }])
        };
        assert_eq!(faces(&[0, 1], &[]), Err(MeshError::TooFewCorners { face: 0, count: 2 }));
        assert_eq!(faces(&[0, 1, 2], &[vec![]]), Err(MeshError::TooFewCorners { face: 0, count: 0 }));
        assert_eq!(faces(&[0, 1, 3], &[]), Err(MeshError::BadCorner { face: 0, vertex: 3, count: 3 }));
        let (count, limit) = (100_001, 100_000);
        assert_eq!(faces(&vec![0; count], &[]), Err(MeshError::TooManyCorners { face: 0, count, limit }));
        assert_eq!(faces(&[0, 1, 1], &[]).map(|data| data.triangles), Ok(vec![[0, 1, 1]]), "left to the mesh");
    }
}
