//! # rt-camera: chapter 3, camera and image plane

#![forbid(unsafe_code)]

mod camera;
mod develop;
mod film;
mod filter;
mod mitchell;
mod pattern;
mod pixel_sampler;
mod sobol;

pub use camera::{Camera, CameraError, CameraSettings, FovAxis, Projection};
pub use develop::{Development, Encoding, ToneCurve};
pub use film::{Film, FilmSettings};
pub use filter::Filter;
pub use pattern::SamplePattern;
pub use pixel_sampler::{PixelSample, PixelSampler};
