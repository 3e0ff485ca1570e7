//! Where in the pixel the samples fall.

/// A pattern of sample points over the pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SamplePattern {
    /// All in the middle of the pixel.
    Centre,
    /// A regular grid.
    Grid,
    /// Independent and uniform.
    Random,
    /// One uniform point in each cell of a grid (Cook 1986).
    Jittered,
    /// One point in the middle quarter of each cell: less noise, but **biased** at every sample count.
    HalfJittered,
    /// Jittered in the cells of a grid and in all rows and columns at once (Chiu, Shirley, Wang 1994).
    MultiJittered,
    /// The Sobol' sequence with Owen scrambling (Burley 2020).
    Sobol,
}
