//! Tori.

use crate::error::{ShapeError, check_radius};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction, bracketed_root::bracketed_root, quadric_side::azimuth};
use rt_math::float::{UNIT_ROUNDOFF, cross, gamma, power_of_two_scale};
use rt_math::transcendental::{atan2, cbrt};
use rt_math::{Aabb, DVec3, Interval, Ray};
use std::f64::consts::TAU;

/// A ring around the y axis: the surface at distance `tube_radius` from a circle of `radius` in the plane y = 0. Its
/// normal points out of the tube.
///
/// Texture coordinates: `u` runs once around +y as on a [`Sphere`](crate::Sphere), with +z at ½. `v` runs around the
/// tube, upwards on the outside with ½ at its middle, and has its seam on the inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torus {
    radius: f64,
    tube_radius: f64,
}

impl Torus {
    /// The ring with this radius of its middle circle and this radius of its tube.
    ///
    /// # Errors
    /// If a radius is not positive (at least 1e-60) or not finite, or if the tube is so thick that it closes the hole:
    /// the surface would pass through itself.
    pub fn new(radius: f64, tube_radius: f64) -> Result<Self, ShapeError> {
        check_radius(radius)?;
        check_radius(tube_radius)?;
        if tube_radius < radius {
            Ok(Self { radius, tube_radius })
        } else {
            Err(ShapeError::ClosedHole { radius, tube_radius })
        }
    }

    /// Radius of the circle in the middle of the tube.
    pub const fn radius(&self) -> f64 {
        self.radius
    }

    /// Radius of the tube, less than [`radius`](Self::radius).
    pub const fn tube_radius(&self) -> f64 {
        self.tube_radius
    }

    /// The smallest box around the torus, rounded outwards.
    pub fn bounds(&self) -> Aabb {
        let reach = (self.radius + self.tube_radius).next_up();
        let reach = DVec3::new(reach, self.tube_radius, reach);
        Aabb::new(-reach, reach)
    }

    /// Support function: the largest dot product of a direction with a point of the torus.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        self.radius * DVec3::new(direction.x, 0.0, direction.z).length() + self.tube_radius * direction.length()
    }

    /// First of up to four intersections within `span`. `None` on a miss, and for rays without a direction.
    ///
    /// The quartic is never expanded, as its coefficients would cancel for a thin tube. `Chord::excess` has the sign of
    /// the quartic and is evaluated from geometry. The roots of its slope split the ray into intervals in which it is
    /// monotone. A change of sign in an interval brackets one root.
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let chord = Chord::new(self, ray).filter(|chord| !chord.passes_by())?;
        let mut start = (-chord.reach, chord.excess(-chord.reach));
        // Splits behind the hit are not needed, and no roots outside of the span.
        for split in chord.splits() {
            let end = (split, chord.excess(split));
            // The surface counts as inside: a tangent ray hits it twice at the same parameter.
            if (start.1 > 0.0) != (end.1 > 0.0) && chord.t_from_arc(split) >= span.min {
                let s = bracketed_root(|s| chord.excess(s), [start.0, end.0], UNIT_ROUNDOFF * self.tube_radius);
                let t = chord.t_from_arc(s);
                if t >= span.min {
                    return (t <= span.max).then_some(ShapeHit { t, uv: [s, 0.0] });
                }
            }
            if chord.t_from_arc(split) > span.max {
                return None;
            }
            start = end;
        }
        None
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
        // The distance along the chord is sharper than `t`, which is rounded to the grid of a faraway origin.
        let on_ray = Chord::new(self, ray).map_or_else(|| ray.at(hit.t), |chord| chord.at(hit.uv[0]));
        let towards_viewer = -ray.direction.normalize_or(DVec3::Y);
        let away = DVec3::new(on_ray.x, 0.0, on_ray.z).normalize_or(DVec3::Z);
        let outwards = DVec3::new(on_ray.x, 0.0, on_ray.z).length() - self.radius;
        let normal = (away * outwards + DVec3::Y * on_ray.y).try_normalize().unwrap_or(towards_viewer);
        let point = away * self.radius + normal * self.tube_radius;
        // The kernel sees the point after it is moved to the middle of its chord and back.
        let point_error = normal.abs() * (gamma(24) * (self.radius + self.tube_radius));
        let uv = if needs.uv { [azimuth(away), 0.5 + atan2(on_ray.y, outwards) / TAU] } else { [0.0; 2] };
        SurfaceInteraction::flat(point, point_error, normal, uv)
    }
}

/// The part of a ray near a torus, by the signed distance s from where the ray is nearest to the centre.
struct Chord<'a> {
    torus: &'a Torus,
    /// Point of the ray nearest to the centre: perpendicular to the direction.
    middle: DVec3,
    /// The unit direction.
    towards: DVec3,
    /// Ray parameter of the middle.
    t_middle: f64,
    /// Length of the ray's direction.
    speed: f64,
    /// Distance from the middle at which the ray is certainly outside.
    reach: f64,
}

impl<'a> Chord<'a> {
    /// `None` if the ray passes by the sphere around the torus, has a NaN or no direction.
    fn new(torus: &'a Torus, ray: &Ray) -> Option<Self> {
        let scale = power_of_two_scale(ray.direction);
        let (o, d) = (ray.origin, ray.direction * scale);
        let square = d.dot(d);
        // Not o + t·d, which would be off by a rounding error of a faraway origin.
        let middle = cross(d, cross(o, d)) / square;
        let towards = d / square.sqrt();
        let (speed, t_middle) = (square.sqrt() / scale, -o.dot(d) / square * scale);
        // Wider than the torus by more than rounding: the ends of the chord are outside.
        let outer = (torus.radius + torus.tube_radius) * (1.0 + 1.0 / 1024.0);
        let reach = (outer * outer - middle.dot(middle)).sqrt();
        let is_sound = reach > 0.0 && t_middle.is_finite() && speed > 0.0 && speed.is_finite();
        is_sound.then_some(Self { torus, middle, towards, t_middle, speed, reach })
    }

    /// True if the ray passes through the hole or outside of the ring wherever it is at the height of the tube.
    fn passes_by(&self) -> bool {
        let (m, d, Torus { radius, tube_radius }) = (self.middle, self.towards, *self.torus);
        // Wider than the tube by more than rounding.
        let thickness = tube_radius * (1.0 + 1.0 / 1024.0) + radius * UNIT_ROUNDOFF * 1024.0;
        // Infinite or NaN for a level ray, which stays at its height.
        let heights = [(-thickness - m.y) / d.y, (thickness - m.y) / d.y];
        let (from, to) = (heights[0].min(heights[1]).max(-self.reach), heights[0].max(heights[1]).min(self.reach));
        let nearest = -(m.x * d.x + m.z * d.z) / (d.x * d.x + d.z * d.z);
        let from_axis = |s: f64| {
            let p = self.at(s);
            (p.x * p.x + p.z * p.z).sqrt()
        };
        from > to
            || from_axis(from).max(from_axis(to)) < radius - thickness
            || from_axis(nearest.max(from).min(to)) > radius + thickness
    }

    fn at(&self, s: f64) -> DVec3 {
        self.middle + self.towards * s
    }

    fn t_from_arc(&self, s: f64) -> f64 {
        self.t_middle + s / self.speed
    }

    /// The squared distance from the middle circle of the tube less its squared radius: negative inside.
    fn excess(&self, s: f64) -> f64 {
        let p = self.at(s);
        let outwards = (p.x * p.x + p.z * p.z).sqrt() - self.torus.radius;
        (outwards - self.torus.tube_radius) * (outwards + self.torus.tube_radius) + p.y * p.y
    }

    /// Half the derivative of the excess.
    fn slope(&self, s: f64) -> f64 {
        let (p, d) = (self.at(s), self.towards);
        let from_axis = (p.x * p.x + p.z * p.z).sqrt();
        let radial = p.x * d.x + p.z * d.z;
        let growth = if from_axis > 0.0 { radial / from_axis } else { 0.0 };
        (from_axis - self.torus.radius) * growth + p.y * d.y
    }

    /// Ascending distances up to which the excess is monotone, from the start of the chord to its end. Both are outside.
    ///
    /// The distance h from the axis has h² = A·(s − v)² + K/A. A is the square of the direction's part across the axis,
    /// and K = (m × d)² for the middle m, also across. The derivative of the slope is 1 − R·K/h³: the slope falls
    /// within a stretch around v, where h³ < R·K, and grows outside of it. So it has at most one zero in each of the
    /// three.
    fn splits(&self) -> impl Iterator<Item = f64> {
        let (m, d) = (self.middle, self.towards);
        let across = d.x * d.x + d.z * d.z;
        let m_cross_d = m.x * d.z - m.z * d.x;
        let nearest = -(m.x * d.x + m.z * d.z) / across;
        let turning = cbrt(self.torus.radius * m_cross_d * m_cross_d);
        let half = ((turning * turning - m_cross_d * m_cross_d / across) / across).max(0.0).sqrt();
        // If the ray meets the axis, the slope jumps there: between two places that differ.
        let half = half.max(self.reach * f64::EPSILON);
        let inside = |s: f64| s.clamp(-self.reach, self.reach);
        // A ray along the axis has no such stretch.
        let (fall_start, fall_end) =
            if across > 0.0 { (inside(nearest - half), inside(nearest + half)) } else { (self.reach, self.reach) };
        let stretches = [[-self.reach, fall_start], [fall_start, fall_end], [fall_end, self.reach]];
        stretches.into_iter().map(|[a, b]| self.zero_of_slope(a, b)).chain([self.reach])
    }

    /// Root of the slope; an end of the interval without a change of sign.
    fn zero_of_slope(&self, a: f64, b: f64) -> f64 {
        if (self.slope(a) > 0.0) == (self.slope(b) > 0.0) {
            return b;
        }
        bracketed_root(|s| self.slope(s), [a, b], UNIT_ROUNDOFF * self.torus.tube_radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategies::vector;
    use proptest::prelude::*;
    use rt_math::random;

    fn torus(radius: f64, tube_radius: f64) -> Torus {
        Torus::new(radius, tube_radius).expect("a torus")
    }

    /// All crossings, one by one through `span.min`.
    fn crossings(torus: Torus, ray: &Ray) -> Vec<f64> {
        let mut found: Vec<f64> = Vec::new();
        let mut min = f64::NEG_INFINITY;
        while let Some(hit) = torus.intersect(ray, Interval::new(min, f64::INFINITY)) {
            found.push(hit.t);
            min = hit.t.next_up();
        }
        found
    }

    /// Roots of the quartic in 80-digit arithmetic, for exactly these numbers.
    #[test]
    fn known_roots_keep_their_digits() {
        type Case<'a> = (f64, [f64; 3], [f64; 3], &'a [f64]);
        let cases: [Case; 9] = [
            (
                0.25,
                [-3.0, 0.1, 0.2],
                [1.0, 0.0, 0.0],
                &[1.787_252_058_548_198, 2.255525399691557, 3.744474600308443, 4.212747941451802],
            ),
            (
                0.25,
                [-3.0, 0.5, 0.3],
                [1.0, -0.15, 0.02],
                &[1.919390740603132, 2.2701281479264253, 3.656048843881147, 4.155605402793128],
            ),
            // In the plane of the ring.
            (0.25, [-3.0, 0.0, 0.0], [1.0, 0.0, 0.0], &[1.75, 2.25, 3.75, 4.25]),
            (
                0.25,
                [-6e5 + 0.4, 3.0, -8e5 - 0.3],
                [0.6, -3e-6, 0.8],
                &[999998.8543560763, 999999.4409830056, 1000000.5590169944, 1000001.1456439237],
            ),
            // Wires.
            (
                1e-4,
                [-3.0, 2e-5, 0.5],
                [1.0, 1e-5, 0.0],
                &[2.1338694559237983, 2.1340797385961484, 3.865931885434002, 3.866118918046051],
            ),
            (1e-4, [0.3, 5.0, 0.954], [0.0, -1.0, 0.0], &[4.999918537155108, 5.000081462844892]),
            (
                1e-4,
                [-1e6, 5e-5, 0.7],
                [1.0, 0.0, 0.0],
                &[999999.2857358944, 999999.28597843, 1000000.71402157, 1000000.7142641056],
            ),
            // Hardly a hole.
            (0.999, [0.1, 4.0, 0.2], [0.01, -1.0, 0.02], &[3.2900442208559126, 4.740_661_785_690_81]),
            (0.25, [0.0, 3.0, 0.0], [0.0, -1.0, 0.0], &[]),
        ];
        for (tube_radius, origin, direction, exact) in cases {
            let ray = Ray::new(origin.into(), direction.into());
            let found = crossings(torus(1.0, tube_radius), &ray);
            assert_eq!(found.len(), exact.len(), "{origin:?}: {found:?}");
            for (t, exact) in found.into_iter().zip(exact) {
                assert!((t - exact).abs() <= 1e-15 * exact, "{origin:?}: {t} instead of {exact}");
            }
        }
    }

    #[test]
    fn from_inside_the_tube_the_way_out_comes_first() {
        let ray = Ray::new(DVec3::new(2.0, 0.0, 0.1), DVec3::new(-1.0, 0.05, 0.0));
        let found = crossings(torus(2.0, 0.5), &ray);
        let exact = [-0.497_379_853_789_345_5, 0.5027034597807883, 3.528900773321398, 4.445_825_495_998_88];
        assert_eq!(found.len(), 4);
        assert!(found.iter().zip(exact).all(|(t, exact)| (t - exact).abs() < 1e-14), "{found:?}");
        let first = torus(2.0, 0.5).intersect(&ray, Interval::FORWARD).map(|hit| hit.t);
        assert_eq!(first, Some(found[1]));
        let short = Interval::new(0.0, found[1].next_down());
        assert_eq!(torus(2.0, 0.5).intersect(&ray, short), None);
    }

    /// Tangents: a ray one number nearer crosses twice, one number farther misses.
    #[test]
    fn tangents_have_two_crossings_or_none() {
        let lid = |y: f64| crossings(torus(1.0, 0.25), &Ray::new(DVec3::new(-3.0, y, 0.0), DVec3::X));
        assert_eq!(lid(0.25f64.next_up()).len(), 0);
        let found = lid(0.25f64.next_down());
        assert!(found.len() == 4 || found.len() == 2, "{found:?}");
        assert!(found.iter().all(|t| (t - 2.0).abs() < 1e-7 || (t - 4.0).abs() < 1e-7), "{found:?}");
        // Along the outside of the ring, in its plane.
        let outside = |x: f64| crossings(torus(1.0, 0.25), &Ray::new(DVec3::new(x, 0.0, -3.0), DVec3::Z));
        assert_eq!(outside(1.25f64.next_up()).len(), 0);
        assert_eq!(outside(1.25 - 1e-12).len(), 2);
        // Along the inside of the ring: through the tube, or cut by its inner wall.
        assert_eq!(outside(0.75 + 1e-12).len(), 2);
        assert_eq!(outside(0.75 - 1e-12).len(), 4);
    }

    #[test]
    fn rays_across_the_axis_are_not_lost_in_its_kink() {
        for k in 0..2000u64 {
            let draw = |i: u64| random::unit(random::hash(&[k, i])) - 0.5;
            let across = DVec3::new(draw(0), 0.0, draw(2)).normalize_or(DVec3::X);
            let direction = across + DVec3::Y * (0.4 * draw(1));
            let ray = Ray::new(DVec3::Y * (0.4 * draw(3)) - direction * 20.0, direction);
            assert_eq!(crossings(torus(1.0, 0.6), &ray).len(), 4, "ray {k}");
        }
    }

    #[test]
    fn texture_coordinates_run_around_the_ring_and_the_tube() {
        let uv = |origin: [f64; 3], direction: [f64; 3]| {
            let ray = Ray::new(origin.into(), direction.into());
            let hit = torus(1.0, 0.25).intersect(&ray, Interval::FORWARD).expect("a hit");
            torus(1.0, 0.25).surface(&ray, &hit, InteractionFlags::ALL).uv
        };
        assert_eq!(uv([0.0, 0.0, 3.0], [0.0, 0.0, -1.0]), [0.5, 0.5]);
        assert_eq!(uv([3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), [0.75, 0.5]);
        let top = uv([1.0, 3.0, 0.0], [0.0, -1.0, 0.0]);
        assert!((top[0] - 0.75).abs() < 1e-15 && (top[1] - 0.75).abs() < 1e-15, "{top:?}");
    }

    proptest! {
        #[test]
        fn hits_lie_on_the_torus(
            radius in 0.1..10.0f64, log_thickness in -5.0..-1e-6f64, from in vector(1.0), log_far in 0.0..6.0f64, to in vector(1.0),
        ) {
            let ten_to = |x: f64| rt_math::transcendental::pow(10.0, x);
            let torus = torus(radius, radius * ten_to(log_thickness));
            // Towards a point inside the tube.
            let on_circle = DVec3::new(to.x, 0.0, to.z).normalize_or(DVec3::X) * radius;
            let inside = on_circle + to * (0.5 * torus.tube_radius());
            let ray = Ray::new(from * (10.0 * ten_to(log_far)), inside - from * (10.0 * ten_to(log_far)));
            let found = crossings(torus, &ray);
            prop_assert!(log_far + log_thickness.abs() > 5.0 || found.len() >= 2, "{found:?}");
            prop_assert!(found.len().is_multiple_of(2) && found.len() <= 4, "{found:?}");
            for t in found {
                let hit = torus.intersect(&ray, Interval::new(t, t)).expect("this very crossing");
                let surface = torus.surface(&ray, &hit, InteractionFlags::ALL);
                let (p, normal) = (surface.point, surface.geometric_normal);
                let outwards = DVec3::new(p.x, 0.0, p.z).length() - radius;
                let gap = DVec3::new(outwards, p.y, 0.0).length() - torus.tube_radius();
                prop_assert!(gap.abs() <= normal.abs().dot(surface.point_error), "{gap}");
                prop_assert!((p - ray.at(t)).length() < 1e-15 * ray.origin.length() + 1e-13 * radius);
                prop_assert!((normal.length() - 1.0).abs() < 1e-15);
                prop_assert!(torus.bounds().padded().contains(p));
                prop_assert!(surface.uv.iter().all(|x| (0.0..=1.0).contains(x)), "{:?}", surface.uv);
            }
        }

        /// Between its crossings the ray alternates between outside and inside, by the distance to the circle.
        #[test]
        fn crossings_separate_inside_from_outside(
            thickness in 0.05..0.95f64, from in vector(3.0), to in vector(1.2),
        ) {
            let torus = torus(1.0, thickness);
            let ray = Ray::new(from, to - from);
            let found = crossings(torus, &ray);
            let depth = |t: f64| {
                let p = ray.at(t);
                thickness - DVec3::new(DVec3::new(p.x, 0.0, p.z).length() - 1.0, p.y, 0.0).length()
            };
            for step in 0..400 {
                let t = -1.0 + 0.0125 * f64::from(step);
                let before = found.iter().filter(|&&root| root < t).count();
                prop_assert!(depth(t).abs() < 1e-9 || (depth(t) > 0.0) == (before % 2 == 1), "t {t}: {found:?}");
            }
        }

        #[test]
        fn t_scales_exactly_with_the_direction(from in vector(3.0), to in vector(1.0), k in -60i32..60) {
            let scale = rt_math::transcendental::exp2(f64::from(k));
            let ray = Ray::new(from, to - from);
            let scaled = Ray::new(from, (to - from) * scale);
            let plain = crossings(torus(1.0, 0.5), &ray);
            prop_assert_eq!(plain, crossings(torus(1.0, 0.5), &scaled).into_iter().map(|t| t * scale).collect::<Vec<_>>());
        }
    }
}
