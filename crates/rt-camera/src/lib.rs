//! # rt-camera: chapter 3, camera and image plane

#![forbid(unsafe_code)]

mod camera;
mod develop;
mod film;
mod filter;
#[cfg(feature = "files")]
mod image_file;
mod mitchell;
mod pattern;
#[cfg(feature = "files")]
mod pfm;
mod pixel_sampler;
#[cfg(feature = "files")]
mod read_image;
mod sobol;
#[cfg(feature = "files")]
mod write_image;

pub use camera::{Camera, CameraError, CameraSettings, FovAxis, Projection};
pub use develop::{Bitmap8, Development, DevelopmentError, Encoding, ToneCurve};
pub use film::{Film, FilmError, FilmSettings};
pub use filter::Filter;
#[cfg(feature = "files")]
pub use image_file::{ImageFileError, ImageFormat};
pub use pattern::SamplePattern;
pub use pixel_sampler::{PixelSample, PixelSampler};
#[cfg(feature = "files")]
pub use read_image::{MAX_READ_PIXELS, read_image};
#[cfg(feature = "files")]
pub use write_image::write_image;
