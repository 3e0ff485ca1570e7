//! Differences of two images.
//!
//! ```text
//!      e = x − r                      x: the image under test, r: the reference
//!      bias = Ē e   MAE = Ē |e|   MSE = Ē e²   relMSE = Ē e² / (r² + 0.01)   RMSE = √MSE      Ē: mean over pixels
//!      PSNR = −10 log₁₀ Ē (s(x) − s(r))²   SSIM, ꟻLIP: s(x) and s(r) as perceived          s: as displayed
//! ```
//!
//! | metric | computed from | of equal images |
//! |---|---|---|
//! | [`bias`], [`mean_absolute_error`], [`mean_squared_error`], [`relative_mean_squared_error`], [`largest_difference`] | linear radiance | 0 |
//! | [`psnr`], [`ssim`] | the signal that a [`Development`](crate::Development) sends to the display, before it is rounded to bytes | ∞, 1 |
//! | [`Flip::ldr`] | the light that the display then shows | 0 |
//! | [`Flip::hdr`] | linear radiance, shown at all exposures that fit it | 0 |
//!
//! Sums are made in `f64`, in reading order. Metrics of radiance leave out pixels that are not finite in one of the two
//! images. [`ImagePair::non_finite`] counts them. Metrics of the display take NaN for black and infinity for the
//! maximum.
//!
//! ```
//! use rt_image::{Image, metrics::{ImagePair, bias, mean_squared_error}};
//!
//! let (mut test, reference) = (Image::new(4, 1, false), Image::new(4, 1, false));
//! test.pixels_mut()[2] = [2.0; 3];
//! let pair = ImagePair::new(&test, &reference)?;
//! assert_eq!(bias(&pair).all.mean, 0.5);
//! assert_eq!(mean_squared_error(&pair).mean().sqrt(), 1.0);
//! # Ok::<(), rt_image::metrics::PairError>(())
//! ```

mod bias;
mod coverage;
mod error_map;
mod flip;
mod heat_map;
mod largest_difference;
mod mean_error;
mod pair;
mod plane;
mod psnr;
mod ssim;

pub use bias::{Bias, Estimate, bias};
pub use coverage::coverage_difference;
pub use error_map::{ErrorMap, signed_error};
pub use flip::{ExposureRange, Flip, FlipError};
pub use heat_map::{ColourScale, heat_map};
pub use largest_difference::{LargestDifference, largest_difference};
pub use mean_error::{
    PerChannel, RELATIVE_EPSILON, mean_absolute_error, mean_squared_error, relative_mean_squared_error,
};
pub use pair::{ImagePair, NonFinite, PairError};
pub use psnr::psnr;
pub use ssim::ssim;
