//! Single triangles in `f64`.

use crate::area::{area_vector, unit_normal};
use crate::error::{ShapeError, check_coordinates};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction, WatertightRay};
use robust::{Coord, Coord3D, orient2d, orient3d};
use rt_math::float::{UNIT_ROUNDOFF, gamma};
use rt_math::{Aabb, DVec3, Interval, Ray, Real, Vector3};

/// Triangle; its front is the side from which the vertices run counter-clockwise.
///
/// A hit holds its barycentric coordinates: the weights of the second and third vertex, which are the texture coordinates
/// as well. They are exactly 0 or 1 for a ray that passes exactly through a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    vertices: [DVec3; 3],
}

impl Triangle {
    /// The triangle with these vertices.
    ///
    /// # Errors
    /// If it has no area or a number is not finite.
    pub fn new(vertices: [DVec3; 3]) -> Result<Self, ShapeError> {
        check_coordinates(vertices)?;
        if area_vector(vertices) == DVec3::ZERO { Err(ShapeError::NoArea(vertices)) } else { Ok(Self { vertices }) }
    }

    /// The vertices in order.
    pub const fn vertices(&self) -> [DVec3; 3] {
        self.vertices
    }

    /// The smallest box around the triangle.
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(self.vertices)
    }

    /// The hit within `span`, from either side; `None` on a miss, when seen exactly edge-on, and for rays without a
    /// direction. See [`WatertightRay`] for the test.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        WatertightRay::new(ray).intersect(self.vertices, span)
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, _ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
        let (point, point_error) = point_at(self.vertices, hit.uv);
        let uv = if needs.uv { hit.uv } else { [0.0; 2] };
        SurfaceInteraction::flat(point, point_error, unit_normal(self.vertices), uv)
    }
}

/// True if the point lies on the triangle, edges and vertices included, decided exactly. False for NaN and for triangles
/// without area.
///
/// The point lies in the plane if the tetrahedron over the triangle has no volume. It lies on the triangle if it is on the
/// same side of all edges, seen along the axis that is closest to the normal. The signs of volume and areas are exact
/// (Shewchuk 1997).
pub fn is_on_triangle(vertices: [DVec3; 3], point: DVec3) -> bool {
    let [a, b, c, p] = [vertices[0], vertices[1], vertices[2], point].map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
    let area = area_vector(vertices).abs();
    if orient3d(a, b, c, p) != 0.0 || area == DVec3::ZERO || !point.is_finite() {
        return false;
    }
    let (x, y) = match area.to_array() {
        [x, y, z] if x >= y && x >= z => (1, 2),
        [_, y, z] if y >= z => (2, 0),
        _ => (0, 1),
    };
    let flat = |p: DVec3| Coord { x: p[x], y: p[y] };
    let [a, b, c] = vertices.map(flat);
    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| orient2d(from, to, flat(point)));
    sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
}

/// All three barycentric weights, from those of the second and third vertex.
#[inline(always)]
pub(crate) fn weights<R: Real>([v, w]: [R; 2]) -> [R; 3] {
    [v.splat(1.0) - v - w, v, w]
}

/// Interpolation between numbers at the vertices, with these barycentric weights of the second and third vertex.
#[inline(always)]
pub fn interpolate<R: Real>([a, b, c]: [R; 3], uv: [R; 2]) -> R {
    let [u, v, w] = weights(uv);
    a * u + b * v + c * w
}

/// Version of [`triangle_point`] for one triangle.
#[inline]
pub(crate) fn point_at([a, b, c]: [DVec3; 3], uv: [f64; 2]) -> (DVec3, DVec3) {
    let (point, error) = triangle_point([a.into(), b.into(), c.into()], uv);
    (point.into(), error.into())
}

/// Point of a triangle with these barycentric weights of the second and third vertex, and its error bound, as in
/// [`SurfaceInteraction`].
///
/// The first part of the bound is that of the rounding of the sum (PBR 4th ed., section 6.8.5). The second part is for the test of a
/// ray that is spawned there. Its shear mixes the axes, so its error depends on the largest extent.
#[inline(always)]
pub fn triangle_point<R: Real>([a, b, c]: [Vector3<R>; 3], uv: [R; 2]) -> (Vector3<R>, Vector3<R>) {
    let [u, v, w] = weights(uv);
    let extent = |a: R, b: R, c: R| a.max(b).max(c) - a.min(b).min(c);
    let extent = extent(a.x, b.x, c.x).max(extent(a.y, b.y, c.y)).max(extent(a.z, b.z, c.z));
    let (a, b, c) = (a * u, b * v, c * w);
    let mixed = extent * (3.0 * UNIT_ROUNDOFF);
    let error = (a.abs() + b.abs() + c.abs()) * u.splat(gamma(7)) + Vector3::new(mixed, mixed, mixed);
    (a + b + c, error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategies::vector;
    use proptest::prelude::*;
    use rt_math::transcendental::exp2;

    fn corner() -> Triangle {
        Triangle::new([DVec3::ZERO, DVec3::X, DVec3::Y]).expect("a triangle")
    }

    fn hit(origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, [f64; 2])> {
        let ray = Ray::new(origin.into(), direction.into());
        corner().intersect(&ray, Interval::FORWARD).map(|hit| (hit.t, hit.uv))
    }

    #[test]
    fn known_values() {
        assert_eq!(hit([0.25, 0.5, 3.0], [0.0, 0.0, -1.0]), Some((3.0, [0.25, 0.5])));
        assert_eq!(hit([0.25, 0.5, -3.0], [0.0, 0.0, 2.0]), Some((1.5, [0.25, 0.5])), "from the back");
        assert_eq!(hit([1.0, 0.0, 3.0], [0.0, 0.0, -1.0]), Some((3.0, [1.0, 0.0])), "a vertex");
        assert_eq!(hit([0.5, 0.5, 3.0], [0.0, 0.0, -1.0]), Some((3.0, [0.5, 0.5])), "an edge");
        assert_eq!(hit([0.5, 0.5f64.next_up(), 3.0], [0.0, 0.0, -1.0]), None, "one number beyond the edge");
        assert_eq!(hit([-1e-300, 0.5, 3.0], [0.0, 0.0, -1.0]), None);
        assert_eq!(hit([0.25, 0.5, 3.0], [0.0, 0.0, 1.0]), None, "behind");
        assert_eq!(hit([-1.0, 0.25, 0.0], [1.0, 0.0, 0.0]), None, "edge-on");
    }

    #[test]
    fn barycentric_coordinates_are_exact_at_the_vertices() {
        let vertices = [[0.1, 0.7, -2.0], [1.3, 0.2, 0.3], [-0.4, 1.9, 1.1]].map(DVec3::from);
        let triangle = Triangle::new(vertices).expect("a triangle");
        for (vertex, uv) in vertices.into_iter().zip([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]) {
            let ray = Ray::new(DVec3::new(vertex.x, vertex.y, 5.0), DVec3::NEG_Z);
            let hit = triangle.intersect(&ray, Interval::FORWARD).expect("a hit");
            let surface = triangle.surface(&ray, &hit, InteractionFlags::ALL);
            assert_eq!((hit.uv, surface.uv, surface.point), (uv, uv, vertex));
        }
    }

    #[test]
    fn the_front_is_where_the_vertices_run_counter_clockwise() {
        for origin in [[0.25, 0.25, 1.0], [0.25, 0.25, -1.0]] {
            let ray = Ray::new(origin.into(), DVec3::new(0.0, 0.0, -origin[2]));
            let hit = corner().intersect(&ray, Interval::FORWARD).expect("a hit");
            let surface = corner().surface(&ray, &hit, InteractionFlags::NONE);
            assert_eq!((surface.geometric_normal, surface.uv), (DVec3::Z, [0.0; 2]));
            assert_eq!(corner().surface(&ray, &hit, InteractionFlags::ALL).uv, [0.25, 0.25]);
        }
    }

    #[test]
    fn points_are_on_a_triangle_exactly_or_not_at_all() {
        let slanted = [[0.0, 0.0, 3.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0]].map(DVec3::from);
        let is_on = |p: [f64; 3]| is_on_triangle(slanted, DVec3::from(p));
        assert!(is_on([1.0, 1.0, 1.0]) && is_on([1.5, 1.5, 0.0]) && is_on([0.0, 0.0, 3.0]));
        assert!(!is_on([1.0, 1.0, 1.0f64.next_up()]) && !is_on([1.0, 1.0, 1.0f64.next_down()]));
        assert!(!is_on([-1.0, 2.0, 2.0]) && !is_on([1.75, 1.75, -0.5]) && !is_on([f64::NAN, 0.0, 0.0]));
        assert!(!is_on_triangle([DVec3::ZERO, DVec3::X, DVec3::X], DVec3::ZERO), "no area");
    }

    #[test]
    fn a_sliver_gives_a_hit_on_itself_or_a_clean_miss() {
        let sliver = Triangle::new([DVec3::ZERO, DVec3::X * 1e6, DVec3::new(5e5, 1e-6, 0.0)]).expect("a triangle");
        for i in -50..50 {
            let origin = DVec3::new(f64::from(i) * 1e4, -1.0, f64::from(i) * 1e-8);
            let ray = Ray::new(origin, DVec3::new(3e5, 1.0, 0.0));
            if let Some(hit) = sliver.intersect(&ray, Interval::FORWARD) {
                let surface = sliver.surface(&ray, &hit, InteractionFlags::ALL);
                assert!(sliver.bounds().padded().contains(surface.point));
                assert_eq!(surface.geometric_normal, DVec3::Z);
            }
        }
    }

    proptest! {
        #[test]
        fn aimed_rays_hit_where_they_are_aimed(
            a in vector(10.0), b in vector(10.0), c in vector(10.0), from in vector(10.0),
            v in 0.01..0.5f64, w in 0.01..0.49f64, k in -60i32..60,
        ) {
            let triangle = Triangle::new([a, b, c]).expect("a triangle");
            let aim = a + (b - a) * v + (c - a) * w;
            let normal = unit_normal([a, b, c]);
            prop_assume!(normal.dot(aim - from).abs() > 0.1 && (b - a).cross(c - a).length() > 1.0);
            let ray = Ray::new(from, aim - from);
            let hit = triangle.intersect(&ray, Interval::FORWARD).expect("a hit");
            prop_assert!((hit.t - 1.0).abs() < 1e-12);
            prop_assert!((hit.uv[0] - v).abs() < 1e-11 && (hit.uv[1] - w).abs() < 1e-11);
            let surface = triangle.surface(&ray, &hit, InteractionFlags::ALL);
            prop_assert!((surface.point - aim).length() < 1e-11);
            prop_assert!((surface.geometric_normal.length() - 1.0).abs() < 1e-15);
            prop_assert!(surface.geometric_normal.dot(b - a).abs() < 1e-12);
            let scaled = Ray::new(from, ray.direction * exp2(f64::from(k)));
            let again = triangle.intersect(&scaled, Interval::FORWARD).expect("a hit");
            prop_assert_eq!((again.t * exp2(f64::from(k)), again.uv), (hit.t, hit.uv));
            prop_assert_eq!(triangle.intersect(&ray, Interval::new(hit.t, hit.t)), Some(hit));
            prop_assert_eq!(triangle.intersect(&ray, Interval::new(0.0, hit.t.next_down())), None);
        }
    }
}
