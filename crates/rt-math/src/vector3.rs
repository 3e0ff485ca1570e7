//! Vectors of three numbers, each of which may be several in SIMD lanes.

use crate::Real;
use core::ops::{Add, Div, Mul, Neg, Sub};
use glam::DVec3;

/// Vector of three [`Real`] numbers. For one `f64` it has the same bits as [`DVec3`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vector3<R> {
    /// First coordinate.
    pub x: R,
    /// Second coordinate.
    pub y: R,
    /// Third coordinate.
    pub z: R,
}

impl<R> Vector3<R> {
    /// Vector of these coordinates.
    #[inline(always)]
    pub const fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }
}

impl<R: Real> Vector3<R> {
    /// The vector `v` in all lanes; `like` is any number with as many lanes.
    #[inline(always)]
    pub fn splat(like: R, v: DVec3) -> Self {
        Self::new(like.splat(v.x), like.splat(v.y), like.splat(v.z))
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Vector product; near parallel vectors, rounding errors may change the signs of its coordinates.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    /// Product of each coordinate with that of the other vector, as of a colour with a filter.
    #[inline(always)]
    pub fn scaled_by(self, other: Self) -> Self {
        Self::new(self.x * other.x, self.y * other.y, self.z * other.z)
    }

    /// Squared length.
    #[inline(always)]
    pub fn length_squared(self) -> R {
        self.dot(self)
    }

    /// Length.
    #[inline(always)]
    pub fn length(self) -> R {
        self.length_squared().sqrt()
    }

    /// Unit vector of the same direction, as [`DVec3::try_normalize`]; not valid where the mask is false.
    #[inline(always)]
    pub fn try_normalize(self) -> (Self, R::Mask) {
        let recip = self.length().recip();
        (self * recip, recip.gt(recip.splat(0.0)) & recip.le(recip.splat(R::MAX)))
    }

    /// True if no coordinate is NaN or infinite.
    #[inline(always)]
    pub fn is_finite(self) -> R::Mask {
        let max = self.x.splat(R::MAX);
        let Self { x, y, z } = self.abs();
        x.le(max) & y.le(max) & z.le(max)
    }

    /// Absolute values of the coordinates.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self::new(self.x.abs(), self.y.abs(), self.z.abs())
    }

    /// `a` where the mask is true, `b` elsewhere.
    #[inline(always)]
    pub fn select(mask: R::Mask, a: Self, b: Self) -> Self {
        Self::new(R::select(mask, a.x, b.x), R::select(mask, a.y, b.y), R::select(mask, a.z, b.z))
    }
}

impl<R: Real> Add for Vector3<R> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<R: Real> Sub for Vector3<R> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<R: Real> Neg for Vector3<R> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<R: Real> Mul<R> for Vector3<R> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl<R: Real> Div<R> for Vector3<R> {
    type Output = Self;

    #[inline(always)]
    fn div(self, divisor: R) -> Self {
        Self::new(self.x / divisor, self.y / divisor, self.z / divisor)
    }
}

impl From<DVec3> for Vector3<f64> {
    #[inline(always)]
    fn from(v: DVec3) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl From<Vector3<f64>> for DVec3 {
    #[inline(always)]
    fn from(v: Vector3<f64>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{hash, unit};

    #[test]
    fn vectors_without_direction_have_no_unit_vector() {
        for v in [DVec3::ZERO, DVec3::splat(1e-200), DVec3::splat(1e200), DVec3::X * f64::INFINITY, DVec3::NAN] {
            assert_eq!(Vector3::from(v).try_normalize().1, v.try_normalize().is_some(), "{v}");
        }
    }

    #[test]
    fn operations_have_the_bits_of_dvec3() {
        for i in 0..1000 {
            let coordinate = |at: u64| (unit(hash(&[5, i, at])) - 0.5) * f64::from(1u32 << (i % 30));
            let [a, b] = [0, 3].map(|at| DVec3::new(coordinate(at), coordinate(at + 1), coordinate(at + 2)));
            let [v, w] = [a, b].map(Vector3::from);
            assert_eq!(v.dot(w).to_bits(), a.dot(b).to_bits());
            assert_eq!(v.length().to_bits(), a.length().to_bits());
            assert_eq!(DVec3::from(v.cross(w)), a.cross(b));
            assert_eq!(DVec3::from(v / w.z + w * 0.3 - -v.abs()), a / b.z + b * 0.3 - -a.abs());
            assert_eq!(DVec3::from(v.scaled_by(w)), a * b);
            assert_eq!(v.try_normalize(), (a.normalize().into(), true));
            assert_eq!(DVec3::from(Vector3::select(v.x.lt(w.x), v, w)), if a.x < b.x { a } else { b });
        }
    }
}
