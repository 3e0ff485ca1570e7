//! One number of eight rays.

use rt_math::DVec3;

use super::ray::SLACK;
use super::simd::Simd;

/// Rays in a packet.
pub(super) const PACKET: usize = 8;

/// One number of eight rays.
#[derive(Clone, Copy)]
pub(super) struct F64x8<S: Simd>(S::F64x8);

/// Wraps operations of a level.
macro_rules! lane_wise {
    ($($name:ident($($other:ident),*) = $operation:ident;)*) => {$(
        #[inline(always)]
        pub(super) fn $name(self, simd: S $(, $other: Self)*) -> Self {
            Self(simd.$operation(self.0 $(, $other.0)*))
        }
    )*};
}

impl<S: Simd> F64x8<S> {
    lane_wise! {
        add(other) = add_f64x8;
        sub(other) = sub_f64x8;
        mul(other) = mul_f64x8;
        div(other) = div_f64x8;
        min(other) = min_f64x8;
        max(other) = max_f64x8;
        sqrt() = sqrt_f64x8;
        abs() = abs_f64x8;
        select_by_sign(positive, negative) = select_by_sign_f64x8;
    }

    #[inline(always)]
    pub(super) fn new(simd: S, of: [f64; PACKET]) -> Self {
        Self(simd.f64x8(of))
    }

    #[inline(always)]
    pub(super) fn from_f32(simd: S, of: [f32; PACKET]) -> Self {
        Self(simd.to_f64x8(of))
    }

    #[inline(always)]
    pub(super) fn splat(simd: S, x: f64) -> Self {
        Self(simd.f64x8([x; PACKET]))
    }

    #[inline(always)]
    pub(super) fn splat3(simd: S, p: DVec3) -> [Self; 3] {
        [Self::splat(simd, p.x), Self::splat(simd, p.y), Self::splat(simd, p.z)]
    }

    /// The first four and the last four numbers.
    #[inline(always)]
    pub(super) fn halves(self, simd: S) -> [S::F64x4; 2] {
        simd.halves(self.0)
    }

    /// `self` where the mask has a bit, otherwise `other`.
    #[inline(always)]
    pub(super) fn select(self, simd: S, mask: u32, other: Self) -> Self {
        Self(simd.select_f64x8(mask, self.0, other.0))
    }

    /// Non-negative numbers with the signs of others.
    #[inline(always)]
    pub(super) fn copysign(self, simd: S, sign: Self) -> Self {
        sign.select_by_sign(simd, self, Self::splat(simd, 0.0).sub(simd, self))
    }

    /// A bit for each lane with `self ≤ other`; never where one is NaN.
    #[inline(always)]
    pub(super) fn le(self, simd: S, other: Self) -> u32 {
        simd.le_f64x8(self.0, other.0)
    }

    /// A bit for each lane with `self < other`; never where one is NaN.
    #[inline(always)]
    pub(super) fn lt(self, simd: S, other: Self) -> u32 {
        simd.lt_f64x8(self.0, other.0)
    }

    /// Sign bits.
    #[inline(always)]
    pub(super) fn signs(self, simd: S) -> u32 {
        simd.signs_f64x8(self.0)
    }

    #[inline(always)]
    pub(super) fn to_array(self, simd: S) -> [f64; PACKET] {
        let [low, high] = self.halves(simd);
        let [a, b, c, d] = simd.to_f64_array(low);
        let [e, f, g, h] = simd.to_f64_array(high);
        [a, b, c, d, e, f, g, h]
    }

    /// The first number.
    #[inline(always)]
    pub(super) fn first(self, simd: S) -> f64 {
        let [low, _] = self.halves(simd);
        let [first, ..] = simd.to_f64_array(low);
        first
    }

    /// Minimum of the lanes; any of them if one is NaN.
    #[inline(always)]
    pub(super) fn reduce_min(self, simd: S) -> f64 {
        let [low, high] = self.halves(simd);
        let [a, b, c, d] = simd.to_f64_array(simd.min_f64(low, high));
        a.min(b).min(c.min(d))
    }

    /// Maximum of the lanes; any of them if one is NaN.
    #[inline(always)]
    pub(super) fn reduce_max(self, simd: S) -> f64 {
        let [low, high] = self.halves(simd);
        let [a, b, c, d] = simd.to_f64_array(simd.max_f64(low, high));
        a.max(b).max(c.max(d))
    }

    #[inline(always)]
    pub(super) fn reduce_sum(self, simd: S) -> f64 {
        let [low, high] = self.halves(simd);
        let [a, b, c, d] = simd.to_f64_array(simd.add_f64(low, high));
        a + b + (c + d)
    }

    #[inline(always)]
    pub(super) fn to_f32(self, simd: S) -> S::F32x8 {
        simd.narrow_f64x8(self.0)
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

/// Adds in the order of `DVec3::dot`.
#[inline(always)]
pub(super) fn dot<S: Simd>(simd: S, a: [F64x8<S>; 3], b: [F64x8<S>; 3]) -> F64x8<S> {
    a[0].mul(simd, b[0]).add(simd, a[1].mul(simd, b[1])).add(simd, a[2].mul(simd, b[2]))
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
