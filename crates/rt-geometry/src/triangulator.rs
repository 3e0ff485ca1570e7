//! Triangulation of polygons: fans for convex polygons, ear clipping for others.

use crate::area::polygon_area_vector;
use earcut::Earcut;
use rt_math::{DVec3, Frame, Vec3};

/// Corners that turn by less than this fraction of the sharpest one lie on a straight edge.
const STRAIGHT: f64 = 1.0 / 1024.0;

/// A flat face of a mesh by the indices of its corners, counter-clockwise seen from the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face<'a> {
    /// The corners of the outline: at least three.
    pub outline: &'a [u32],
    /// The corners of each hole, in either direction.
    pub holes: &'a [Vec<u32>],
}

/// Triangulates faces. Keeps its buffers from one face to the next.
pub(crate) struct Triangulator {
    earcut: Earcut<f64>,
    /// The corners of all rings in a row, without repeats, as indices, in space and in the plane of the face.
    corners: Vec<u32>,
    /// Those that are left out.
    repeated: Vec<u32>,
    points: Vec<DVec3>,
    flat: Vec<[f64; 2]>,
    hole_starts: Vec<u32>,
    ears: Vec<u32>,
}

impl Triangulator {
    pub(crate) fn new() -> Self {
        Self {
            earcut: Earcut::new(),
            corners: Vec::new(),
            repeated: Vec::new(),
            points: Vec::new(),
            flat: Vec::new(),
            hole_starts: Vec::new(),
            ears: Vec::new(),
        }
    }

    /// Appends the triangles of a face, with the orientation of its outline.
    ///
    /// A corner at the position of the corner before it is left out, and becomes a triangle without area. A face whose
    /// outline has no area, or with a NaN or infinite corner, becomes the fan of its outline. The mesh drops and counts
    /// unusable triangles. All rings must have at least three corners with valid indices.
    pub(crate) fn append(&mut self, positions: &[Vec3], face: &Face<'_>, triangles: &mut Vec<[u32; 3]>) {
        let mut outline = face.outline;
        let mut start = 0;
        if (outline.len() > 3 || !face.holes.is_empty()) && self.project(positions, face) {
            triangles.extend(self.repeated.iter().map(|corner| [*corner; 3]));
            let n = self.hole_starts.first().map_or(self.corners.len(), |start| *start as usize);
            let turn_at = |i: usize| turn(self.flat[(i + n - 1) % n], self.flat[i], self.flat[(i + 1) % n]);
            let (mut straightest, mut smallest, mut largest) = (0, turn_at(0), turn_at(0));
            for i in 1..n {
                if turn_at(i) < smallest {
                    (straightest, smallest) = (i, turn_at(i));
                }
                largest = largest.max(turn_at(i));
            }
            if smallest <= largest * STRAIGHT {
                start = straightest;
            }
            if !face.holes.is_empty() || (smallest < 0.0 && n > 4) {
                self.clip_ears(triangles);
                return;
            }
            outline = &self.corners[..n];
        }
        // Most programs begin the fan at the first corner, which is visible on faces that are not quite flat. From the
        // notch of a quadrilateral, or from a corner on a straight edge, all triangles of the fan are inside and no
        // corner is lost.
        let n = outline.len();
        let corner = |i: usize| outline[(start + i) % n];
        triangles.extend((1..n - 1).map(|i| [corner(0), corner(i), corner(i + 1)]));
    }

    fn clip_ears(&mut self, triangles: &mut Vec<[u32; 3]>) {
        let Self { earcut, corners, flat, hole_starts, ears, .. } = self;
        earcut.earcut_slice(flat, hole_starts, ears);
        triangles.extend(ears.chunks_exact(3).map(|ear| {
            let [a, b, c] = [ear[0] as usize, ear[1] as usize, ear[2] as usize];
            if turn(flat[a], flat[b], flat[c]) < 0.0 {
                [corners[a], corners[c], corners[b]]
            } else {
                [corners[a], corners[b], corners[c]]
            }
        }));
    }

    /// Projects all rings on the plane of the outline's normal, in which it runs counter-clockwise. False without area
    /// or for non-finite corners.
    fn project(&mut self, positions: &[Vec3], face: &Face<'_>) -> bool {
        self.corners.clear();
        self.repeated.clear();
        self.points.clear();
        self.hole_starts.clear();
        self.push_ring(positions, face.outline);
        let Some(area) = polygon_area_vector(&self.points) else { return false };
        for hole in face.holes {
            self.hole_starts.push(self.corners.len() as u32);
            self.push_ring(positions, hole);
        }
        let frame = Frame::from_z(area.normalize());
        // Relative to the first corner, so that small polygons far from the origin stay sharp.
        let origin = self.points[0];
        self.flat.clear();
        self.flat.extend(self.points.iter().map(|point| {
            let local = frame.to_local(*point - origin);
            [local.x, local.y]
        }));
        self.points.iter().all(|point| point.is_finite())
    }

    /// Appends the corners of a ring that are not at the position of the corner before them. Repeated corners would
    /// hide a notch: they turn by 0.
    fn push_ring(&mut self, positions: &[Vec3], ring: &[u32]) {
        let start = self.points.len();
        for corner in ring {
            let point = positions[*corner as usize].as_dvec3();
            if self.points[start..].last() == Some(&point) {
                self.repeated.push(*corner);
            } else {
                self.corners.push(*corner);
                self.points.push(point);
            }
        }
        while self.points.len() > start + 1 && self.points.last() == self.points.get(start) {
            self.repeated.extend(self.corners.pop());
            self.points.pop();
        }
    }
}

/// Twice the signed area of a triangle: positive if it runs counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangulated(polygon: &[[f32; 3]]) -> (f64, usize) {
        with_holes(polygon, &[])
    }

    /// The area of all triangles, and their number.
    fn with_holes(polygon: &[[f32; 3]], holes: &[&[[f32; 3]]]) -> (f64, usize) {
        let mut positions = Vec::new();
        let mut ring = |ring: &[[f32; 3]]| -> Vec<u32> {
            let start = positions.len() as u32;
            positions.extend(ring.iter().map(|&p| Vec3::from(p)));
            (start..positions.len() as u32).collect()
        };
        let outline = ring(polygon);
        let holes: Vec<Vec<u32>> = holes.iter().map(|hole| ring(hole)).collect();
        let mut triangles = Vec::new();
        Triangulator::new().append(&positions, &Face { outline: &outline, holes: &holes }, &mut triangles);
        let corners: Vec<DVec3> = outline.iter().map(|i| positions[*i as usize].as_dvec3()).collect();
        let normal = polygon_area_vector(&corners).expect("an area").normalize();
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| positions[i as usize].as_dvec3());
            let cross = (b - a).cross(c - a);
            // Signed: triangles with the wrong orientation or outside of the polygon change the sum.
            assert!(cross.dot(normal) > 0.0 || t[0] == t[1], "{t:?} is turned over");
            cross.length() / 2.0
        };
        (triangles.iter().map(area).sum(), triangles.len())
    }

    /// The fan began at the corner with the smallest turn, so that faces which are not quite flat differed from other
    /// programs.
    #[test]
    fn the_fan_of_a_convex_face_begins_at_its_first_corner() {
        let bent = [[-1.01, 0.0, 0.99], [-0.99, 0.0, -1.04], [-1.02, 1.99, -1.04], [-1.02, 1.99, 0.99]];
        let mut triangles = Vec::new();
        let face = Face { outline: &[0, 1, 2, 3], holes: &[] };
        Triangulator::new().append(&bent.map(Vec3::from), &face, &mut triangles);
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn convex_polygons_become_fans() {
        assert_eq!(triangulated(&[[0., 0., 0.], [2., 0., 0.], [2., 1., 0.], [0., 1., 0.]]), (2.0, 2));
    }

    #[test]
    fn a_concave_polygon_keeps_its_exact_area_whichever_way_it_faces() {
        // A 3 × 3 square without its upper middle: the fan from the first corner would cover 2 units too many.
        let u = [[0., 0.], [3., 0.], [3., 3.], [2., 3.], [2., 1.], [1., 1.], [1., 3.], [0., 3.]];
        let planes: [fn(f32, f32) -> [f32; 3]; 3] = [|x, y| [x, y, 5.0], |x, y| [y, -2.0, x], |x, y| [1e3, x, y]];
        for plane in planes {
            let mut polygon = u.map(|[x, y]| plane(x, y)).to_vec();
            assert_eq!(triangulated(&polygon).0, 7.0);
            polygon.reverse();
            assert_eq!(triangulated(&polygon).0, 7.0);
        }
    }

    #[test]
    fn holes_are_left_out_whichever_way_they_run() {
        let square = |low: f32, high: f32| [[low, 1., low], [low, 1., high], [high, 1., high], [high, 1., low]];
        let (outline, mut hole, other) = (square(0.0, 4.0), square(0.5, 1.5), square(2.0, 3.0));
        for _ in 0..2 {
            assert_eq!(with_holes(&outline, &[&hole, &other]).0, 14.0);
            hole.reverse();
        }
        // Three corners with a hole are not a triangle.
        assert_eq!(
            with_holes(&[[0., 0., 0.], [4., 0., 0.], [0., 4., 0.]], &[&[[1., 1., 0.], [1., 2., 0.], [2., 1., 0.]]]).0,
            7.5
        );
    }

    #[test]
    fn a_dart_is_cut_at_its_notch() {
        assert_eq!(triangulated(&[[0., 0., 0.], [2., 0., 0.], [0.5, 0.5, 0.], [0., 2., 0.]]), (1.0, 2));
    }

    #[test]
    fn a_bent_quadrilateral_with_a_straight_corner_keeps_both_triangles() {
        // From above, the second corner lies on the line between its neighbours; ear clipping would drop it.
        let (_, count) = triangulated(&[[0., 0., 0.], [1., 0., 0.25], [2., 0., 0.], [1., 2., 0.]]);
        assert_eq!(count, 2);
    }

    #[test]
    fn ears_of_the_largest_polygon_are_clipped_in_time() {
        let n = 100_000;
        let comb: Vec<[f32; 3]> = (0..n)
            .map(|i| match i {
                0 => [0., -1., 0.],
                1 => [n as f32, -1., 0.],
                _ => [(n - i) as f32, if i % 2 == 0 { 1. } else { 0. }, 0.],
            })
            .collect();
        assert!(triangulated(&comb).1 > n - 10);
    }

    #[test]
    fn corners_on_an_edge_are_allowed() {
        let (area, _) = triangulated(&[[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [2., 1., 0.], [0., 1., 0.]]);
        assert_eq!(area, 2.0);
    }

    /// The notch of a face with repeated corners was filled: the turn at a repeated corner is 0, so that the face
    /// became a fan.
    #[test]
    fn a_concave_face_with_repeated_corners_was_a_fan() {
        let u = [[0., 0.], [3., 0.], [3., 3.], [2., 3.], [2., 1.], [1., 1.], [1., 3.], [0., 3.]];
        let positions = u.map(|[x, y]| Vec3::new(x, y, 0.0));
        // All corners two times, as distinct vertices and as the same vertex.
        let (mut twice, mut triangles) = (Vec::new(), Vec::new());
        for (i, &[x, y]) in u.iter().enumerate() {
            twice.extend([[x, y, 0.0]; 2]);
            let outline: Vec<u32> = (0..8).flat_map(|k| vec![k; if k as usize == i { 3 } else { 2 }]).collect();
            triangles.clear();
            Triangulator::new().append(&positions, &Face { outline: &outline, holes: &[] }, &mut triangles);
            assert_eq!(triangles.iter().filter(|[a, b, _]| a != b).count(), 6);
            assert_eq!(triangles.len(), outline.len() - 2);
        }
        assert_eq!(triangulated(&twice), (7.0, 14));
        // The last corner is the first, in the outline and in a hole.
        let hole = [[0.25, 0.25], [0.25, 0.75], [0.75, 0.75], [0.75, 0.25]].map(|[x, y]| [x, y, 0.0]);
        twice.rotate_left(1);
        assert_eq!(triangulated(&twice), (7.0, 14));
        assert_eq!(with_holes(&twice, &[&[hole[0], hole[1], hole[2], hole[2], hole[3], hole[0]]]).0, 6.75);
    }

    #[test]
    fn triangles_of_a_face_with_repeated_corners_have_its_indices() {
        let square = [[0., 0., 0.], [0., 0., 0.], [2., 0., 0.], [2., 1., 0.], [0., 1., 0.]].map(Vec3::from);
        let mut triangles = Vec::new();
        Triangulator::new().append(&square, &Face { outline: &[4, 0, 1, 2, 2, 3], holes: &[] }, &mut triangles);
        assert_eq!(triangles, [[1, 1, 1], [2, 2, 2], [4, 0, 2], [4, 2, 3]]);
    }

    #[test]
    fn hopeless_polygons_are_left_to_the_mesh() {
        for bad in [f32::NAN, f32::INFINITY, 0.0] {
            let positions = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::splat(bad)];
            let mut triangles = Vec::new();
            Triangulator::new().append(&positions, &Face { outline: &[0, 1, 2, 3], holes: &[] }, &mut triangles);
            assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
        }
    }
}
