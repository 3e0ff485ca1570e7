//! One number of eight rays.

use rt_math::DVec3;

use super::ray::SLACK;
use super::simd::Simd;

/// Rays in a packet.
pub(super) const PACKET: usize = 8;

/// One number of eight rays.
#[derive(Clone, Copy)]
pub(super) struct F64x8<S: Simd> {
    pub(super) low: S::F64x4,
    pub(super) high: S::F64x4,
}

/// Wraps operations on four numbers as operations on eight.
macro_rules! lane_wise {
    ($($name:ident($($other:ident),*) = $half:ident;)*) => {$(
        #[inline(always)]
        pub(super) fn $name(self, simd: S $(, $other: Self)*) -> Self {
            Self { low: simd.$half(self.low $(, $other.low)*), high: simd.$half(self.high $(, $other.high)*) }
        }
    )*};
}

impl<S: Simd> F64x8<S> {
    lane_wise! {
        add(other) = add_f64;
        sub(other) = sub_f64;
        mul(other) = mul_f64;
        div(other) = div_f64;
        min(other) = min_f64;
        max(other) = max_f64;
        sqrt() = sqrt_f64;
        abs() = abs_f64;
        select_by_sign(positive, negative) = select_by_sign;
    }

    #[inline(always)]
    pub(super) fn new(simd: S, [a, b, c, d, e, f, g, h]: [f64; PACKET]) -> Self {
        Self { low: simd.f64x4([a, b, c, d]), high: simd.f64x4([e, f, g, h]) }
    }

    #[inline(always)]
    pub(super) fn splat(simd: S, x: f64) -> Self {
        Self { low: simd.f64x4([x; 4]), high: simd.f64x4([x; 4]) }
    }

    #[inline(always)]
    pub(super) fn splat3(simd: S, p: DVec3) -> [Self; 3] {
        [Self::splat(simd, p.x), Self::splat(simd, p.y), Self::splat(simd, p.z)]
    }

    /// Non-negative numbers with the signs of others.
    #[inline(always)]
    pub(super) fn copysign(self, simd: S, sign: Self) -> Self {
        sign.select_by_sign(simd, self, Self::splat(simd, 0.0).sub(simd, self))
    }

    /// A bit for each lane with `self ≤ other`; never where one is NaN.
    #[inline(always)]
    pub(super) fn le(self, simd: S, other: Self) -> u32 {
        simd.le_f64(self.low, other.low) | simd.le_f64(self.high, other.high) << 4
    }

    /// A bit for each lane with `self < other`; never where one is NaN.
    #[inline(always)]
    pub(super) fn lt(self, simd: S, other: Self) -> u32 {
        simd.lt_f64(self.low, other.low) | simd.lt_f64(self.high, other.high) << 4
    }

    /// Sign bits.
    #[inline(always)]
    pub(super) fn signs(self, simd: S) -> u32 {
        simd.signs(self.low) | simd.signs(self.high) << 4
    }

    #[inline(always)]
    pub(super) fn to_array(self, simd: S) -> [f64; PACKET] {
        let [a, b, c, d] = simd.to_f64_array(self.low);
        let [e, f, g, h] = simd.to_f64_array(self.high);
        [a, b, c, d, e, f, g, h]
    }

    /// Minimum of the lanes; any of them if one is NaN.
    #[inline(always)]
    pub(super) fn reduce_min(self, simd: S) -> f64 {
        let [a, b, c, d] = simd.to_f64_array(simd.min_f64(self.low, self.high));
        a.min(b).min(c.min(d))
    }

    /// Maximum of the lanes; any of them if one is NaN.
    #[inline(always)]
    pub(super) fn reduce_max(self, simd: S) -> f64 {
        let [a, b, c, d] = simd.to_f64_array(simd.max_f64(self.low, self.high));
        a.max(b).max(c.max(d))
    }

    #[inline(always)]
    pub(super) fn reduce_sum(self, simd: S) -> f64 {
        let [a, b, c, d] = simd.to_f64_array(simd.add_f64(self.low, self.high));
        a + b + (c + d)
    }

    #[inline(always)]
    pub(super) fn to_f32(self, simd: S) -> S::F32x8 {
        simd.concat_to_f32(self.low, self.high)
    }

    /// SIMD version of [`round_down`](super::ray::round_down).
    #[inline(always)]
    pub(super) fn round_down(self, simd: S) -> S::F32x8 {
        let below = self.mul(simd, Self::splat(simd, 1.0 - SLACK)).to_f32(simd);
        simd.max(simd.sub(below, simd.splat(f32::MIN_POSITIVE)), simd.splat(0.0))
    }

    /// SIMD version of [`round_up`](super::ray::round_up).
    #[inline(always)]
    pub(super) fn round_up(self, simd: S) -> S::F32x8 {
        let above = self.mul(simd, Self::splat(simd, 1.0 + SLACK)).to_f32(simd);
        simd.max(above, simd.splat(f32::MIN_POSITIVE))
    }
}

/// Differences of two vectors by lane.
#[inline(always)]
pub(super) fn sub3<S: Simd>(simd: S, a: [F64x8<S>; 3], b: [F64x8<S>; 3]) -> [F64x8<S>; 3] {
    [a[0].sub(simd, b[0]), a[1].sub(simd, b[1]), a[2].sub(simd, b[2])]
}

/// Maximum absolute coordinate by ray.
#[inline(always)]
pub(super) fn max_abs<S: Simd>(simd: S, [x, y, z]: [F64x8<S>; 3]) -> F64x8<S> {
    x.abs(simd).max(simd, y.abs(simd)).max(simd, z.abs(simd))
}

/// Positions relative to a centre.
#[inline(always)]
pub(super) fn relative<S: Simd>(simd: S, positions: [F64x8<S>; 3], centre: DVec3) -> [F64x8<S>; 3] {
    sub3(simd, positions, F64x8::splat3(simd, centre))
}
