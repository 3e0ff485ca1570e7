//! Polygons to triangles: fans where the polygon is convex, ear clipping where it is not.

use earcut::Earcut;
use rt_math::{DVec3, Frame, Vec3};

/// Cuts polygons into triangles. It keeps its buffers from one polygon to the next.
pub(super) struct Triangulator {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    ears: Vec<u32>,
}

impl Triangulator {
    pub(super) fn new() -> Self {
        Self { earcut: Earcut::new(), flat: Vec::new(), ears: Vec::new() }
    }

    /// Appends the triangles of the polygon whose corners are `positions[corners[i]]`, with its orientation.
    ///
    /// A polygon without area, or with a NaN or infinite corner, becomes a fan: the mesh drops and counts the triangles
    /// that it cannot use. The corners must be valid indices, at least three.
    pub(super) fn append(&mut self, positions: &[Vec3], corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
        let n = corners.len();
        let mut start = 0;
        if n > 3 && self.project(positions, corners) {
            let turn_at = |i: usize| turn(self.flat[(i + n - 1) % n], self.flat[i], self.flat[(i + 1) % n]);
            let mut least = turn_at(0);
            for i in 1..n {
                if turn_at(i) < least {
                    (start, least) = (i, turn_at(i));
                }
            }
            if least < 0.0 && n > 4 {
                self.clip_ears(corners, triangles);
                return;
            }
        }
        // From the notch of a quadrilateral, or from a corner on a straight edge, all triangles of the fan lie inside
        // and no corner is lost, even if the polygon is bent.
        let corner = |i: usize| corners[(start + i) % n];
        triangles.extend((1..n - 1).map(|i| [corner(0), corner(i), corner(i + 1)]));
    }

    fn clip_ears(&mut self, corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
        self.earcut.earcut(self.flat.iter().copied(), &[], &mut self.ears);
        triangles.extend(self.ears.chunks_exact(3).map(|ear| {
            let [a, b, c] = [ear[0] as usize, ear[1] as usize, ear[2] as usize];
            if turn(self.flat[a], self.flat[b], self.flat[c]) < 0.0 {
                [corners[a], corners[c], corners[b]]
            } else {
                [corners[a], corners[b], corners[c]]
            }
        }));
    }

    /// Projects the polygon on the plane of its normal, where it runs counter-clockwise. False if it has no area or is
    /// not finite.
    fn project(&mut self, positions: &[Vec3], corners: &[u32]) -> bool {
        let corner = |i: &u32| positions[*i as usize].as_dvec3();
        // Relative to the first corner, so that small polygons far from the origin stay sharp.
        let origin = corner(&corners[0]);
        let Some(normal) = newell_normal(corners.iter().map(|i| corner(i) - origin)).try_normalize() else {
            return false;
        };
        let frame = Frame::from_z(normal);
        self.flat.clear();
        self.flat.extend(corners.iter().map(|i| {
            let local = frame.to_local(corner(i) - origin);
            [local.x, local.y]
        }));
        true
    }
}

/// Twice the signed area of a triangle: positive if it runs counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Newell's normal of a polygon that starts at the origin, of length twice the area; defined for concave and slightly
/// bent polygons as well (Tampieri, Graphics Gems III, 1992).
fn newell_normal(corners: impl Iterator<Item = DVec3>) -> DVec3 {
    let (mut previous, mut sum) = (DVec3::ZERO, DVec3::ZERO);
    for corner in corners {
        sum += previous.cross(corner);
        previous = corner;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangulated(polygon: &[[f32; 3]]) -> (f64, usize) {
        let positions: Vec<Vec3> = polygon.iter().map(|&p| Vec3::from(p)).collect();
        let corners: Vec<u32> = (0..polygon.len() as u32).collect();
        let mut triangles = Vec::new();
        Triangulator::new().append(&positions, &corners, &mut triangles);
        let normal = newell_normal(positions.iter().map(|p| (*p - positions[0]).as_dvec3())).normalize();
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| positions[i as usize].as_dvec3());
            let cross = (b - a).cross(c - a);
            // Signed: a triangle with the wrong orientation, or outside of the polygon, shows in the sum.
            assert!(cross.dot(normal) > 0.0, "{t:?} is turned over");
            cross.length() / 2.0
        };
        (triangles.iter().map(area).sum(), triangles.len())
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
    fn a_dart_is_cut_at_its_notch() {
        assert_eq!(triangulated(&[[0., 0., 0.], [2., 0., 0.], [0.5, 0.5, 0.], [0., 2., 0.]]), (1.0, 2));
    }

    #[test]
    fn a_bent_quadrilateral_with_a_straight_corner_keeps_both_triangles() {
        // Seen from above, the second corner lies on the line between its neighbours; ear clipping would drop it.
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

    #[test]
    fn hopeless_polygons_are_left_to_the_mesh() {
        for bad in [f32::NAN, f32::INFINITY, 0.0] {
            let positions = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::splat(bad)];
            let mut triangles = Vec::new();
            Triangulator::new().append(&positions, &[0, 1, 2, 3], &mut triangles);
            assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
        }
    }
}
