//! The part of space that a camera's rays run through.

use rt_math::{
    Aabb, DVec2, DVec3,
    float::{UNIT_ROUNDOFF, cross},
};

/// Bound on the roundings between a plane of the volume and a hit on a box, in units of their size. They are those of
/// the plane's normal, the test against it, the ray and the slab test: fewer than 64.
const ROUNDINGS: f64 = 256.0;

/// Lengths within this range neither over- nor underflow when a few of them are multiplied.
const SOUND: core::ops::Range<f64> = 1e-100..1e100;

/// The rays through a rectangle of the image, as `origin + across + t·forward` (orthographic) or `origin +
/// t·(forward + across)`, where `across = x·right + y·down` and (x, y) lies between `min` and `max`. A lens adds
/// `λ·(1 − t / focus)` for all points λ of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pencil {
    pub(crate) origin: DVec3,
    pub(crate) forward: DVec3,
    pub(crate) right: DVec3,
    pub(crate) down: DVec3,
    pub(crate) min: DVec2,
    pub(crate) max: DVec2,
    pub(crate) is_perspective: bool,
    pub(crate) rim: Option<Rim>,
}

/// The circle around a lens.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rim {
    /// Radius in units of `right` and `down`.
    pub(crate) steps: f64,
    /// The parameter at which rays through all points of the lens intersect.
    pub(crate) focus: f64,
}

/// A half-space: all `p` with `normal·(p − origin) ≥ offset`.
#[derive(Clone, Copy, Debug)]
struct HalfSpace {
    normal: DVec3,
    offset: f64,
    /// Bound on the length of the normal that also covers its rounding.
    scale: f64,
}

/// Volume in which camera rays can hit something. It lies in front of the camera plane, between four planes through the
/// edges of a part of the image.
///
/// With a lens, each edge has two planes, and no ray reaches points behind both:
///
/// ```text
///            ╲       ╱    A point of a ray through the edge is p = origin + t·(forward + across) + λ·(1 − t/f),
///    lens │╲   ╲   ╱      t its depth, λ a point of the lens. With the inward normal n of the plane through the
///         │  ╲   ╳  edge  pinhole, and h = max n·λ over the lens, which is symmetric:
///         │    ╳   ╲
///         │  ╱   ╲   ╲    n·(p − origin) ≥ n·λ·(1 − t/f) ≥ −h·|1 − t/f| = −max(h·(1 − t/f), −h·(1 − t/f)).
///            f ↑
/// ```
///
/// Since `t` is linear in `p`, the right side is the lower of two planes. A box that lies entirely behind both contains
/// no point of a ray; one that lies behind each with different parts may have.
///
/// No camera ray enters a box that [`excludes`](Self::excludes) rejects, rounding included. The slab test
/// ([`Aabb::clip`]) with a ray of [`Camera::ray`](crate::Camera::ray) misses the box, and so do all tests that
/// use it. Boxes near the edges may be kept although no ray hits them.
///
/// ```
/// use rt_camera::{Camera, CameraSettings, FovAxis, Projection};
/// use rt_math::{Aabb, DVec2, DVec3, Transform};
///
/// let projection = Projection::Perspective { fov: 90f64.to_radians(), axis: FovAxis::Vertical };
/// let settings = CameraSettings::new(Transform::IDENTITY, projection);
/// let volume = Camera::new(&settings, 100, 100)?.view_volume(DVec2::ZERO, DVec2::splat(100.0));
/// let unit_box = |centre: DVec3| Aabb::new(centre - 0.5, centre + 0.5);
/// assert!(!volume.excludes(&unit_box(DVec3::new(0.0, 0.0, -5.0))));
/// assert!(volume.excludes(&unit_box(DVec3::new(0.0, 0.0, 5.0))), "behind");
/// assert!(volume.excludes(&unit_box(DVec3::new(9.0, 0.0, -5.0))), "to the right");
/// # Ok::<(), rt_camera::CameraError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ViewVolume {
    origin: DVec3,
    /// Distance from the origin at which rays may start.
    reach: f64,
    /// In front of the camera plane.
    front: HalfSpace,
    /// Within each edge of the image.
    edges: [HalfSpace; 4],
    /// The other plane of each edge, with a lens.
    other_edges: Option<[HalfSpace; 4]>,
    /// Growth of depth.
    depth: DVec3,
    /// Part of its terms by which a sum must fall short of its offset. Infinite if no bound holds.
    slack: f64,
}

impl ViewVolume {
    pub(crate) fn new(pencil: &Pencil) -> Self {
        let Pencil { origin, forward, right, down, min, max, is_perspective, rim } = *pencil;
        let across = cross(right, down);
        let volume = forward.dot(across);
        let side = volume.signum();
        let volume = volume.abs();
        // The planes x = `at` and y = `at` of the image, with the normal towards greater x or y.
        let at_x = |at: f64| {
            let within = if is_perspective { forward + right * at } else { forward };
            (cross(down, within) * side, at)
        };
        let at_y = |at: f64| {
            let within = if is_perspective { forward + down * at } else { forward };
            (cross(within, right) * side, at)
        };
        let [(left, x0), (far_right, x1), (top, y0), (bottom, y1)] =
            [at_x(min.x), at_x(max.x), at_y(min.y), at_y(max.y)];
        let farthest = min.abs().max(max.abs()) * DVec2::new(right.length(), down.length());
        let lens = rim.map_or(0.0, |rim| rim.steps * (right.length() + down.length()));
        let turned = rim.map_or(0.0, |rim| lens / rim.focus);
        let longest = forward.length() + farthest.x + farthest.y + turned;
        // All directions have the same component across the image plane, so that none is shorter than it.
        let shortest = volume / across.length();
        let half_space = |normal: DVec3, at: f64, edge: DVec3| HalfSpace {
            normal,
            offset: if is_perspective { 0.0 } else { at * volume },
            scale: longest * edge.length() * (1.0 + turned / shortest),
        };
        let edges = [
            half_space(left, x0, down),
            half_space(-far_right, -x1, down),
            half_space(top, y0, right),
            half_space(-bottom, -y1, right),
        ];
        let depth = across * side / volume;
        // The plane through one end of the lens: h·(1 − t / focus) is added to, or taken from, n·(p − origin) − offset.
        let tilted = |Rim { steps, focus }: Rim, sign: f64| {
            edges.map(|edge| {
                let h = sign * steps * DVec2::new(edge.normal.dot(right), edge.normal.dot(down)).length();
                HalfSpace { normal: edge.normal - depth * (h / focus), offset: edge.offset - h, ..edge }
            })
        };
        // Rounding turns a direction by its part of the longest.
        let skew = longest / shortest;
        let sound =
            [forward.length(), right.length(), down.length(), longest].iter().all(|length| SOUND.contains(length));
        Self {
            origin,
            reach: if is_perspective { 0.0 } else { farthest.x + farthest.y } + lens,
            front: HalfSpace { normal: across * side, offset: 0.0, scale: right.length() * down.length() },
            edges: rim.map_or(edges, |rim| tilted(rim, 1.0)),
            other_edges: rim.map(|rim| tilted(rim, -1.0)),
            depth,
            slack: if sound && skew.is_finite() { ROUNDINGS * UNIT_ROUNDOFF * skew } else { f64::INFINITY },
        }
    }

    /// True only if no ray of the volume hits the box: it lies behind one of the planes. False for empty and for
    /// infinite boxes, and where coordinates are so large or small that no bound holds.
    pub fn excludes(&self, aabb: &Aabb) -> bool {
        let farthest = |normal: DVec3| {
            let corner = DVec3::select(normal.cmpge(DVec3::ZERO), aabb.max, aabb.min);
            normal.dot(corner - self.origin)
        };
        !aabb.is_empty() && self.is_behind_a_plane(aabb.max_abs(), farthest)
    }

    /// True only if no ray of the volume hits the sphere, which may be outside although its box is not. False where
    /// coordinates are so large or small that no bound holds, and for a negative or NaN radius.
    pub fn excludes_sphere(&self, centre: DVec3, radius: f64) -> bool {
        let farthest = |normal: DVec3| normal.dot(centre - self.origin) + normal.length() * radius;
        radius >= 0.0 && self.is_behind_a_plane(centre.abs().max_element() + radius, farthest)
    }

    /// True if something lies behind one of the planes altogether. Its coordinates reach to `max_abs`, and its points relative
    /// to the origin up to `farthest(n)` along n.
    #[inline]
    fn is_behind_a_plane(&self, max_abs: f64, farthest: impl Fn(DVec3) -> f64) -> bool {
        let size = max_abs + self.origin.abs().max_element() + self.reach;
        if !SOUND.contains(&size) {
            return false;
        }
        let is_behind = |half_space: &HalfSpace| {
            let HalfSpace { normal, offset, scale } = *half_space;
            farthest(normal) - offset < -(self.slack * scale * size)
        };
        let is_behind_other = |edge: usize| self.other_edges.is_none_or(|edges| is_behind(&edges[edge]));
        is_behind(&self.front) || (0..4).any(|edge| is_behind(&self.edges[edge]) && is_behind_other(edge))
    }

    /// Minimum depth of the box along the view axis, up to rounding; also a bound on the parameter of [camera](crate::Camera) rays
    /// that hit it. Negative behind the camera plane, infinite or NaN for an empty box.
    pub fn min_depth(&self, aabb: &Aabb) -> f64 {
        let nearest = DVec3::select(self.depth.cmpge(DVec3::ZERO), aabb.min, aabb.max);
        self.depth.dot(nearest - self.origin)
    }

    /// Minimum depth of a point of the sphere, as [`min_depth`](Self::min_depth).
    pub fn min_depth_of_sphere(&self, centre: DVec3, radius: f64) -> f64 {
        self.depth.dot(centre - self.origin) - self.depth.length() * radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, CameraSettings, FovAxis, Lens, Projection};
    use proptest::prelude::*;
    use rt_math::{Interval, SlabRay, Transform};

    const WIDTH: f64 = 120.0;
    const HEIGHT: f64 = 90.0;

    fn vector(range: f64) -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-range..range).prop_map(DVec3::from)
    }

    /// Cameras of both projections, mirrored, sheared and at any distance from the world's origin.
    fn any_camera() -> impl Strategy<Value = Camera> {
        let projection = prop_oneof![
            (1e-4..3.1f64).prop_map(|fov| Projection::Perspective { fov, axis: FovAxis::Vertical }),
            (0.01..50.0f64).prop_map(|height| Projection::Orthographic { height }),
        ];
        let offset = prop_oneof![Just(0.0), -10.0..10.0f64, Just(1e7)];
        let lens = (prop_oneof![0.0..0.1f64, 0.1..5.0f64], 0.01..30.0f64).prop_map(|(radius, focus)| Lens {
            radius,
            focus,
            blades: None,
            rotation: 0.0,
        });
        let view = (vector(10.0), vector(10.0), offset, vector(3.0), -0.9..0.9f64);
        (view, projection, vector(1.0), prop::option::of(lens)).prop_filter_map(
            "degenerate view",
            |((eye, target, offset, factors, shear), projection, shift, lens)| {
                let view = Transform::look_at(eye + offset, target + offset, DVec3::Y).ok()?;
                let shear = Transform::shear([shear, 0.1, 0.0, 0.2, shear, 0.0]).ok()?;
                let world_from_camera = view.compose(&shear).compose(&Transform::scale(factors).ok()?);
                let lens_shift = DVec2::new(shift.x, shift.y);
                let settings =
                    CameraSettings { lens_shift, lens, ..CameraSettings::new(world_from_camera, projection) };
                Camera::new(&settings, 120, 90).ok()
            },
        )
    }

    /// A part of the image, maybe of no size, maybe beyond the edge.
    fn any_part() -> impl Strategy<Value = (DVec2, DVec2)> {
        (-10.0..WIDTH, -10.0..HEIGHT, prop_oneof![Just(0.0), 0.0..60.0f64])
            .prop_map(|(x, y, side)| (DVec2::new(x, y), DVec2::new(x + side, y + side)))
    }

    /// From the middle of the part to its corners, which are taken with half of the draws.
    fn share() -> impl Strategy<Value = f64> {
        prop_oneof![Just(0.0), Just(1.0), 0.0..1.0f64]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// The smallest boxes, around single points of rays, many of them along the edges of the volume.
        #[test]
        fn no_point_of_a_ray_is_excluded(
            camera in any_camera(), (min, max) in any_part(), u in share(), v in share(), on_lens in [share(), share()], t in share(), far in prop::sample::select(vec![1e-3, 1.0, 1e3, 1e7]),
        ) {
            let volume = camera.view_volume(min, max);
            let raster = min + (max - min) * DVec2::new(u, v);
            let raster = raster.clamp(min, max);
            let ray = camera.generate_ray(raster, on_lens, 0.0);
            let point = ray.at(t * far);
            prop_assert!(!volume.excludes(&Aabb::from_points([point])), "{ray:?} at {point}");
        }

        #[test]
        fn excluded_boxes_are_hit_by_no_ray(
            camera in any_camera(), (min, max) in any_part(), centre in vector(40.0), size in vector(10.0), seed in any::<u64>(),
        ) {
            let volume = camera.view_volume(min, max);
            let origin = camera.ray(min, 0.0).origin;
            let aabb = Aabb::from_points([origin + centre, origin + centre + size]);
            prop_assume!(volume.excludes(&aabb));
            for i in 0..64u64 {
                let unit = |k: u64| rt_math::random::unit(rt_math::random::hash(&[seed, i, k]));
                let raster = min + (max - min) * DVec2::new(unit(0), unit(1));
                let ray = camera.generate_ray(raster, [unit(2), unit(3)], 0.0);
                prop_assert_eq!(aabb.clip(&SlabRay::new(&ray), Interval::FORWARD), None, "{:?}", ray);
            }
        }
    }

    proptest! {
        #[test]
        fn excluded_balls_hold_no_point_of_a_ray(
            camera in any_camera(), (min, max) in any_part(), u in share(), v in share(), on_lens in [share(), share()], t in 0.0..1e3f64, towards in vector(1.0), radius in 0.0..50.0f64,
        ) {
            let ray = camera.generate_ray((min + (max - min) * DVec2::new(u, v)).clamp(min, max), on_lens, 0.0);
            let centre = ray.at(t) + towards.normalize_or_zero() * (radius * 0.999_999);
            prop_assert!(!camera.view_volume(min, max).excludes_sphere(centre, radius), "{ray:?} at {t}");
        }

        #[test]
        fn depth_is_the_parameter_of_camera_rays(
            camera in any_camera(), (min, max) in any_part(), u in share(), v in share(), t in 1.0..1e3f64,
        ) {
            let volume = camera.view_volume(min, max);
            let ray = camera.ray(min + (max - min) * DVec2::new(u, v), 0.0);
            let depth = volume.min_depth(&Aabb::from_points([ray.at(t)]));
            let size = ray.at(t).abs().max_element() / ray.direction.length() + t;
            prop_assert!((depth - t).abs() < 1e-9 * size, "{depth} instead of {t}");
            prop_assert_eq!(depth, volume.min_depth_of_sphere(ray.at(t), 0.0));
        }
    }

    #[test]
    fn balls_are_excluded_by_their_distance_and_have_depth() {
        let camera = camera(Projection::Orthographic { height: 4.0 });
        let volume = camera.view_volume(DVec2::ZERO, DVec2::splat(100.0));
        let centre = DVec3::new(0.0, 2.1, 0.0);
        assert!(volume.excludes_sphere(centre, 0.099) && !volume.excludes_sphere(centre, 0.101));
        assert!((volume.min_depth_of_sphere(centre, 2.0) - 5.0).abs() < 1e-12);
        assert!((volume.min_depth(&Aabb::new(DVec3::splat(-1.0), DVec3::splat(3.0))) - 4.0).abs() < 1e-12);
        assert!(!volume.excludes_sphere(centre, f64::NAN) && !volume.excludes_sphere(centre * 9.0, -1.0));
    }

    fn camera(projection: Projection) -> Camera {
        let world_from_camera = Transform::look_at(DVec3::X * 7.0, DVec3::ZERO, DVec3::Y).expect("a view");
        Camera::new(&CameraSettings::new(world_from_camera, projection), 100, 100).expect("a camera")
    }

    /// A cube of side 2·10⁻³, so that the planes differ by 1 in 1000.
    fn at(x: f64, y: f64, z: f64) -> Aabb {
        let centre = DVec3::new(x, y, z);
        Aabb::new(centre - 1e-3, centre + 1e-3)
    }

    #[test]
    fn the_planes_of_a_pinhole_camera_stand_at_the_edges_of_the_view() {
        let fov = core::f64::consts::FRAC_PI_2;
        let camera = camera(Projection::Perspective { fov, axis: FovAxis::Vertical });
        let whole = camera.view_volume(DVec2::ZERO, DVec2::splat(100.0));
        // At x = 0, 7 in front of the camera, the view reaches from −7 to 7; the camera's right is −z.
        for (y, z) in [(6.99, 0.0), (-6.99, 0.0), (0.0, 6.99), (0.0, -6.99), (6.99, 6.99)] {
            assert!(!whole.excludes(&at(0.0, y, z)), "{y} {z}");
        }
        for (y, z) in [(7.01, 0.0), (-7.01, 0.0), (0.0, 7.01), (0.0, -7.01)] {
            assert!(whole.excludes(&at(0.0, y, z)), "{y} {z}");
        }
        assert!(!whole.excludes(&at(6.99, 0.0, 0.0)) && whole.excludes(&at(7.01, 0.0, 0.0)));
        // The right half of the image alone, widened by a pixel.
        let right_half = camera.view_volume(DVec2::new(49.0, 0.0), DVec2::splat(100.0));
        assert!(right_half.excludes(&at(0.0, 0.0, 0.15)) && !right_half.excludes(&at(0.0, 0.0, 0.13)));
    }

    #[test]
    fn a_lens_has_two_planes_for_each_edge() {
        let projection = Projection::Perspective { fov: core::f64::consts::FRAC_PI_2, axis: FovAxis::Vertical };
        let world_from_camera = Transform::look_at(DVec3::X * 7.0, DVec3::ZERO, DVec3::Y).expect("a view");
        let lens = Lens { radius: 1.0, focus: 7.0, blades: None, rotation: 0.0 };
        let settings = CameraSettings { lens: Some(lens), ..CameraSettings::new(world_from_camera, projection) };
        let camera = Camera::new(&settings, 100, 100).expect("a camera");
        let volume = camera.view_volume(DVec2::ZERO, DVec2::splat(100.0));
        // At the depth t the view reaches to t + |1 − t/7|: from 1 at the lens over 7 in focus to 15 at twice the distance.
        for (x, edge) in [(6.99, 1.01), (3.5, 4.0), (0.0, 7.0), (-7.0, 15.0)] {
            for (y, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
                let (inside, outside) = (edge - 0.01, edge + 0.01);
                assert!(!volume.excludes(&at(x, y * inside, z * inside)), "{x} {y} {z}");
                assert!(volume.excludes(&at(x, y * outside, z * outside)), "{x} {y} {z}");
            }
        }
    }

    #[test]
    fn the_planes_of_an_orthographic_camera_are_parallel() {
        let volume = camera(Projection::Orthographic { height: 4.0 }).view_volume(DVec2::ZERO, DVec2::splat(100.0));
        for x in [6.9, 0.0, -1000.0] {
            assert!(!volume.excludes(&at(x, 1.99, -1.99)) && volume.excludes(&at(x, 2.01, 0.0)), "{x}");
            assert!(volume.excludes(&at(x, 0.0, 2.01)) && volume.excludes(&at(x, 0.0, -2.01)), "{x}");
        }
        assert!(volume.excludes(&at(7.1, 0.0, 0.0)), "behind the camera plane");
    }

    #[test]
    fn nothing_is_promised_about_numbers_beyond_all_measure() {
        let camera = camera(Projection::Orthographic { height: 4.0 });
        let volume = camera.view_volume(DVec2::ZERO, DVec2::splat(100.0));
        let behind = Aabb::new(DVec3::splat(8.0), DVec3::splat(f64::INFINITY));
        assert!(!volume.excludes(&behind) && !volume.excludes(&Aabb::EMPTY));
        assert!(!volume.excludes(&Aabb::new(DVec3::splat(8.0), DVec3::splat(1e200))));
        assert!(!camera.view_volume(DVec2::NAN, DVec2::NAN).excludes(&at(0.0, 9.0, 0.0)));
    }
}
