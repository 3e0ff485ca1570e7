//! Interface of sample generators.

/// A stream of sample coordinates for one sample of one pixel.
///
/// Every number is a pure function of (seed, pixel, sample, dimension): each call uses the next dimension. Implemented
/// by rt-camera, used by integrators.
pub trait Sampler {
    /// The next coordinate, in `[0, 1)`.
    fn next_1d(&mut self) -> f64;

    /// The next two coordinates, in `[0, 1)²`, stratified together where the pattern can.
    fn next_2d(&mut self) -> [f64; 2];
}
