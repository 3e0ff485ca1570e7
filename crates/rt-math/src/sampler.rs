//! Interface of sample generators.

/// A stream of sample coordinates for one sample of one pixel.
///
/// Every number is a pure function of (seed, pixel, sample, dimension): each call uses the next dimension. Implemented
/// by rt-camera, used by integrators.
///
/// Integrators that follow many paths draw for all of them at once, which lets a sampler compute in SIMD lanes:
///
/// ```
/// use rt_math::Sampler;
///
/// #[derive(Clone)]
/// struct Counter(f64);
///
/// impl Sampler for Counter {
///     fn next_1d(&mut self) -> f64 {
///         self.0 += 0.125;
///         self.0
///     }
///
///     fn next_2d(&mut self) -> [f64; 2] {
///         [self.next_1d(), self.next_1d()]
///     }
/// }
///
/// let mut samplers = vec![Counter(0.0), Counter(0.25), Counter(0.5)];
/// let mut on_light = [[0.0; 2]; 2];
/// Sampler::next_2d_batch(&mut samplers, &[2, 0], &mut on_light);
/// assert_eq!(on_light, [[0.625, 0.75], [0.125, 0.25]]);
/// ```
pub trait Sampler {
    /// The next coordinate, in `[0, 1)`.
    fn next_1d(&mut self) -> f64;

    /// The next two coordinates, in `[0, 1)²`, stratified together where the pattern can.
    fn next_2d(&mut self) -> [f64; 2];

    /// Batch version of [`next_1d`](Self::next_1d): draws `values[i]` from `samplers[which[i]]`, in order of `i`.
    ///
    /// Values and states are those of draws one by one, bit for bit. The samplers may be at different dimensions. A sampler
    /// that occurs twice in `which` draws twice. Only as many values are drawn as both `which` and `values` have. An index
    /// beyond the samplers draws nothing, and its value is kept.
    fn next_1d_batch(samplers: &mut [Self], which: &[u32], values: &mut [f64])
    where
        Self: Sized,
    {
        for (&index, value) in which.iter().zip(values) {
            if let Some(sampler) = samplers.get_mut(index as usize) {
                *value = sampler.next_1d();
            }
        }
    }

    /// Batch version of [`next_2d`](Self::next_2d): draws `pairs[i]` from `samplers[which[i]]`, in order of `i`, by the rules of
    /// [`next_1d_batch`](Self::next_1d_batch).
    fn next_2d_batch(samplers: &mut [Self], which: &[u32], pairs: &mut [[f64; 2]])
    where
        Self: Sized,
    {
        for (&index, pair) in which.iter().zip(pairs) {
            if let Some(sampler) = samplers.get_mut(index as usize) {
                *pair = sampler.next_2d();
            }
        }
    }
}

/// Samplers of one type, for functions that are compiled once for all types.
pub trait Samplers {
    /// The sampler of this index; `None` beyond the last one.
    fn get(&mut self, index: usize) -> Option<&mut dyn Sampler>;

    /// Calls [`Sampler::next_1d_batch`].
    fn next_1d_batch(&mut self, which: &[u32], values: &mut [f64]);

    /// Calls [`Sampler::next_2d_batch`].
    fn next_2d_batch(&mut self, which: &[u32], pairs: &mut [[f64; 2]]);
}

impl<S: Sampler> Samplers for &mut [S] {
    fn get(&mut self, index: usize) -> Option<&mut dyn Sampler> {
        self.get_mut(index).map(|sampler| sampler as _)
    }

    fn next_1d_batch(&mut self, which: &[u32], values: &mut [f64]) {
        S::next_1d_batch(self, which, values);
    }

    fn next_2d_batch(&mut self, which: &[u32], pairs: &mut [[f64; 2]]) {
        S::next_2d_batch(self, which, pairs);
    }
}
