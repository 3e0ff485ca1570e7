//! # rt-camera: chapter 3, camera and image plane

#![forbid(unsafe_code)]

mod camera;
mod develop;
mod film;
mod filter;
mod pattern;

pub use camera::{CameraSettings, FovAxis, Projection};
pub use develop::{Development, Encoding, ToneCurve};
pub use film::{Film, FilmSettings};
pub use filter::Filter;
pub use pattern::SamplePattern;
