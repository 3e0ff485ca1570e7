//! # rt-image: images of linear light
//!
//! From linear radiance to bytes, from files to linear radiance, and how far two images are apart:
//!
//! ```text
//!   file ──read_image──▶ Image ──Development──▶ Bitmap8 ──write_image──▶ PNG, JPEG
//!                          │                        byte = round(255 · encode(tone(2^exposure · radiance)))
//!                          ├──write_image──▶ EXR, HDR, PFM
//!                          └──metrics──▶ RMSE, SSIM, ꟻLIP ...
//! ```
//!
//! | step | type |
//! |---|---|
//! | linear radiance of every pixel | [`Image`] |
//! | exposure, tone curve, encoding | [`Development`], [`ToneCurve`], [`Encoding`]; bytes: [`Bitmap8`] |
//! | rounding that keeps gradients smooth | [`Dither`] |
//! | files (feature `files`, on by default) | `read_image`, `write_image` |
//! | differences between two images | [`metrics`] |
//!
//! **Owns** pixels, tone mapping, image files and metrics. **Does not own** cameras, sample patterns and filters
//! (rt-camera), or replacing files (rt-cli).
//!
//! ```
//! use rt_image::{Development, Image};
//!
//! let mut image = Image::new(2, 1, false); // width, height, without alpha
//! image.pixels_mut()[1] = [1.0; 3];
//! let bitmap = Development::default().develop(&image);
//! assert_eq!(bitmap.bytes, [0, 0, 0, 255, 255, 255]);
//! ```

#![forbid(unsafe_code)]

mod develop;
mod dither;
#[cfg(feature = "files")]
mod exr_layers;
#[cfg(feature = "files")]
mod gray_exr_decoder;
#[cfg(feature = "files")]
mod hdr_decoder;
mod image;
#[cfg(feature = "files")]
mod image_decoder;
#[cfg(feature = "files")]
mod image_file;
#[cfg(feature = "files")]
mod jpeg_decoder;
pub mod metrics;
#[cfg(feature = "files")]
mod pfm;
#[cfg(feature = "files")]
mod read_image;
#[cfg(test)]
mod test_images;
#[cfg(feature = "files")]
mod texture_pixels;
mod tone_curve;
#[cfg(feature = "files")]
mod write_image;

pub use develop::{Bitmap8, Development, DevelopmentError};
pub use dither::Dither;
#[cfg(feature = "files")]
pub use exr_layers::{ChannelRows, Layer, color_rows, write_layers};
pub use image::Image;
#[cfg(feature = "files")]
pub use image_decoder::{ExrParts, ImageSource, decode_pixels, exr_parts, guess_format, image_decoder};
#[cfg(feature = "files")]
pub use image_file::{ImageFileError, ImageFormat, MAX_READ_PIXELS};
#[cfg(feature = "files")]
pub use read_image::{
    ImageHeader, decode_image, format_of_bytes, header_of_bytes, image_format, image_header, read_image,
};
#[cfg(feature = "files")]
pub use texture_pixels::TexturePixels;
pub use tone_curve::{Encoding, ToneCurve};
#[cfg(feature = "files")]
pub use write_image::write_image;
