//! Nearest points of surfaces.

use crate::{
    ClosestPoint, Sphere, Spheres, TriangleMesh,
    area::{area_vector, unit_normal},
};
use rt_math::DVec3;

/// Point of a triangle nearest to `point`.
///
/// Ericson, "Real-Time Collision Detection", 2005, section 5.1.5, classifies the point by Voronoi regions of the
/// vertices, the edges and the face. Here the best point of the three edges is compared with the foot in the face.
/// Rounding confuses the regions of slivers, and then costs only the rounding of a foot.
pub fn nearest_on_triangle(vertices: [DVec3; 3], point: DVec3) -> DVec3 {
    let [a, b, c] = vertices;
    let edges = [[a, b], [b, c], [c, a]].map(|[from, to]| nearest_on_segment(from, to, point));
    let nearer = |best: DVec3, other: DVec3| {
        if other.distance_squared(point) < best.distance_squared(point) { other } else { best }
    };
    let on_edges = nearer(nearer(edges[0], edges[1]), edges[2]);
    foot_in_face(vertices, point).map_or(on_edges, |foot| nearer(on_edges, foot))
}

fn nearest_on_segment(from: DVec3, to: DVec3, point: DVec3) -> DVec3 {
    let along = to - from;
    let part = (point - from).dot(along) / along.length_squared();
    // From the nearer end, which keeps both ends exact. A segment without length has a NaN for its part.
    if part >= 1.0 {
        to
    } else if part > 0.5 {
        to - along * (1.0 - part)
    } else if part > 0.0 {
        from + along * part
    } else {
        from
    }
}

/// The foot of the perpendicular from the point, if it lies in the triangle. `None` for a triangle without area.
fn foot_in_face([a, b, c]: [DVec3; 3], point: DVec3) -> Option<DVec3> {
    if area_vector([a, b, c]) == DVec3::ZERO {
        return None;
    }
    let normal = unit_normal([a, b, c]);
    let foot_of = |point: DVec3| point - normal * (point - a).dot(normal);
    // The foot of a far point is off the plane by the rounding of its distance; the foot of that one is not.
    let foot = foot_of(foot_of(point));
    let is_left = |from: DVec3, to: DVec3| (to - from).cross(foot - from).dot(normal) >= 0.0;
    (is_left(a, b) && is_left(b, c) && is_left(c, a)).then_some(foot)
}

/// Point of a sphere's surface nearest to `point`; for the centre, the topmost one.
pub(crate) fn nearest_on_sphere(sphere: &Sphere, point: DVec3) -> DVec3 {
    let outwards = (point - sphere.centre()).try_normalize().unwrap_or(DVec3::Y);
    sphere.centre() + outwards * sphere.radius()
}

impl ClosestPoint for TriangleMesh {
    /// Point of the triangle, edges included; `None` for a NaN and for an invalid index.
    fn nearest_point(&self, index: u32, point: DVec3) -> Option<DVec3> {
        let nearest = nearest_on_triangle(self.vertices(index)?, point);
        point.is_finite().then_some(nearest)
    }
}

impl ClosestPoint for Spheres {
    /// Point of the surface, also from within the sphere; `None` for a NaN and for an invalid index.
    fn nearest_point(&self, index: u32, point: DVec3) -> Option<DVec3> {
        let nearest = nearest_on_sphere(self.as_slice().get(index as usize)?, point);
        point.is_finite().then_some(nearest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MeshData;
    use crate::strategies::vector;
    use proptest::prelude::*;
    use rt_math::Vec3;

    #[test]
    fn the_nearest_point_of_a_triangle_without_area_is_on_its_edges() {
        let point = DVec3::new(0.5, 2.0, 0.0);
        assert_eq!(nearest_on_triangle([DVec3::ZERO; 3], point), DVec3::ZERO);
        assert_eq!(nearest_on_triangle([DVec3::ZERO, DVec3::X, DVec3::X * 3.0], point), DVec3::X * 0.5);
    }

    #[test]
    fn each_region_of_a_triangle_has_its_nearest_point() {
        let corner = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let cases = [
            ([0.25, 0.25, 3.0], [0.25, 0.25, 0.0]),
            ([-1.0, -2.0, 1.0], [0.0, 0.0, 0.0]),
            ([3.0, -0.5, 1.0], [1.0, 0.0, 0.0]),
            ([-0.5, 3.0, -1.0], [0.0, 1.0, 0.0]),
            ([0.25, -2.0, 1.0], [0.25, 0.0, 0.0]),
            ([-2.0, 0.75, 1.0], [0.0, 0.75, 0.0]),
            ([1.0, 1.0, 0.0], [0.5, 0.5, 0.0]),
        ];
        for (point, nearest) in cases {
            assert_eq!(nearest_on_triangle(corner, point.into()), nearest.into());
        }
    }

    #[test]
    fn the_nearest_point_to_a_far_point_is_on_the_triangle() {
        let vertices = [DVec3::new(0.1, 0.2, 0.3), DVec3::new(1.3, -0.4, 0.7), DVec3::new(0.2, 1.1, -0.6)];
        let middle = (vertices[0] + vertices[1] + vertices[2]) / 3.0;
        let normal = unit_normal(vertices);
        for distance in [1.0, 1e6, 1e9, 1e12, 1e15, 1e18] {
            let nearest = nearest_on_triangle(vertices, middle + normal * distance);
            let off_plane = (nearest - vertices[0]).dot(normal).abs();
            assert!(off_plane < 1e-15, "{distance:e}: {nearest} is {off_plane:e} off the plane");
            let bounds = rt_math::Aabb::from_points(vertices).padded();
            assert!(bounds.contains(nearest), "{distance:e}: {nearest}");
        }
    }

    #[test]
    fn meshes_and_sets_answer_for_what_they_have() {
        let data = MeshData {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            ..MeshData::default()
        };
        let (mesh, _) = TriangleMesh::build(data).expect("a mesh");
        let spheres = Spheres::new(vec![Sphere::new(DVec3::X, 2.0).expect("a sphere")]);
        let above = DVec3::new(0.25, 0.25, 3.0);
        assert_eq!(
            (mesh.nearest_point(0, above), mesh.nearest_point(1, above)),
            (Some(DVec3::new(0.25, 0.25, 0.0)), None)
        );
        assert_eq!(
            (spheres.nearest_point(0, DVec3::X * 9.0), spheres.nearest_point(1, above)),
            (Some(DVec3::X * 3.0), None)
        );
        assert_eq!(spheres.nearest_point(0, DVec3::X * 1.5), Some(DVec3::X * 3.0), "from within");
        assert_eq!(spheres.nearest_point(0, DVec3::X), Some(DVec3::new(1.0, 2.0, 0.0)), "from the centre");
        for bad in [f64::NAN, f64::INFINITY] {
            let point = DVec3::new(0.0, bad, 0.0);
            assert_eq!((mesh.nearest_point(0, point), spheres.nearest_point(0, point)), (None, None));
        }
    }

    #[test]
    fn slivers_are_no_worse_than_their_edges() {
        let (length, width) = (1e6, 1e-6);
        let sliver = [DVec3::ZERO, DVec3::X * length, DVec3::new(length / 2.0, width, 0.0)];
        for i in 0..1000 {
            let x = f64::from(i) * length / 1000.0;
            let nearest = nearest_on_triangle(sliver, DVec3::new(x, 0.0, 1.0));
            assert!((nearest - DVec3::new(x, 0.0, 0.0)).length() < 2.0 * width, "{nearest}");
        }
    }

    /// A triangle by points of a fine grid on it, vertices and edges included.
    fn sampled(vertices: [DVec3; 3]) -> impl Iterator<Item = DVec3> {
        const STEPS: u32 = 60;
        let [a, b, c] = vertices;
        let part = |k: u32| f64::from(k) / f64::from(STEPS);
        (0..=STEPS).flat_map(move |i| (0..=STEPS - i).map(move |j| a + (b - a) * part(i) + (c - a) * part(j)))
    }

    proptest! {
        #[test]
        fn no_point_of_the_triangle_is_nearer(a in vector(1.0), b in vector(1.0), c in vector(1.0), point in vector(3.0)) {
            let vertices = [a, b, c];
            let nearest = nearest_on_triangle(vertices, point);
            let distance = nearest.distance(point);
            let best = sampled(vertices).map(|sample| sample.distance(point)).fold(f64::INFINITY, f64::min);
            prop_assert!(distance <= best + 1e-14, "{distance} {best}");
            // The result is a point of the triangle: no farther from a sample than samples are from each other.
            let outside = sampled(vertices).map(|sample| sample.distance(nearest)).fold(f64::INFINITY, f64::min);
            prop_assert!(outside <= 3.5 / 60.0, "{outside}");
        }

        #[test]
        fn no_point_of_the_sphere_is_nearer(
            centre in vector(1.0), radius in 0.1..2.0f64, point in vector(3.0), samples in prop::collection::vec(vector(1.0), 200),
        ) {
            let sphere = Sphere::new(centre, radius).expect("a sphere");
            let nearest = nearest_on_sphere(&sphere, point);
            prop_assert!((nearest.distance(centre) - radius).abs() < 1e-14);
            for sample in samples {
                let sample = centre + sample.normalize() * radius;
                prop_assert!(nearest.distance(point) <= sample.distance(point) + 1e-14);
            }
        }
    }
}
