//! Where lights are, where they shine, and how much that may matter to a point.

use super::{Emission, Sides};
use rt_math::transcendental::{atan2, sincos};
use rt_math::{Aabb, DVec3, Rgb};
use std::f64::consts::{FRAC_PI_2, PI};

/// Cosines below minus this are those of light that certainly does not arrive, and others count at least as much. Sines
/// here come from 1 − cos², which near the poles leaves them half of the digits (2⁻²⁶): this is more.
const LEAST_COSINE: f64 = 1.0 / (1u64 << 20) as f64;

/// The extent of a light or of many, the cone of their normals, and their power: the node of a light tree (Conty Estevez,
/// Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterBounds {
    /// Contains the lights, world space.
    pub around: Aabb,
    /// Middle of the normals, unit.
    pub axis: DVec3,
    /// Greatest angle from the axis to a normal, 0 to π. Light leaves up to π/2 from each normal.
    pub spread: f64,
    /// What the lights count when they are compared: luminance of their power.
    pub power: f64,
}

impl EmitterBounds {
    /// Of light that shines in all directions from within a box, also from a point.
    pub fn all_around(around: Aabb, power: Rgb) -> Self {
        Self { around, axis: DVec3::Z, spread: PI, power: importance_of(power) }
    }

    /// Of a flat light with this unit normal.
    pub(super) fn of_flat(around: Aabb, normal: DVec3, emission: &Emission, area: f64) -> Self {
        let spread = match emission.sides() {
            Sides::Front => 0.0,
            Sides::Both => PI,
        };
        Self { around, axis: normal, spread, power: importance_of(emission.power(area)) }
    }

    /// Of both.
    pub fn union(&self, other: &Self) -> Self {
        let (axis, spread) = union_of_cones((self.axis, self.spread), (other.axis, other.spread));
        Self { around: self.around.union(other.around), axis, spread, power: self.power + other.power }
    }

    /// An estimate of the light that arrives at `point`: power · cos θ′ · cos θᵢ′ / d² (equation 3 of the paper), each
    /// angle the least that it can be for lights within the ball around the box. 0 only if no light can arrive.
    ///
    /// `normal`, unit, is that of a surface which is lit on this side alone; `None` if light may come from all sides.
    pub fn importance(&self, point: DVec3, normal: Option<DVec3>) -> f64 {
        let towards = self.around.centre() - point;
        let radius2 = 0.25 * self.around.extent().length_squared();
        let distance2 = towards.length_squared();
        // From within the ball all directions are possible, and the light is about as far as the ball is large.
        let weakened = self.power / distance2.max(radius2).max(f64::MIN_POSITIVE);
        if !(distance2 > radius2) {
            return finite(weakened);
        }
        let towards = towards / distance2.sqrt();
        let subtended = Angle::from_sine((radius2 / distance2).sqrt());
        let (sin, cos) = sincos(self.spread);
        let leaving = Angle::from_cosine(-self.axis.dot(towards)).minus(Angle { cos, sin }).minus(subtended);
        let arriving = normal.map_or(1.0, |normal| Angle::from_cosine(normal.dot(towards)).minus(subtended).cos);
        finite(weakened * at_least(leaving.cos) * at_least(arriving))
    }

    /// What the directions of the lights cost in a split: the solid angle into which they may shine, weighted by the
    /// cosine (section 4.2 of the paper, M_Ω, with light up to π/2 from each normal).
    pub(super) fn directions(&self) -> f64 {
        let (sin, cos) = sincos(self.spread);
        let reach = (self.spread + FRAC_PI_2).min(PI);
        let (_, cos_beyond) = sincos(self.spread - 2.0 * reach);
        let cone = 2.0 * PI * (1.0 - cos);
        cone + FRAC_PI_2 * (2.0 * reach * sin - cos_beyond - 2.0 * self.spread * sin + cos)
    }
}

/// Luminance, and something for light that is too faint to have one; at most the greatest number.
pub(super) fn importance_of(power: Rgb) -> f64 {
    if power.is_black() { 0.0 } else { power.luminance().clamp(f64::MIN_POSITIVE, f64::MAX) }
}

fn finite(importance: f64) -> f64 {
    if importance.is_nan() { 0.0 } else { importance.min(f64::MAX / 4.0) }
}

fn at_least(cos: f64) -> f64 {
    if cos < -LEAST_COSINE { 0.0 } else { cos.max(LEAST_COSINE) }
}

/// An angle from 0 to π.
#[derive(Clone, Copy)]
struct Angle {
    cos: f64,
    sin: f64,
}

impl Angle {
    fn from_cosine(cos: f64) -> Self {
        Self { cos, sin: (1.0 - cos * cos).max(0.0).sqrt() }
    }

    /// The angle up to π/2.
    fn from_sine(sin: f64) -> Self {
        Self { cos: (1.0 - sin * sin).max(0.0).sqrt(), sin }
    }

    /// The difference, or 0 if the other is greater.
    fn minus(self, other: Self) -> Self {
        if self.cos >= other.cos {
            return Self { cos: 1.0, sin: 0.0 };
        }
        Self {
            cos: self.cos * other.cos + self.sin * other.sin,
            sin: (self.sin * other.cos - self.cos * other.sin).max(0.0),
        }
    }
}

/// The smallest cone around two, each an axis and an angle (algorithm 1 of the paper).
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
