//! The contract of sample generators.

/// A stream of sample coordinates for one sample of one pixel.
///
/// Every number is a pure function of (seed, pixel, sample, dimension): each call takes the next dimension, and no
/// call looks at what was drawn elsewhere. rt-camera implements it; integrators consume it.
pub trait Sampler {
    /// The next coordinate, in `[0, 1)`.
    fn next_1d(&mut self) -> f64;

    /// The next two coordinates, in `[0, 1)²`, stratified together where the pattern can.
    fn next_2d(&mut self) -> [f64; 2];
}
