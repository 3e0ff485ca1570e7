//! Tori.

use crate::bracketed_root::bracketed_root;
use crate::error::{ShapeError, check_radius};
use crate::lateral::longitude;
use crate::{ShapeHit, SurfaceInteraction, SurfaceNeeds};
use rt_math::float::{UNIT_ROUNDOFF, cross, gamma};
use rt_math::transcendental::{atan2, cbrt};
use rt_math::{Aabb, DVec3, Interval, Ray};
use std::f64::consts::TAU;

/// A ring around the y axis: the surface at distance `tube_radius` from a circle of `radius` in the plane y = 0. Its
/// normal points out of the tube.
///
/// Texture coordinates: `u` runs once around +y as on a [`Sphere`](crate::Sphere), with +z at ½; `v` runs around the
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

    /// How far the torus reaches in a direction: the greatest dot product with one of its points.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        self.radius * DVec3::new(direction.x, 0.0, direction.z).length() + self.tube_radius * direction.length()
    }

    /// The first of up to four crossings within `span`. `None` on a miss, and for rays without a direction.
    ///
    /// The quartic is never expanded, as its coefficients would swallow a thin tube. The excess of [`Chord::excess`]
    /// has the sign of the quartic and is evaluated from geometry; the zeros of its slope split the ray into stretches
    /// where it is monotone, and in each of them a change of sign brackets one root.
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let chord = Chord::new(self, ray)?;
        let splits = chord.splits();
        let mut start = (splits[0], chord.excess(splits[0]));
        for &split in &splits[1..] {
            let end = (split, chord.excess(split));
            // On the surface counts as inside: a ray that touches it meets it twice at the same place.
            if (start.1 > 0.0) != (end.1 > 0.0) {
                let s = bracketed_root(|s| chord.excess(s), [start.0, end.0], UNIT_ROUNDOFF * self.tube_radius);
                let t = chord.t_from_arc(s);
                if t >= span.min {
                    return (t <= span.max).then_some(ShapeHit { t, uv: [s, 0.0] });
                }
            }
            start = end;
        }
        None
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: SurfaceNeeds) -> SurfaceInteraction {
        // The distance along the chord is sharper than `t`, which is rounded to the grid of a faraway origin.
        let on_ray = Chord::new(self, ray).map_or_else(|| ray.at(hit.t), |chord| chord.at(hit.uv[0]));
        let towards_viewer = -ray.direction.normalize_or(DVec3::Y);
        let away = DVec3::new(on_ray.x, 0.0, on_ray.z).normalize_or(DVec3::Z);
        let outwards = DVec3::new(on_ray.x, 0.0, on_ray.z).length() - self.radius;
        let normal = (away * outwards + DVec3::Y * on_ray.y).try_normalize().unwrap_or(towards_viewer);
        let point = away * self.radius + normal * self.tube_radius;
        // The kernel sees the point after it is moved to the middle of its chord and back.
        let point_error = normal.abs() * (gamma(24) * (self.radius + self.tube_radius));
        let uv = if needs.uv { [longitude(away), 0.5 + atan2(on_ray.y, outwards) / TAU] } else { [0.0; 2] };
        SurfaceInteraction::flat(point, point_error, normal, uv)
    }
}

/// The part of a ray near a torus, by the signed distance s from where the ray is nearest to the centre.
struct Chord<'a> {
    torus: &'a Torus,
    /// Where the ray is nearest to the centre: perpendicular to the direction.
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
        let (o, d) = (ray.origin, ray.direction);
        let square = d.dot(d);
        // Not o + t·d, which would be off by a rounding error of a faraway origin.
        let middle = cross(d, cross(o, d)) / square;
        let (speed, t_middle) = (square.sqrt(), -o.dot(d) / square);
        // Wider than the torus by more than rounding: the ends of the chord are outside.
        let outer = (torus.radius + torus.tube_radius) * (1.0 + 1.0 / 1024.0);
        let reach = (outer * outer - middle.dot(middle)).sqrt();
        let is_sound = reach > 0.0 && t_middle.is_finite() && speed > 0.0 && speed.is_finite();
        is_sound.then(|| Self { torus, middle, towards: d / speed, t_middle, speed, reach })
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

    /// Ascending distances between which the excess is monotone; the first and the last are outside.
    ///
    /// The distance h from the axis has h² = A·(s − v)² + K/A, with A the square of the direction's part across the
    /// axis and K = (m × d)² for the middle m, also across. The derivative of the slope is 1 − R·K/h³: the slope falls
    /// within a stretch around v, where h³ < R·K, and grows outside of it. So it has at most one zero in each of the
    /// three.
    fn splits(&self) -> [f64; 5] {
        let (m, d) = (self.middle, self.towards);
        let across = d.x * d.x + d.z * d.z;
        let moment = m.x * d.z - m.z * d.x;
        let nearest = -(m.x * d.x + m.z * d.z) / across;
        let turning = cbrt(self.torus.radius * moment * moment);
        let half = ((turning * turning - moment * moment / across) / across).max(0.0).sqrt();
        // If the ray meets the axis, the slope jumps there: between two places that differ.
        let half = half.max(self.reach * f64::EPSILON);
        let inside = |s: f64| s.clamp(-self.reach, self.reach);
        // A ray along the axis has no such stretch.
        let (fall_start, fall_end) =
            if across > 0.0 { (inside(nearest - half), inside(nearest + half)) } else { (self.reach, self.reach) };
        [
            -self.reach,
            self.zero_of_slope(-self.reach, fall_start),
            self.zero_of_slope(fall_start, fall_end),
            self.zero_of_slope(fall_end, self.reach),
            self.reach,
        ]
    }

    /// Where the slope changes its sign; an end if it does not.
    fn zero_of_slope(&self, a: f64, b: f64) -> f64 {
        if (self.slope(a) > 0.0) == (self.slope(b) > 0.0) {
            return b;
        }
        bracketed_root(|s| self.slope(s), [a, b], UNIT_ROUNDOFF * self.torus.tube_radius)
    }
}
