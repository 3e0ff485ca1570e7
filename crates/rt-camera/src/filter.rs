//! Reconstruction filters, sampled by importance.

/// How a pixel weighs the light around its centre. Widths are in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// The pixel's own square.
    Box,
    /// A pyramid of total width 2.
    Tent,
    /// A bell of standard deviation `sigma`, cut at `3·sigma`.
    Gaussian {
        /// Standard deviation in pixels, positive.
        sigma: f64,
    },
    /// Mitchell and Netravali (1988) with B = C = 1/3 and total width 4; it has negative lobes.
    Mitchell,
}
