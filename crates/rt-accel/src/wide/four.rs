//! Four numbers of double precision, one for each axis and one to spare: a shape that compilers turn into vectors.

use core::ops::{Add, Mul, Sub};

use rt_math::DVec3;

#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(super) struct Four(pub(super) [f64; 4]);

impl Four {
    #[inline(always)]
    pub(super) const fn new(v: DVec3, spare: f64) -> Self {
        Self([v.x, v.y, v.z, spare])
    }

    #[inline(always)]
    pub(super) const fn splat(x: f64) -> Self {
        Self([x; 4])
    }

    #[inline(always)]
    pub(super) fn abs(self) -> Self {
        let [x, y, z, w] = self.0;
        Self([x.abs(), y.abs(), z.abs(), w.abs()])
    }

    /// Each number, but no farther from 0 than `limit`.
    #[inline(always)]
    pub(super) fn limited(self, limit: f64) -> Self {
        let [x, y, z, w] = self.0;
        let within = |x: f64| {
            let x = if x < limit { x } else { limit };
            if x > -limit { x } else { -limit }
        };
        Self([within(x), within(y), within(z), within(w)])
    }

    #[inline(always)]
    pub(super) fn to_f32(self) -> [f32; 4] {
        let [x, y, z, w] = self.0;
        [x as f32, y as f32, z as f32, w as f32]
    }

    #[inline(always)]
    pub(super) fn from_f32([x, y, z, w]: [f32; 4]) -> Self {
        Self([f64::from(x), f64::from(y), f64::from(z), f64::from(w)])
    }
}

impl Add for Four {
    type Output = Self;

    #[inline(always)]
    fn add(self, Self([x, y, z, w]): Self) -> Self {
        let [a, b, c, d] = self.0;
        Self([a + x, b + y, c + z, d + w])
    }
}

impl Sub for Four {
    type Output = Self;

    #[inline(always)]
    fn sub(self, Self([x, y, z, w]): Self) -> Self {
        let [a, b, c, d] = self.0;
        Self([a - x, b - y, c - z, d - w])
    }
}

impl Mul for Four {
    type Output = Self;

    #[inline(always)]
    fn mul(self, Self([x, y, z, w]): Self) -> Self {
        let [a, b, c, d] = self.0;
        Self([a * x, b * y, c * z, d * w])
    }
}
