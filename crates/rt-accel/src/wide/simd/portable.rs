//! Twice four numbers on any processor, by glam, which uses SSE2 and NEON.

use core::mem::MaybeUninit;

use glam::Vec4;

use super::lanes::{Simd, WithSimd, f64x8_as_halves};

/// Proof of instructions that every processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::wide) struct Portable;

impl Portable {
    /// Runs the kernel, compiled once and not at every call.
    #[inline(never)]
    pub(super) fn dispatch<A, B, K: WithSimd<A, B>>(self, kernel: K, a: A, b: B) {
        kernel.run(self, a, b)
    }
}

type F32x8 = [Vec4; 2];
type F64x4 = [f64; 4];

#[inline(always)]
fn both([a, b]: F32x8, [c, d]: F32x8, f: impl Fn(Vec4, Vec4) -> Vec4) -> F32x8 {
    [f(a, c), f(b, d)]
}

#[inline(always)]
fn each(a: F64x4, b: F64x4, f: impl Fn(f64, f64) -> f64) -> F64x4 {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])]
}

/// Wraps expressions as inlined methods.
macro_rules! methods {
    ($(fn $name:ident($($arg:tt: $type:ty),*) -> $out:ty { $($body:tt)* })*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: $type),*) -> $out {
            $($body)*
        }
    )*};
}

impl Simd for Portable {
    type F32x8 = F32x8;
    type F64x4 = F64x4;

    f64x8_as_halves!();

    const FUSED: bool = false;
    const INTERLEAVE: bool = false;

    #[inline(never)]
    fn call_part<R>(self, part: impl FnOnce() -> R) -> R {
        part()
    }

    methods! {
        fn splat(x: f32) -> F32x8 { [Vec4::splat(x); 2] }
        fn load(from: &[f32; 8]) -> F32x8 {
            let [a, b, c, d, e, f, g, h] = *from;
            [Vec4::new(a, b, c, d), Vec4::new(e, f, g, h)]
        }
        fn to_array([low, high]: F32x8) -> [f32; 8] {
            let ([a, b, c, d], [e, f, g, h]) = (low.to_array(), high.to_array());
            [a, b, c, d, e, f, g, h]
        }
        fn add(a: F32x8, b: F32x8) -> F32x8 { both(a, b, |a, b| a + b) }
        fn sub(a: F32x8, b: F32x8) -> F32x8 { both(a, b, |a, b| a - b) }
        fn mul(a: F32x8, b: F32x8) -> F32x8 { both(a, b, |a, b| a * b) }
        fn div(a: F32x8, b: F32x8) -> F32x8 { both(a, b, |a, b| a / b) }
        fn sqrt(a: F32x8) -> F32x8 { a.map(|half| Vec4::from_array(half.to_array().map(f32::sqrt))) }
        fn abs(a: F32x8) -> F32x8 { a.map(Vec4::abs) }
        fn min(a: F32x8, b: F32x8) -> F32x8 { both(a, b, Vec4::min) }
        fn max(a: F32x8, b: F32x8) -> F32x8 { both(a, b, Vec4::max) }
        fn mul_add(a: F32x8, b: F32x8, c: F32x8) -> F32x8 { both(both(a, b, |a, b| a * b), c, |a, b| a + b) }
        fn mul_sub(a: F32x8, b: F32x8, c: F32x8) -> F32x8 { both(both(a, b, |a, b| a * b), c, |a, b| a - b) }
        fn neg_mul_add(a: F32x8, b: F32x8, c: F32x8) -> F32x8 { both(c, both(a, b, |a, b| a * b), |a, b| a - b) }
        fn le(a: F32x8, b: F32x8) -> u32 { a[0].cmple(b[0]).bitmask() | a[1].cmple(b[1]).bitmask() << 4 }
        fn lt(a: F32x8, b: F32x8) -> u32 { a[0].cmplt(b[0]).bitmask() | a[1].cmplt(b[1]).bitmask() << 4 }
        fn select_by_sign_f32([a, b]: F32x8, [c, d]: F32x8, [e, f]: F32x8) -> F32x8 {
            [Vec4::select(a.cmplt(Vec4::ZERO), e, c), Vec4::select(b.cmplt(Vec4::ZERO), f, d)]
        }
        fn or_inf([a, b]: F32x8, [c, d]: F32x8) -> F32x8 {
            [Vec4::select(a.cmple(c), a, Vec4::INFINITY), Vec4::select(b.cmple(d), b, Vec4::INFINITY)]
        }
        fn reduce_min([a, b]: F32x8) -> f32 { a.min(b).min_element() }
        fn f64x4(of: [f64; 4]) -> F64x4 { of }
        fn to_f64(of: [f32; 4]) -> F64x4 { of.map(f64::from) }
        fn round_to_f32([a, b, c, d]: F64x4) -> F64x4 {
            [f64::from(a as f32), f64::from(b as f32), f64::from(c as f32), f64::from(d as f32)]
        }
        fn concat_to_f32([a, b, c, d]: F64x4, [e, f, g, h]: F64x4) -> F32x8 {
            [Vec4::new(a as f32, b as f32, c as f32, d as f32), Vec4::new(e as f32, f as f32, g as f32, h as f32)]
        }
        fn to_f32(a: F64x4) -> [f32; 4] { a.map(|a| a as f32) }
        fn to_f64_array(a: F64x4) -> [f64; 4] { a }
        fn add_f64(a: F64x4, b: F64x4) -> F64x4 { each(a, b, |a, b| a + b) }
        fn sub_f64(a: F64x4, b: F64x4) -> F64x4 { each(a, b, |a, b| a - b) }
        fn mul_f64(a: F64x4, b: F64x4) -> F64x4 { each(a, b, |a, b| a * b) }
        fn div_f64(a: F64x4, b: F64x4) -> F64x4 { each(a, b, |a, b| a / b) }
        fn sqrt_f64(a: F64x4) -> F64x4 { a.map(f64::sqrt) }
        fn abs_f64(a: F64x4) -> F64x4 { a.map(f64::abs) }
        fn min_f64(a: F64x4, b: F64x4) -> F64x4 { each(a, b, |a, b| if a < b { a } else { b }) }
        fn max_f64(a: F64x4, b: F64x4) -> F64x4 { each(a, b, |a, b| if a > b { a } else { b }) }
        fn select_by_sign(by: F64x4, positive: F64x4, negative: F64x4) -> F64x4 {
            core::array::from_fn(|i| if by[i].is_sign_negative() { negative[i] } else { positive[i] })
        }
        fn select_f64(mask: u32, a: F64x4, b: F64x4) -> F64x4 {
            core::array::from_fn(|i| if mask >> i & 1 != 0 { a[i] } else { b[i] })
        }
        fn signs(a: F64x4) -> u32 { (0..4).map(|i| u32::from(a[i].is_sign_negative()) << i).sum() }
        fn lt_f64(a: F64x4, b: F64x4) -> u32 { (0..4).map(|i| u32::from(a[i] < b[i]) << i).sum() }
        fn le_f64(a: F64x4, b: F64x4) -> u32 { (0..4).map(|i| u32::from(a[i] <= b[i]) << i).sum() }
        fn yzx([a, b, c, d]: F64x4) -> F64x4 { [b, c, a, d] }
        fn zxy([a, b, c, d]: F64x4) -> F64x4 { [c, a, b, d] }
        fn max_axis([x, y, z, _]: F64x4) -> usize {
            let axis = if y > z { 1 } else { 2 };
            if (x > y) & (x > z) { 0 } else { axis }
        }
        fn rotate_axis_last([x, y, z, spare]: F64x4, axis: usize) -> F64x4 {
            match axis {
                0 => [y, z, x, spare],
                1 => [z, x, y, spare],
                _ => [x, y, z, spare],
            }
        }
    }

    #[inline(always)]
    fn insert(self, a: F32x8, lane: usize, by: f32) -> F32x8 {
        let mut numbers = self.to_array(a);
        numbers[lane & 7] = by;
        self.load(&numbers)
    }

    #[inline(always)]
    fn replace_bits(self, a: F32x8, mask: u32, bits: u32) -> F32x8 {
        let mut numbers = self.to_array(a);
        for number in &mut numbers {
            *number = f32::from_bits(number.to_bits() & !mask | bits);
        }
        self.load(&numbers)
    }

    #[inline(always)]
    fn eq_bits(self, a: F32x8, b: F32x8) -> u32 {
        let (a, b) = (self.to_array(a), self.to_array(b));
        (0..8).map(|lane| u32::from(a[lane].to_bits() == b[lane].to_bits()) << lane).sum()
    }

    #[inline(always)]
    fn select(self, mask: u32, a: F32x8, b: F32x8) -> F32x8 {
        let (a, mut selected) = (self.to_array(a), self.to_array(b));
        for lane in 0..8 {
            selected[lane] = if mask >> lane & 1 != 0 { a[lane] } else { selected[lane] };
        }
        self.load(&selected)
    }

    #[inline(always)]
    fn compress_sorted(
        self,
        enter: F32x8,
        leave: F32x8,
        words: &[u32; 8],
        enters: &mut [MaybeUninit<f32>; 8],
        hit: &mut [MaybeUninit<u32>; 8],
    ) -> usize {
        let mut mask = self.le(enter, leave);
        let enter = self.to_array(enter);
        let mut sorted = [(0.0, 0); 8];
        let mut count = 0;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & 7;
            mask &= mask - 1;
            let mut slot = count & 7;
            while slot > 0 && sorted[slot - 1].0 < enter[lane] {
                sorted[slot] = sorted[slot - 1];
                slot -= 1;
            }
            sorted[slot] = (enter[lane], words[lane]);
            count += 1;
        }
        for (slot, (enter, word)) in sorted.into_iter().enumerate() {
            enters[slot].write(enter);
            hit[slot].write(word);
        }
        count
    }

    #[inline(always)]
    fn prefetch<T>(self, _line: *const T) {}
}
