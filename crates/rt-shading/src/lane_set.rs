//! Lanes with two types of numbers: `f32` for shading, and `f64` for positions.
//!
//! ```text
//!   SimdLanes     eight in registers, AVX2 or AVX-512
//!   OneLane       one: any processor
//!   Float64Lane   one, with `f64` for shading as well: the reference
//! ```

use crate::{
    lanes::{LANES, LaneArray, LaneLevel, LaneMask, LaneMask32, Lanes, Lanes32, Simd, dispatch},
    light::{LightSet, SampledLight},
};
use core::marker::PhantomData;
use fearless_simd::{ExtractToken, SimdBase, SimdFrom, SimdMask, u32x8};
use rt_geometry::StreamArray;
use rt_math::{DVec3, F32, Float64, Mask, Real, Rgb, Vector3, transcendental::Pow};

/// Lanes that shade hits.
///
/// Masks of bits have bit `i` for lane `i`. Arrays hold the numbers of eight lanes, whatever the number of lanes.
pub(crate) trait LaneSet: Copy {
    /// Number of lanes.
    const N: usize;

    /// Numbers for shading: directions, reflectances and radiance.
    type F: Pow;

    /// Numbers for positions.
    type D: Float64;

    /// Element of [`F`](Self::F) in memory.
    type Element: Element;

    /// Calls a function with the instructions of the lanes, for functions that are not inlined.
    fn vectorize<T>(self, f: impl FnOnce() -> T) -> T;

    /// The same number for shading in all lanes.
    fn splat(self, x: f64) -> Self::F;

    /// The same number for positions in all lanes.
    fn splat_f64(self, x: f64) -> Self::D;

    fn load(self, from: &[Self::Element; LANES]) -> Self::F;

    fn load_f64(self, from: &LaneArray) -> Self::D;

    fn store(self, x: Self::F, to: &mut [Self::Element; LANES]);

    fn store_f64(self, x: Self::D, to: &mut LaneArray);

    fn widen(self, x: Self::F) -> Self::D;

    /// Rounds to the numbers for shading.
    fn narrow(self, x: Self::D) -> Self::F;

    fn bits(self, mask: <Self::F as Real>::Mask) -> u8;

    fn bits_f64(self, mask: <Self::D as Real>::Mask) -> u8;

    fn mask(self, bits: u8) -> <Self::F as Real>::Mask;

    fn mask_f64(self, bits: u8) -> <Self::D as Real>::Mask;

    /// Chooses an area or environment light for each lane, as [`LightSet::sample_li`]: indices, and probabilities, which are 0 where
    /// there is none. Normals have the length 1.
    fn choose_lights(
        self,
        lights: &LightSet,
        point: Vector3<Self::D>,
        normal: Vector3<Self::D>,
        choice: Self::D,
    ) -> ([u32; LANES], Self::D);

    /// Stores the lanes of a mask, one after the other; what is behind them is overwritten.
    fn compress(self, x: Self::F, mask: u8, to: &mut [Self::Element; LANES]);

    /// Version of [`compress`](Self::compress) for positions.
    fn compress_f64(self, x: Self::D, mask: u8, to: &mut LaneArray);

    /// Version of [`compress`](Self::compress) for integers in memory.
    fn compress_u32(self, from: &[u32; LANES], mask: u8, to: &mut [u32; LANES]);

    /// Largest integers that are not greater.
    fn floor_f64(self, x: Self::D) -> Self::D;

    /// Lanes in which an index equals `index`.
    fn equal(self, indices: &[u32; LANES], index: u32) -> u8;

    /// Loads vectors for positions.
    #[inline(always)]
    fn load_coordinates(self, [x, y, z]: &[LaneArray; 3]) -> Vector3<Self::D> {
        Vector3::new(self.load_f64(x), self.load_f64(y), self.load_f64(z))
    }

    #[inline(always)]
    fn store_point(self, p: Vector3<Self::D>) -> [[f64; LANES]; 3] {
        let mut numbers = [[0.0; LANES]; 3];
        let [x, y, z] = &mut numbers;
        self.store_f64(p.x, x);
        self.store_f64(p.y, y);
        self.store_f64(p.z, z);
        numbers
    }

    #[inline(always)]
    fn store_vector(self, v: Vector3<Self::F>) -> [[Self::Element; LANES]; 3] {
        let mut numbers = [[Self::Element::default(); LANES]; 3];
        let [x, y, z] = &mut numbers;
        self.store(v.x, x);
        self.store(v.y, y);
        self.store(v.z, z);
        numbers
    }

    /// The same vector for positions in all lanes.
    #[inline(always)]
    fn splat_point(self, p: DVec3) -> Vector3<Self::D> {
        Vector3::splat(self.splat_f64(0.0), p)
    }

    /// The same colour in all lanes.
    #[inline(always)]
    fn splat_rgb(self, Rgb { r, g, b }: Rgb) -> Vector3<Self::F> {
        Vector3::new(self.splat(r), self.splat(g), self.splat(b))
    }

    #[inline(always)]
    fn narrow_vector(self, v: Vector3<Self::D>) -> Vector3<Self::F> {
        Vector3::new(self.narrow(v.x), self.narrow(v.y), self.narrow(v.z))
    }

    #[inline(always)]
    fn widen_vector(self, v: Vector3<Self::F>) -> Vector3<Self::D> {
        Vector3::new(self.widen(v.x), self.widen(v.y), self.widen(v.z))
    }

    /// Vectors from the index `at` of three arrays on.
    #[inline(always)]
    fn load_vector(self, [x, y, z]: &[StreamArray<Self::Element>; 3], at: usize) -> Vector3<Self::F> {
        Vector3::new(self.load(x.vector(at)), self.load(y.vector(at)), self.load(z.vector(at)))
    }

    /// Points from the index `at` of three arrays on.
    #[inline(always)]
    fn load_point(self, [x, y, z]: &[StreamArray<f64>; 3], at: usize) -> Vector3<Self::D> {
        Vector3::new(self.load_f64(x.vector(at)), self.load_f64(y.vector(at)), self.load_f64(z.vector(at)))
    }

    /// Version of [`compress`](Self::compress) for vectors, to the index `at` of three arrays.
    #[inline(always)]
    fn compress_vector(
        self,
        v: Vector3<Self::F>,
        mask: u8,
        [x, y, z]: &mut [StreamArray<Self::Element>; 3],
        at: usize,
    ) {
        self.compress(v.x, mask, x.vector_mut(at));
        self.compress(v.y, mask, y.vector_mut(at));
        self.compress(v.z, mask, z.vector_mut(at));
    }

    /// Version of [`compress`](Self::compress) for points, to the index `at` of three arrays.
    #[inline(always)]
    fn compress_point(self, p: Vector3<Self::D>, mask: u8, [x, y, z]: &mut [StreamArray<f64>; 3], at: usize) {
        self.compress_f64(p.x, mask, x.vector_mut(at));
        self.compress_f64(p.y, mask, y.vector_mut(at));
        self.compress_f64(p.z, mask, z.vector_mut(at));
    }
}

/// Number in an array.
pub(crate) trait Element: Copy + Default + Into<f64> {
    /// The nearest number of the type.
    fn rounded(x: f64) -> Self;

    /// Runs a stage with the instructions of a level, or one hit at a time. All levels have the same results.
    fn run(level: Option<LaneLevel>, stage: impl LaneStage<Self>);
}

/// Stage of an integrator that shades hits in lanes.
pub(crate) trait LaneStage<E: Element> {
    /// Runs the stage. The function must be inlined.
    fn run<L: LaneSet<Element = E>>(self, lanes: L);
}

impl Element for f32 {
    #[inline(always)]
    fn rounded(x: f64) -> Self {
        x as Self
    }

    #[inline(always)]
    fn run(level: Option<LaneLevel>, stage: impl LaneStage<Self>) {
        match level {
            Some(level) => dispatch!(level, simd => simd.vectorize(
                #[inline(always)]
                || stage.run(SimdLanes(simd)),
            )),
            None => stage.run(OneLane::new()),
        }
    }
}

impl Element for f64 {
    #[inline(always)]
    fn rounded(x: f64) -> Self {
        x
    }

    fn run(_: Option<LaneLevel>, stage: impl LaneStage<Self>) {
        stage.run(Float64Lane::new());
    }
}

#[inline(always)]
pub(crate) fn set_color<E: Element>([r, g, b]: &mut [[E; LANES]; 3], lane: usize, color: Rgb) {
    let lane = lane % LANES;
    (r[lane], g[lane], b[lane]) = (E::rounded(color.r), E::rounded(color.g), E::rounded(color.b));
}

/// One hit at a time. `R` computes light, and `E` holds it in memory: no conversion between them rounds.
#[derive(Clone, Copy)]
pub(crate) struct Single<R, E>(PhantomData<(R, E)>);

/// One hit at a time, with the results of [`SimdLanes`].
pub(crate) type OneLane = Single<F32, f32>;

/// One hit at a time, shaded in `f64`: the reference.
pub(crate) type Float64Lane = Single<f64, f64>;

impl<R, E> Single<R, E> {
    pub(crate) const fn new() -> Self {
        Self(PhantomData)
    }
}

impl<R: Pow + Default + Into<f64>, E: Element> LaneSet for Single<R, E> {
    const N: usize = 1;

    type F = R;
    type D = f64;
    type Element = E;

    #[inline(always)]
    fn vectorize<T>(self, f: impl FnOnce() -> T) -> T {
        f()
    }

    #[inline(always)]
    fn splat(self, x: f64) -> R {
        R::default().splat(x)
    }

    #[inline(always)]
    fn splat_f64(self, x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn load(self, from: &[E; LANES]) -> R {
        self.splat(from[0].into())
    }

    #[inline(always)]
    fn load_f64(self, from: &LaneArray) -> f64 {
        from[0]
    }

    #[inline(always)]
    fn store(self, x: R, to: &mut [E; LANES]) {
        to[0] = E::rounded(x.into());
    }

    #[inline(always)]
    fn store_f64(self, x: f64, to: &mut LaneArray) {
        to[0] = x;
    }

    #[inline(always)]
    fn widen(self, x: R) -> f64 {
        x.into()
    }

    #[inline(always)]
    fn narrow(self, x: f64) -> R {
        self.splat(x)
    }

    #[inline(always)]
    fn bits(self, mask: R::Mask) -> u8 {
        u8::from(mask.any())
    }

    #[inline(always)]
    fn bits_f64(self, mask: bool) -> u8 {
        u8::from(mask)
    }

    #[inline(always)]
    fn mask(self, bits: u8) -> R::Mask {
        let is_set = f64::from(bits & 1);
        self.splat(0.0).lt(self.splat(is_set))
    }

    #[inline(always)]
    fn mask_f64(self, bits: u8) -> bool {
        bits & 1 == 1
    }

    #[inline(always)]
    fn choose_lights(
        self,
        lights: &LightSet,
        point: Vector3<f64>,
        normal: Vector3<f64>,
        choice: f64,
    ) -> ([u32; LANES], f64) {
        match lights.choose(point.into(), Some(normal.into()), choice) {
            Some(SampledLight { index, probability }) => ([index; LANES], probability),
            None => ([0; LANES], 0.0),
        }
    }

    #[inline(always)]
    fn compress(self, x: R, mask: u8, to: &mut [E; LANES]) {
        if mask & 1 == 1 {
            self.store(x, to);
        }
    }

    #[inline(always)]
    fn compress_f64(self, x: f64, mask: u8, to: &mut LaneArray) {
        if mask & 1 == 1 {
            to[0] = x;
        }
    }

    #[inline(always)]
    fn compress_u32(self, from: &[u32; LANES], mask: u8, to: &mut [u32; LANES]) {
        if mask & 1 == 1 {
            to[0] = from[0];
        }
    }

    #[inline(always)]
    fn floor_f64(self, x: f64) -> f64 {
        x.floor()
    }

    #[inline(always)]
    fn equal(self, indices: &[u32; LANES], index: u32) -> u8 {
        u8::from(indices[0] == index)
    }
}

/// Eight hits in registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SimdLanes<S: Simd>(pub(crate) S);

impl<S: Simd> LaneSet for SimdLanes<S> {
    const N: usize = 8;

    type F = Lanes32<S>;
    type D = Lanes<S>;
    type Element = f32;

    #[inline(always)]
    fn vectorize<T>(self, f: impl FnOnce() -> T) -> T {
        self.0.vectorize(f)
    }

    #[inline(always)]
    fn splat(self, x: f64) -> Lanes32<S> {
        Lanes32::splat(self.0, x)
    }

    #[inline(always)]
    fn splat_f64(self, x: f64) -> Lanes<S> {
        Lanes::splat(self.0, x)
    }

    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> Lanes32<S> {
        Lanes32::load(self.0, from)
    }

    #[inline(always)]
    fn load_f64(self, from: &LaneArray) -> Lanes<S> {
        Lanes::load(self.0, from)
    }

    #[inline(always)]
    fn store(self, x: Lanes32<S>, to: &mut [f32; LANES]) {
        *to = x.store();
    }

    #[inline(always)]
    fn store_f64(self, x: Lanes<S>, to: &mut LaneArray) {
        *to = x.store();
    }

    #[inline(always)]
    fn widen(self, x: Lanes32<S>) -> Lanes<S> {
        let (low, high) = self.0.widen_f32x8(x.0);
        Lanes(self.0.combine_f64x4(low, high))
    }

    #[inline(always)]
    fn narrow(self, x: Lanes<S>) -> Lanes32<S> {
        let (low, high) = self.0.split_f64x8(x.0);
        Lanes32(self.0.narrow_f64x4(low, high))
    }

    #[inline(always)]
    fn bits(self, mask: LaneMask32<S>) -> u8 {
        mask.bits()
    }

    #[inline(always)]
    fn bits_f64(self, mask: LaneMask<S>) -> u8 {
        mask.bits()
    }

    #[inline(always)]
    fn mask(self, bits: u8) -> LaneMask32<S> {
        LaneMask32::from_bits(self.0, bits)
    }

    #[inline(always)]
    fn mask_f64(self, bits: u8) -> LaneMask<S> {
        LaneMask::from_bits(self.0, bits)
    }

    #[inline(always)]
    fn choose_lights(
        self,
        lights: &LightSet,
        point: Vector3<Lanes<S>>,
        normal: Vector3<Lanes<S>>,
        choice: Lanes<S>,
    ) -> ([u32; LANES], Lanes<S>) {
        lights.choose_lanes(self.0, point, normal, choice)
    }

    #[inline(always)]
    fn compress(self, x: Lanes32<S>, mask: u8, to: &mut [f32; LANES]) {
        *to = x.0.compress(self.mask(mask).0).into();
    }

    #[inline(always)]
    fn compress_f64(self, x: Lanes<S>, mask: u8, to: &mut LaneArray) {
        *to = x.0.compress(LaneMask::from_bits(self.0, mask).0).into();
    }

    #[inline(always)]
    fn compress_u32(self, from: &[u32; LANES], mask: u8, to: &mut [u32; LANES]) {
        *to = u32x8::simd_from(self.0, *from).compress(self.mask(mask).0).into();
    }

    #[inline(always)]
    fn floor_f64(self, x: Lanes<S>) -> Lanes<S> {
        x.floor()
    }

    #[inline(always)]
    fn equal(self, indices: &[u32; LANES], index: u32) -> u8 {
        u32x8::simd_from(self.0, *indices).simd_eq(u32x8::splat(self.0, index)).to_bitmask() as u8
    }
}

impl<S: Simd> Pow for Lanes32<S> {
    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        let lanes = SimdLanes(self.0.token());
        lanes.narrow(lanes.widen(self).powf(exponent))
    }
}
