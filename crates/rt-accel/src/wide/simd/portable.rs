//! What any processor can do: twice four numbers, by glam, which knows SSE2 and NEON.

use core::mem::MaybeUninit;

use glam::Vec4;

use super::{Simd, WithSimd};

/// Two halves of four numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::wide) struct Portable;

impl Portable {
    /// Runs the kernel, compiled once and not wherever it is asked for.
    #[inline(never)]
    pub(super) fn dispatch<A, B, K: WithSimd<A, B>>(self, kernel: K, a: A, b: B) {
        kernel.run(self, a, b)
    }
}

#[inline(always)]
fn both([a, b]: [Vec4; 2], [c, d]: [Vec4; 2], f: impl Fn(Vec4, Vec4) -> Vec4) -> [Vec4; 2] {
    [f(a, c), f(b, d)]
}

#[inline(always)]
fn each(a: [f64; 4], b: [f64; 4], f: impl Fn(f64, f64) -> f64) -> [f64; 4] {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])]
}

impl Simd for Portable {
    type F32x8 = [Vec4; 2];

    const FUSED: bool = false;
    const INTERLEAVE: bool = false;

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F32x8 {
        [Vec4::splat(x); 2]
    }

    #[inline(always)]
    fn load(self, from: &[f32; 8]) -> Self::F32x8 {
        let [a, b, c, d, e, f, g, h] = *from;
        [Vec4::new(a, b, c, d), Vec4::new(e, f, g, h)]
    }

    #[inline(always)]
    fn to_array(self, [low, high]: Self::F32x8) -> [f32; 8] {
        let ([a, b, c, d], [e, f, g, h]) = (low.to_array(), high.to_array());
        [a, b, c, d, e, f, g, h]
    }

    #[inline(always)]
    fn insert(self, a: Self::F32x8, lane: usize, by: f32) -> Self::F32x8 {
        let mut numbers = self.to_array(a);
        numbers[lane & 7] = by;
        self.load(&numbers)
    }

    #[inline(always)]
    fn add(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8 {
        both(a, b, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8 {
        both(a, b, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8 {
        both(a, b, |a, b| a * b)
    }

    #[inline(always)]
    fn div(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8 {
        both(a, b, |a, b| a / b)
    }

    #[inline(always)]
    fn sqrt(self, a: Self::F32x8) -> Self::F32x8 {
        a.map(|half| Vec4::from_array(half.to_array().map(f32::sqrt)))
    }

    #[inline(always)]
    fn abs(self, a: Self::F32x8) -> Self::F32x8 {
        a.map(Vec4::abs)
    }

    #[inline(always)]
    fn min(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8 {
        both(a, b, Vec4::min)
    }

    #[inline(always)]
    fn max(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8 {
        both(a, b, Vec4::max)
    }

    #[inline(always)]
    fn mul_add(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8 {
        self.add(self.mul(a, b), c)
    }

    #[inline(always)]
    fn mul_sub(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8 {
        self.sub(self.mul(a, b), c)
    }

    #[inline(always)]
    fn neg_mul_add(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8 {
        self.sub(c, self.mul(a, b))
    }

    #[inline(always)]
    fn le(self, a: Self::F32x8, b: Self::F32x8) -> u32 {
        a[0].cmple(b[0]).bitmask() | a[1].cmple(b[1]).bitmask() << 4
    }

    #[inline(always)]
    fn lt(self, a: Self::F32x8, b: Self::F32x8) -> u32 {
        a[0].cmplt(b[0]).bitmask() | a[1].cmplt(b[1]).bitmask() << 4
    }

    #[inline(always)]
    fn prefetch<T>(self, _line: *const T) {}

    #[inline(always)]
    fn eq_bits(self, a: Self::F32x8, b: Self::F32x8) -> u32 {
        let (a, b) = (self.to_array(a), self.to_array(b));
        let mut same = 0;
        for lane in 0..8 {
            same |= u32::from(a[lane].to_bits() == b[lane].to_bits()) << lane;
        }
        same
    }

    #[inline(always)]
    fn select(self, mask: u32, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8 {
        let (a, mut chosen) = (self.to_array(a), self.to_array(b));
        for lane in 0..8 {
            chosen[lane] = if mask >> lane & 1 != 0 { a[lane] } else { chosen[lane] };
        }
        self.load(&chosen)
    }

    #[inline(always)]
    fn or_inf(self, [a, b]: Self::F32x8, [c, d]: Self::F32x8) -> Self::F32x8 {
        [Vec4::select(a.cmple(c), a, Vec4::INFINITY), Vec4::select(b.cmple(d), b, Vec4::INFINITY)]
    }

    #[inline(always)]
    fn least(self, [a, b]: Self::F32x8) -> f32 {
        a.min(b).min_element()
    }

    #[inline(always)]
    fn compress_sorted(
        self,
        enter: Self::F32x8,
        leave: Self::F32x8,
        words: &[u32; 8],
        enters: &mut [MaybeUninit<f32>; 8],
        passed: &mut [MaybeUninit<u32>; 8],
    ) -> usize {
        let mut mask = self.le(enter, leave);
        let enter = self.to_array(enter);
        let mut sorted = [(0.0, 0); 8];
        let mut count = 0;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & 7;
            mask &= mask - 1;
            let mut place = count & 7;
            while place > 0 && sorted[place - 1].0 < enter[lane] {
                sorted[place] = sorted[place - 1];
                place -= 1;
            }
            sorted[place] = (enter[lane], words[lane]);
            count += 1;
        }
        for (place, (enter, word)) in sorted.into_iter().enumerate() {
            enters[place].write(enter);
            passed[place].write(word);
        }
        count
    }

    type F64x4 = [f64; 4];

    #[inline(always)]
    fn doubles(self, of: [f64; 4]) -> [f64; 4] {
        of
    }

    #[inline(always)]
    fn widened(self, of: [f32; 4]) -> [f64; 4] {
        of.map(f64::from)
    }

    #[inline(always)]
    fn round_to_f32(self, [a, b, c, d]: [f64; 4]) -> [f64; 4] {
        [f64::from(a as f32), f64::from(b as f32), f64::from(c as f32), f64::from(d as f32)]
    }

    #[inline(always)]
    fn concat_to_f32(self, [a, b, c, d]: [f64; 4], [e, f, g, h]: [f64; 4]) -> Self::F32x8 {
        [Vec4::new(a as f32, b as f32, c as f32, d as f32), Vec4::new(e as f32, f as f32, g as f32, h as f32)]
    }

    #[inline(always)]
    fn to_f32(self, a: [f64; 4]) -> [f32; 4] {
        a.map(|a| a as f32)
    }

    #[inline(always)]
    fn to_doubles(self, a: [f64; 4]) -> [f64; 4] {
        a
    }

    #[inline(always)]
    fn add_doubles(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        each(a, b, |a, b| a + b)
    }

    #[inline(always)]
    fn sub_doubles(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        each(a, b, |a, b| a - b)
    }

    #[inline(always)]
    fn mul_doubles(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        each(a, b, |a, b| a * b)
    }

    #[inline(always)]
    fn div_doubles(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        each(a, b, |a, b| a / b)
    }

    #[inline(always)]
    fn sqrt_doubles(self, a: [f64; 4]) -> [f64; 4] {
        a.map(f64::sqrt)
    }

    #[inline(always)]
    fn abs_doubles(self, a: [f64; 4]) -> [f64; 4] {
        a.map(f64::abs)
    }

    #[inline(always)]
    fn min_doubles(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        each(a, b, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max_doubles(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        each(a, b, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn select_by_sign(self, by: [f64; 4], positive: [f64; 4], negative: [f64; 4]) -> [f64; 4] {
        core::array::from_fn(|i| if by[i].is_sign_negative() { negative[i] } else { positive[i] })
    }

    #[inline(always)]
    fn signs(self, a: [f64; 4]) -> u32 {
        (0..4).map(|i| u32::from(a[i].is_sign_negative()) << i).sum()
    }

    #[inline(always)]
    fn le_doubles(self, a: [f64; 4], b: [f64; 4]) -> u32 {
        (0..4).map(|i| u32::from(a[i] <= b[i]) << i).sum()
    }

    #[inline(always)]
    fn yzx(self, [a, b, c, d]: [f64; 4]) -> [f64; 4] {
        [b, c, a, d]
    }

    #[inline(always)]
    fn zxy(self, [a, b, c, d]: [f64; 4]) -> [f64; 4] {
        [c, a, b, d]
    }

    #[inline(always)]
    fn greatest_axis(self, [x, y, z, _]: [f64; 4]) -> usize {
        let axis = if y > z { 1 } else { 2 };
        if (x > y) & (x > z) { 0 } else { axis }
    }

    #[inline(always)]
    fn rotate_axis_last(self, [x, y, z, spare]: [f64; 4], axis: usize) -> [f64; 4] {
        match axis {
            0 => [y, z, x, spare],
            1 => [z, x, y, spare],
            _ => [x, y, z, spare],
        }
    }
}
