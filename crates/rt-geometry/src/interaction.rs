//! Full geometry of a hit, computed once, for the closest one.

use rt_math::float::gamma;
use rt_math::{DMat3, DVec3, Ray, Real, Transform, Vec3, Vector3};

/// Parts of a [`SurfaceInteraction`] to compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InteractionFlags {
    /// Texture coordinates; left `[0, 0]` otherwise.
    pub uv: bool,
    /// Interpolated normals; the geometric normal otherwise.
    pub shading_normal: bool,
    /// Attributes that only some meshes have; otherwise [`VertexAttributes::default`].
    pub detail: bool,
}

impl InteractionFlags {
    /// All fields.
    pub const ALL: Self = Self { uv: true, shading_normal: true, detail: true };
    /// Only the point and the geometric normal.
    pub const NONE: Self = Self { uv: false, shading_normal: false, detail: false };
}

/// Interpolated attributes that only some meshes have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexAttributes {
    /// The second set of texture coordinates; (0, 0) without.
    pub second_uv: [f32; 2],
    /// Colour of the vertices, which multiplies that of the material; linear, white without.
    pub color: [f32; 3],
    /// Direction of rising `u` of the normal map, of any length, in the space of the surface; zero without.
    pub tangent: Vec3,
    /// True if `v` rises against the cross product of normal and tangent.
    pub is_mirrored: bool,
    /// Shading normal before normal mapping; zero without a normal map.
    pub smooth_normal: Vec3,
}

impl VertexAttributes {
    /// Attributes of a mesh without any.
    pub const NONE: Self = Self {
        second_uv: [0.0; 2],
        color: [1.0; 3],
        tangent: Vec3::ZERO,
        is_mirrored: false,
        smooth_normal: Vec3::ZERO,
    };
}

impl Default for VertexAttributes {
    fn default() -> Self {
        Self::NONE
    }
}

/// Surface around a hit, in the space of the ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceInteraction {
    /// The hit point, re-projected on the surface.
    pub point: DVec3,
    /// Error bound of `point` per axis: rounding of the point itself, and of the intersection test that a spawned ray repeats on
    /// this shape. Errors within the surface do not matter and are left out.
    pub point_error: DVec3,
    /// Origin of shadow rays: `point`, or for interpolated normals the point lifted to their smooth surface. This
    /// avoids shadow bands on flat triangles (Hanika 2021).
    pub shadow_point: DVec3,
    /// Unit normal of the actual surface, on its front side: outside of closed shapes; for triangles the side from
    /// which the vertices run counter-clockwise.
    pub geometric_normal: DVec3,
    /// Unit normal to shade with, on the same side as `geometric_normal`.
    pub shading_normal: DVec3,
    /// Texture coordinates; `v` runs upwards.
    pub uv: [f64; 2],
    /// Attributes that only some meshes have.
    pub detail: VertexAttributes,
}

impl SurfaceInteraction {
    /// Surface with a unit normal that is also its shading normal.
    #[inline]
    pub const fn flat(point: DVec3, point_error: DVec3, normal: DVec3, uv: [f64; 2]) -> Self {
        let detail = VertexAttributes::NONE;
        Self { point, point_error, shadow_point: point, geometric_normal: normal, shading_normal: normal, uv, detail }
    }

    /// Surface in the target space of a transform. Normals are unit again; the error bound includes the rounding of the
    /// map, and of the inverse map of a spawned ray.
    pub fn transformed(&self, target_from_source: &Transform) -> Self {
        let (point, error) = target_from_source.point_with_error(self.point, self.point_error);
        let point_error = error + return_error(self.point, point, target_from_source);
        let shadow_point =
            if self.shadow_point == self.point { point } else { target_from_source.point(self.shadow_point) };
        let geometric_normal = target_from_source.normal(self.geometric_normal).normalize();
        let shading_normal = if self.shading_normal == self.geometric_normal {
            geometric_normal
        } else {
            target_from_source.normal(self.shading_normal).normalize()
        };
        let mut detail = self.detail;
        if detail.tangent != Vec3::ZERO {
            detail.tangent = target_from_source.vector(detail.tangent.as_dvec3()).normalize_or_zero().as_vec3();
            detail.is_mirrored ^= target_from_source.linear().determinant() < 0.0;
        }
        if detail.smooth_normal != Vec3::ZERO {
            detail.smooth_normal =
                target_from_source.normal(detail.smooth_normal.as_dvec3()).normalize_or_zero().as_vec3();
        }
        Self { point, point_error, shadow_point, geometric_normal, shading_normal, uv: self.uv, detail }
    }

    /// Ray that leaves the surface in `direction`. Its origin is moved along the geometric normal, to the side of the
    /// direction, by the error bound of the hit point. So rounding cannot make it hit the same surface again.
    ///
    /// Pharr, Jakob, Humphreys, PBR 4th ed., section 6.8.6.
    #[inline(always)]
    pub fn spawn_ray(&self, direction: DVec3, time: f64) -> Ray {
        Ray { origin: self.offset(self.point, direction.dot(self.geometric_normal)), direction, time }
    }

    /// A shadow ray to `target`, which it reaches at `t = 1`.
    #[inline]
    pub fn spawn_shadow_ray(&self, target: DVec3, time: f64) -> Ray {
        self.shadow_rays((target - self.point).dot(self.shading_normal) < 0.0).to(target, time)
    }

    /// A shadow ray in `direction`, to a light infinitely far away.
    #[inline]
    pub fn spawn_shadow_ray_towards(&self, direction: DVec3, time: f64) -> Ray {
        self.shadow_rays(direction.dot(self.shading_normal) < 0.0).towards(direction, time)
    }

    /// Shadow rays to many lights, with the origin on the viewer's side computed once: the side of the shading normal, or the
    /// other if `is_seen_from_behind`. A ray to the far side computes its own origin.
    #[inline(always)]
    pub fn shadow_rays(&self, is_seen_from_behind: bool) -> ShadowRays<'_> {
        let is_behind = is_seen_from_behind;
        ShadowRays { surface: self, is_behind, origin: self.shadow_origin(if is_behind { -1.0 } else { 1.0 }) }
    }

    /// Origin of shadow rays to one `side`, the back if that is negative. `shadow_point` applies to the side to which
    /// it is lifted.
    #[inline(always)]
    fn shadow_origin(&self, side: f64) -> DVec3 {
        let lift = (self.shadow_point - self.point).dot(self.geometric_normal);
        self.offset(if lift * side < 0.0 { self.point } else { self.shadow_point }, side)
    }

    /// The point moved off the surface, to the back if `side` is negative.
    #[inline(always)]
    fn offset(&self, point: DVec3, side: f64) -> DVec3 {
        let normal = self.geometric_normal;
        let outwards = if side < 0.0 { -normal } else { normal };
        rounded_towards(point + outwards * normal.abs().dot(self.point_error), outwards)
    }
}

/// Shadow rays from one point of a surface to its lights, with common parts computed once.
#[derive(Clone, Copy, Debug)]
pub struct ShadowRays<'s> {
    surface: &'s SurfaceInteraction,
    is_behind: bool,
    /// Origin of rays to the side with most lights.
    origin: DVec3,
}

impl ShadowRays<'_> {
    /// A shadow ray to `target`, which it reaches at `t = 1`.
    #[inline(always)]
    pub fn to(&self, target: DVec3, time: f64) -> Ray {
        let origin = self.origin_towards(target - self.surface.point);
        Ray { origin, direction: target - origin, time }
    }

    /// A shadow ray in `direction`, to a light infinitely far away.
    #[inline(always)]
    pub fn towards(&self, direction: DVec3, time: f64) -> Ray {
        Ray { origin: self.origin_towards(direction), direction, time }
    }

    /// The shading normal determines the lit side: a light just below a triangle still lights the smooth surface.
    #[inline(always)]
    fn origin_towards(&self, direction: DVec3) -> DVec3 {
        let side = direction.dot(self.surface.shading_normal);
        if (side < 0.0) == self.is_behind { self.origin } else { self.surface.shadow_origin(side) }
    }
}

/// Point moved along a unit normal by its error bound, and rounded away from the surface, as by [`SurfaceInteraction::spawn_ray`].
/// `outwards` is the normal or its opposite. Where the mask is false, the result is not valid: a coordinate is infinite, NaN, or
/// smaller than 1e-280, but not 0.
#[inline(always)]
pub fn offset_point<R: Real>(
    point: Vector3<R>,
    point_error: Vector3<R>,
    normal: Vector3<R>,
    outwards: Vector3<R>,
) -> (Vector3<R>, R::Mask) {
    add_steps(point + outwards * normal.abs().dot(point_error), outwards)
}

/// Moves each component to the next number in the direction of `side`, unless that is 0. Compensates the rounding of a
/// sum.
#[inline(always)]
fn rounded_towards(point: DVec3, side: DVec3) -> DVec3 {
    if let (next, true) = add_steps(point.into(), side.into()) {
        return next.into();
    }
    let next = |x: f64, side: f64| if side > 0.0 { x.next_up() } else { x.next_down() };
    let next = DVec3::new(next(point.x, side.x), next(point.y, side.y), next(point.z, side.z));
    DVec3::select(side.cmpeq(DVec3::ZERO), point, next)
}

/// Adds a step to each component in the direction of `side`, unless that is 0. The mask is false where a component is not finite, or so
/// small that steps may underflow. From 0, the step is 2⁻⁹⁷⁰: products with subnormal numbers are slow on Intel processors.
///
/// The step is more than half the distance to the larger neighbour and at most slightly more than all of it. So
/// the sum is rounded to that neighbour. The same holds for the smaller neighbour, also across a power of two. Source:
/// Rump, Zimmermann, Boldo and Melquiond, "Computing Predecessor and Successor in Rounding to Nearest", BIT 49, 2009,
/// algorithm 1.
#[inline(always)]
fn add_steps<R: Real>(point: Vector3<R>, side: Vector3<R>) -> (Vector3<R>, R::Mask) {
    const MIN_SIZE: f64 = 1e-280;
    const STEP: f64 = f64::EPSILON / 2.0 * (1.0 + f64::EPSILON);
    const STEP_FROM_0: f64 = f64::MIN_POSITIVE / f64::EPSILON;
    #[inline(always)]
    fn next<R: Real>(x: R, side: R) -> R {
        let zero = x.splat(0.0);
        let step = R::select(x.eq(zero), x.splat(STEP_FROM_0), x.abs() * STEP);
        R::select(side.eq(zero), x, x + step.copysign(side))
    }
    #[inline(always)]
    fn is_known<R: Real>(x: R) -> R::Mask {
        x.abs().ge(x.splat(MIN_SIZE)) | x.eq(x.splat(0.0))
    }
    let moved = Vector3::new(next(point.x, side.x), next(point.y, side.y), next(point.z, side.z));
    (moved, is_known(point.x) & is_known(point.y) & is_known(point.z) & point.is_finite())
}

/// Distance of a point from its origin after mapping to the source and back, as a length in the target space. The two
/// directions of a transform are rounded independently, so the distance is measured; the second term bounds its
/// variation nearby.
fn return_error(source: DVec3, target: DVec3, target_from_source: &Transform) -> DVec3 {
    let there = absolute(target_from_source.linear());
    let back = absolute(target_from_source.inverse().linear());
    let residual = (target_from_source.inverse_point(target) - source).abs();
    there * (residual + back * (target - target_from_source.translation()).abs() * gamma(5))
}

fn absolute(m: DMat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOOR: SurfaceInteraction =
        SurfaceInteraction::flat(DVec3::new(0.3, 0.0, 0.7), DVec3::splat(1e-10), DVec3::Y, [0.0; 2]);

    /// `f64::signum(0.0)` is 1: an offset made with it pushes the origin along the surface as well.
    #[test]
    fn the_offset_leaves_components_across_the_normal_alone() {
        let up = FLOOR.spawn_ray(DVec3::new(1.0, 1.0, 0.0), 0.5);
        assert_eq!((up.origin.x, up.origin.z, up.time), (0.3, 0.7, 0.5));
        assert!(up.origin.y > 1e-10 && up.origin.y < 1.1e-10);
        let down = FLOOR.spawn_ray(DVec3::new(1.0, -1.0, 0.0), 0.5);
        assert_eq!(down.origin, DVec3::new(0.3, -up.origin.y, 0.7));
    }

    #[test]
    fn an_exact_point_still_moves_by_one_number() {
        let exact = SurfaceInteraction::flat(DVec3::splat(3.0), DVec3::ZERO, DVec3::NEG_X, [0.0; 2]);
        assert_eq!(exact.spawn_ray(DVec3::NEG_ONE, 0.0).origin, DVec3::new(3.0f64.next_down(), 3.0, 3.0));
    }

    #[test]
    fn sums_are_rounded_to_the_neighbouring_number() {
        let rounded = |x: f64, side: f64| {
            let all = rounded_towards(DVec3::splat(x), DVec3::splat(side));
            let next_to_others = rounded_towards(DVec3::new(2.0, x, -0.3), DVec3::new(0.0, side, 0.0));
            assert_eq!(next_to_others, DVec3::new(2.0, all.y, -0.3), "{x:e}");
            assert_eq!([all.x, all.y].map(f64::to_bits), [all.z; 2].map(f64::to_bits), "{x:e}");
            all.x
        };
        let powers = core::iter::successors(Some(5e-324), |x: &f64| Some(x * 2.0)).take_while(|x| x.is_finite());
        let odd = (0..4096).map(|i| f64::from_bits(rt_math::random::hash(&[7, i]) >> 1)).filter(|x| x.is_finite());
        let sizes = [0.0, 5e-324, 1e-280, 1.0, 1.0 / 3.0, f64::MAX, f64::INFINITY].into_iter().chain(powers).chain(odd);
        for x in sizes.flat_map(|x| [x, x.next_up(), x.next_down(), -x]) {
            let from_0 = f64::from_bits(53 << 52);
            let next = if x == 0.0 { [from_0, -from_0] } else { [x.next_up(), x.next_down()] };
            assert_eq!([0.3, -0.3].map(|side| rounded(x, side)), next, "{x:e}");
            assert_eq!(rounded(x, 0.0).to_bits(), x.to_bits(), "{x:e}");
            assert_eq!(rounded(x, -0.0).to_bits(), x.to_bits(), "{x:e}");
        }
        assert!(rounded_towards(DVec3::NAN, DVec3::ONE).is_nan());
    }

    #[test]
    fn one_point_starts_the_shadow_rays_of_all_lights() {
        let lifted = SurfaceInteraction { shadow_point: FLOOR.point + DVec3::Y * 0.1, ..FLOOR };
        for is_seen_from_behind in [false, true] {
            let rays = lifted.shadow_rays(is_seen_from_behind);
            for target in [DVec3::new(0.0, 9.0, 0.0), DVec3::new(0.0, -9.0, 0.0)] {
                assert_eq!(rays.to(target, 0.5), lifted.spawn_shadow_ray(target, 0.5));
                assert_eq!(rays.towards(target, 0.5), lifted.spawn_shadow_ray_towards(target, 0.5));
            }
        }
    }

    #[test]
    fn shadow_rays_end_at_their_target() {
        let target = DVec3::new(4.0, 5.0, 6.0);
        let ray = FLOOR.spawn_shadow_ray(target, 0.25);
        assert!((ray.at(1.0) - target).length() < 1e-15 * 10.0);
        assert_eq!(ray.time, 0.25);
        assert_eq!(FLOOR.spawn_shadow_ray_towards(DVec3::Y, 0.0), FLOOR.spawn_ray(DVec3::Y, 0.0));
    }

    #[test]
    fn shadow_rays_through_the_surface_do_not_start_above_it() {
        let lifted = SurfaceInteraction { shadow_point: FLOOR.point + DVec3::Y * 0.1, ..FLOOR };
        assert!(lifted.spawn_shadow_ray_towards(DVec3::Y, 0.0).origin.y > 0.1);
        assert!(lifted.spawn_shadow_ray(DVec3::new(0.0, 9.0, 0.0), 0.0).origin.y > 0.1);
        assert_eq!(lifted.spawn_shadow_ray_towards(DVec3::NEG_Y, 0.0), FLOOR.spawn_ray(DVec3::NEG_Y, 0.0));
        assert!(lifted.spawn_shadow_ray(DVec3::new(0.0, -9.0, 0.0), 0.0).origin.y < 0.0);
    }

    #[test]
    fn a_light_below_the_facet_but_above_the_smooth_surface_is_looked_for_from_above() {
        let facet = SurfaceInteraction {
            shadow_point: FLOOR.point + DVec3::Y * 0.1,
            shading_normal: DVec3::new(0.6, 0.8, 0.0),
            ..FLOOR
        };
        assert!(facet.spawn_shadow_ray_towards(DVec3::new(1.0, -0.1, 0.0), 0.0).origin.y > 0.1);
    }

    #[test]
    fn transforms_map_all_parts() {
        let tilted = SurfaceInteraction {
            shading_normal: DVec3::new(0.6, 0.8, 0.0),
            shadow_point: FLOOR.point + DVec3::Y,
            uv: [0.1, 0.2],
            ..FLOOR
        };
        let map = Transform::scale(DVec3::new(2.0, -4.0, 1.0)).expect("regular");
        let image = tilted.transformed(&map);
        assert_eq!((image.point, image.shadow_point), (DVec3::new(0.6, 0.0, 0.7), DVec3::new(0.6, -4.0, 0.7)));
        assert_eq!((image.geometric_normal, image.uv), (DVec3::NEG_Y, [0.1, 0.2]));
        assert!((image.shading_normal - DVec3::new(0.3, -0.2, 0.0).normalize()).length() < 1e-15);
        assert!(image.point_error.cmpge(DVec3::new(2e-10, 4e-10, 1e-10)).all());
        assert!(image.point_error.cmplt(DVec3::new(2e-10, 4e-10, 1e-10) * 1.001).all());
    }
}
