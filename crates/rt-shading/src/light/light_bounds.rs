//! Bounds of lights, and their importance for a point.

use super::{Emission, EmissionSides};
use rt_math::transcendental::{atan2, sincos};
use rt_math::{Aabb, DVec3, Mask, Real, Rgb, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Light with a cosine below minus this certainly does not arrive; other cosines count at least as much. Sines come from
/// 1 − cos², which near the poles leaves half of the digits (2⁻²⁶): this is more.
const MIN_COSINE: f64 = 1.0 / (1u64 << 20) as f64;

/// Box around lights, cone of their normals, and power: the node of a light tree.
///
/// Conty Estevez, Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBounds {
    around: Aabb,
    axis: DVec3,
    spread: f64,
    /// Cosine and sine of the spread.
    edge: Angle<f64>,
    power: f64,
}

/// Extent of a light, as a light tree treats it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightExtent {
    /// Light without power.
    Black,
    /// Light within bounds.
    Bounded(LightBounds),
    /// Light from all directions, as an environment.
    Unbounded,
}

impl LightBounds {
    /// Bounds of lights within a box (world space) whose normals are within the angle `spread` (0 to π) of the unit `axis`.
    /// Light leaves up to π/2 from each normal; a light without normals, as a point, has the spread π.
    pub fn new(around: Aabb, axis: DVec3, spread: f64, power: Rgb) -> Self {
        // Positive where the luminance underflows, finite where it overflows.
        let counted = if power.is_black() { 0.0 } else { power.luminance().clamp(f64::MIN_POSITIVE, f64::MAX) };
        Self::of_parts(around, (axis, spread), counted)
    }

    /// Bounds of light in all directions from within a box or from a point.
    pub fn all_around(around: Aabb, power: Rgb) -> Self {
        Self::new(around, DVec3::Z, PI, power)
    }

    /// Bounds of a flat light with this unit normal.
    pub(super) fn of_flat(around: Aabb, normal: DVec3, emission: &Emission, area: f64) -> Self {
        let spread = match emission.sides() {
            EmissionSides::Front => 0.0,
            EmissionSides::Both => PI,
        };
        Self::new(around, normal, spread, emission.power(area))
    }

    fn of_parts(around: Aabb, (axis, spread): (DVec3, f64), power: f64) -> Self {
        let (sin, cos) = sincos(spread);
        Self { around, axis, spread, edge: Angle { cos, sin }, power }
    }

    /// Box around the lights, world space.
    pub const fn around(&self) -> Aabb {
        self.around
    }

    /// Axis of the cone of normals, unit.
    pub const fn axis(&self) -> DVec3 {
        self.axis
    }

    /// Greatest angle from the axis to a normal, 0 to π.
    pub const fn spread(&self) -> f64 {
        self.spread
    }

    /// Luminance of the power.
    pub const fn power(&self) -> f64 {
        self.power
    }

    /// Bounds of both.
    pub fn union(&self, other: &Self) -> Self {
        let cone = union_of_cones((self.axis, self.spread), (other.axis, other.spread));
        Self::of_parts(self.around.union(other.around), cone, self.power + other.power)
    }

    /// Estimate of incident light at `point`: power · cos θ′ · cos θᵢ′ / d² (equation 3 of the paper). Each angle is the smallest
    /// for lights within the sphere around the box. 0 only if no light can arrive.
    ///
    /// `normal` (unit) restricts light to the side that it points to; `None` if light from all sides counts.
    pub fn importance(&self, point: DVec3, normal: Option<DVec3>) -> f64 {
        self.importance_lanes(point.into(), normal.map(Vector3::from))
    }

    /// Version of [`importance`](Self::importance) for one number or for lanes.
    #[inline(always)]
    pub(super) fn importance_lanes<R: Real>(&self, point: Vector3<R>, normal: Option<Vector3<R>>) -> R {
        let like = point.x;
        let towards = Vector3::splat(like, self.around.centre()) - point;
        let radius2 = like.splat(0.25 * self.around.extent().length_squared());
        let distance2 = towards.length_squared();
        // Inside of the sphere all directions are possible, and its radius stands for the distance.
        let weakened = like.splat(self.power) / radius2.max(distance2).max(like.splat(f64::MIN_POSITIVE));
        let is_outside = distance2.gt(radius2);
        if !is_outside.any() {
            return finite(weakened);
        }
        let towards = towards / distance2.sqrt();
        let subtended = Angle::from_sine((radius2 / distance2).sqrt());
        let edge = Angle { cos: like.splat(self.edge.cos), sin: like.splat(self.edge.sin) };
        let axis = Vector3::splat(like, self.axis);
        let leaving = Angle::from_cosine(-axis.dot(towards)).minus(edge).minus(subtended);
        let arriving = match normal {
            Some(normal) => Angle::from_cosine(normal.dot(towards)).minus(subtended).cos,
            None => like.splat(1.0),
        };
        let outside = weakened * at_least(leaving.cos) * at_least(arriving);
        finite(R::select(is_outside, outside, weakened))
    }

    /// Cost of the directions in a split: the solid angle of emission, weighted by the cosine. This is M_Ω of section 4.2 of the
    /// paper, with light up to π/2 from each normal.
    pub(super) fn directions(&self) -> f64 {
        let Angle { sin, cos } = self.edge;
        let reach = (self.spread + FRAC_PI_2).min(PI);
        let (_, cos_beyond) = sincos(self.spread - 2.0 * reach);
        let cone = 2.0 * PI * (1.0 - cos);
        cone + FRAC_PI_2 * (2.0 * reach * sin - cos_beyond - 2.0 * self.spread * sin + cos)
    }
}

#[inline(always)]
fn finite<R: Real>(importance: R) -> R {
    let (zero, max) = (importance.splat(0.0), importance.splat(f64::MAX / 4.0));
    R::select(importance.eq(importance), importance.min(max), zero)
}

#[inline(always)]
fn at_least<R: Real>(cos: R) -> R {
    let min = cos.splat(MIN_COSINE);
    R::select(cos.lt(-min), cos.splat(0.0), min.max(cos))
}

/// An angle from 0 to π.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Angle<R> {
    cos: R,
    sin: R,
}

impl<R: Real> Angle<R> {
    #[inline(always)]
    fn from_cosine(cos: R) -> Self {
        Self { cos, sin: other_leg(cos) }
    }

    /// The angle up to π/2.
    #[inline(always)]
    fn from_sine(sin: R) -> Self {
        Self { cos: other_leg(sin), sin }
    }

    /// The difference, or 0 if the other is greater.
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        let (zero, one) = (self.cos.splat(0.0), self.cos.splat(1.0));
        let is_less = self.cos.ge(other.cos);
        let cos = self.cos * other.cos + self.sin * other.sin;
        let sin = zero.max(self.sin * other.cos - self.cos * other.sin);
        Self { cos: R::select(is_less, one, cos), sin: R::select(is_less, zero, sin) }
    }
}

/// √(1 − x²), of a sine or cosine.
#[inline(always)]
fn other_leg<R: Real>(x: R) -> R {
    x.splat(0.0).max(x.splat(1.0) - x * x).sqrt()
}

/// Smallest cone around two, each an axis and an angle (algorithm 1 of the paper).
fn union_of_cones(a: (DVec3, f64), b: (DVec3, f64)) -> (DVec3, f64) {
    let (wide, narrow) = if a.1 >= b.1 { (a, b) } else { (b, a) };
    let across = wide.0.cross(narrow.0);
    let between = atan2(across.length(), wide.0.dot(narrow.0));
    if between + narrow.1 <= wide.1 {
        return wide;
    }
    let spread = 0.5 * (wide.1 + between + narrow.1);
    let sideways = across.cross(wide.0).normalize_or_zero();
    if spread >= PI || sideways == DVec3::ZERO {
        return (wide.0, PI);
    }
    let (sin, cos) = sincos(spread - wide.1);
    ((wide.0 * cos + sideways * sin).normalize(), spread)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::random::{hash, unit};
    use rt_math::transcendental::acos;

    fn vector(i: u64, dimension: u64) -> DVec3 {
        let draw = |axis| 2.0 * unit(hash(&[i, dimension, axis])) - 1.0;
        DVec3::new(draw(0), draw(1), draw(2))
    }

    #[test]
    fn a_cone_around_two_holds_both() {
        for i in 0..2000 {
            let cones = [0, 1].map(|k| (vector(i, k).normalize(), unit(hash(&[i, k, 7])) * 2.0));
            let (axis, spread) = union_of_cones(cones[0], cones[1]);
            assert!((axis.length() - 1.0).abs() < 1e-14);
            for (other, angle) in cones {
                let farthest = acos(axis.dot(other).clamp(-1.0, 1.0)) + angle;
                assert!(spread >= farthest.min(PI) - 1e-7, "{spread} does not reach {farthest}");
            }
        }
        assert_eq!(union_of_cones((DVec3::Z, 0.0), (DVec3::NEG_Z, 0.0)).1, PI);
        assert_eq!(union_of_cones((DVec3::Z, 0.3), (DVec3::Z, 0.1)), (DVec3::Z, 0.3));
    }

    /// A single normal has the measure π, all normals have 4π.
    #[test]
    fn directions_are_weighed_as_in_the_paper() {
        let of = |spread| LightBounds::new(Aabb::new(DVec3::ZERO, DVec3::ONE), DVec3::Z, spread, Rgb::WHITE);
        assert!((of(0.0).directions() - PI).abs() < 1e-14);
        assert!((of(PI).directions() - 4.0 * PI).abs() < 1e-14);
        assert!((1..20).all(|i| of(f64::from(i) * 0.15).directions() > of(f64::from(i - 1) * 0.15).directions()));
    }

    #[test]
    fn importance_of_a_small_light_is_that_of_a_point() {
        let (around, axis) = (Aabb::new(DVec3::ZERO, DVec3::ZERO), DVec3::new(0.0, 0.6, 0.8));
        let light = LightBounds::new(around, axis, 0.0, Rgb::gray(5.0));
        let above = light.importance(DVec3::Z * 2.0, Some(DVec3::new(0.6, 0.0, -0.8)));
        assert!((above - 5.0 * 0.8 * 0.8 / 4.0).abs() < 1e-14, "{above}");
        assert_eq!(light.importance(DVec3::NEG_Z, None), 0.0, "behind the light");
        assert_eq!(light.importance(DVec3::Z, Some(DVec3::Z)), 0.0, "behind the receiver");
        assert!(light.importance(DVec3::ZERO, None).is_finite(), "at the light");
    }
}
