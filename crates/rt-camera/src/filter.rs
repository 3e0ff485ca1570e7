//! Reconstruction filters, sampled by importance.

use rt_math::{
    DVec2,
    transcendental::{exp, log, sincos},
};

use crate::mitchell;

/// A Gaussian is cut at this many standard deviations.
const GAUSSIAN_CUT: f64 = 3.0;

/// How a pixel weighs the light around its centre. Widths are in pixels.
///
/// Instead of splatting each sample over many pixels, samples are placed where the filter is large (Ernst, Stamminger,
/// Greiner 2006): every pixel then owns its samples, and their plain mean, weighted by the sign of the filter, is the
/// filtered radiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// The pixel's own square.
    Box,
    /// A pyramid of total width 2: the product of two triangles.
    Tent,
    /// A round bell of standard deviation `sigma`, cut at the distance `3·sigma`.
    Gaussian {
        /// Standard deviation in pixels, positive.
        sigma: f64,
    },
    /// Mitchell and Netravali (1988) with B = C = 1/3 and total width 4; it has negative lobes.
    Mitchell,
}

impl Filter {
    /// Distance from the pixel's centre, in pixels, beyond which the filter is 0: along an axis, or in all
    /// directions for the Gaussian.
    pub fn radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian { sigma } => GAUSSIAN_CUT * sigma,
            Self::Mitchell => mitchell::RADIUS,
        }
    }

    /// Value at an offset from the pixel's centre, in pixels; its integral over the plane is 1.
    pub fn value(self, offset: DVec2) -> f64 {
        match self {
            Self::Box => f64::from(offset.abs().max_element() <= 0.5),
            Self::Tent => (1.0 - offset.x.abs()).max(0.0) * (1.0 - offset.y.abs()).max(0.0),
            Self::Gaussian { sigma } => {
                let squared = offset.length_squared() / (sigma * sigma);
                if squared > GAUSSIAN_CUT * GAUSSIAN_CUT {
                    return 0.0;
                }
                exp(-0.5 * squared) / (core::f64::consts::TAU * sigma * sigma * gaussian_mass())
            }
            Self::Mitchell => mitchell::value(offset.x) * mitchell::value(offset.y),
        }
    }

    /// Takes a point of `[0, 1)²` to an offset from the pixel's centre, in pixels, with density proportional to the
    /// filter's absolute value, and the weight of a sample there: 1, or for filters with negative lobes
    /// ±(∫|f| / ∫f), so that the mean weight is 1.
    pub fn sample(self, u: [f64; 2]) -> (DVec2, f64) {
        match self {
            Self::Box => (DVec2::from_array(u) - 0.5, 1.0),
            Self::Tent => (DVec2::from_array(u.map(sample_triangle)), 1.0),
            Self::Gaussian { sigma } => {
                // The radius of a two-dimensional normal distribution has a closed inverse (Box and Muller 1958).
                let radius = sigma * (-2.0 * log(1.0 - u[0] * gaussian_mass())).sqrt();
                let (sin, cos) = sincos(core::f64::consts::TAU * u[1]);
                (DVec2::new(cos, sin) * radius, 1.0)
            }
            Self::Mitchell => {
                let ([x, x_weight], [y, y_weight]) = (mitchell::sample(u[0]), mitchell::sample(u[1]));
                (DVec2::new(x, y), x_weight * y_weight)
            }
        }
    }
}

/// Share of a two-dimensional normal distribution within [`GAUSSIAN_CUT`] standard deviations.
fn gaussian_mass() -> f64 {
    1.0 - exp(-0.5 * GAUSSIAN_CUT * GAUSSIAN_CUT)
}

/// Inverts the cumulative distribution of `1 − |x|` on [−1, 1].
fn sample_triangle(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 * (1.0 - u)).sqrt() }
}
