//! # rt-camera: camera and image plane
//!
//! From a sample of a pixel to a ray:
//!
//! ```text
//!                                    0        r.x      width
//!              y up               0  ┌─────────┬─────────┐      raster r = pixel + sample offset + filter(u)
//!              │   image plane       │         │         │
//!              │  at distance 1      │         │         │      s = 2·tan(fov / 2) / height    side of a pixel
//!      pinhole ●────── x      r.y    ├─────────┼─────────┤      c = (width, height) / 2        principal point
//!             ╱                      │         │         │
//!            z    view along −z      └─────────┴─────────┘      direction = (s·(r.x − c.x), −s·(r.y − c.y), −1)
//!                             height
//! ```
//!
//! | step | type |
//! |---|---|
//! | coordinates of a sample, a pure function of (seed, pixel, sample, dimension) | [`PixelSampler`], [`SamplerKind`] |
//! | where in and around the pixel, and with which weight | [`Filter`] |
//! | ray through a raster point, and back | [`Camera`] |
//! | where on the aperture it starts, and where it is sharp | [`Lens`] |
//! | when it is cast, and where the camera is then | [`Camera::shutter_time`], [`CameraSettings::moves_to`] |
//! | boxes that none of these rays hits | [`ViewVolume`] |
//! | size, sample position, filter, development of the image | [`FilmSettings`] |
//!
//! **Owns** cameras, sample patterns, reconstruction filters and the settings of the film.
//! **Does not own** pixels, tone mapping and image files (rt-image), what the rays hit, or the radiance that they carry.
//!
//! A tiny film, exposed to a sky that is bright above and dark below:
//!
//! ```
//! use rt_image::{Development, Image};
//! use rt_camera::{Camera, CameraSettings, FilmSettings, FovAxis, PixelSampler, Projection, SamplerKind};
//! use rt_math::{DVec2, Sampler, Transform};
//!
//! let settings = FilmSettings { width: 8, height: 6, ..FilmSettings::default() };
//! settings.validate()?;
//! let projection = Projection::Perspective { fov: 60f64.to_radians(), axis: FovAxis::Horizontal };
//! let camera = Camera::new(&CameraSettings::new(Transform::IDENTITY, projection), settings.width, settings.height)?;
//! let sampler = PixelSampler::new(SamplerKind::Sobol, 16, 0);
//!
//! let mut film = Image::new(settings.width, settings.height, false);
//! for (index, radiance) in (0..).zip(film.pixels_mut()) {
//!     let pixel = [index % settings.width, index / settings.width];
//!     let corner = DVec2::new(f64::from(pixel[0]), f64::from(pixel[1]));
//!     let mut sum = 0.0;
//!     for number in 0..sampler.spp() {
//!         let mut sample = sampler.sample(pixel, number);
//!         let (offset, weight) = settings.filter.sample(sample.next_2d());
//!         let ray = camera.ray(corner + settings.sample_offset + offset, 0.0);
//!         sum += weight * (0.5 + 0.5 * ray.direction.normalize().y);
//!     }
//!     *radiance = [(sum / f64::from(sampler.spp())) as f32; 3];
//! }
//!
//! let bitmap = Development::default().develop(&film);
//! assert!(bitmap.bytes.first() > bitmap.bytes.last());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

mod blue_noise;
mod camera;
mod camera_error;
mod film_settings;
mod filter;
mod float_lanes;
mod halton;
mod lens;
mod mitchell;
mod pixel_sampler;
mod sample_lanes;
mod sampler_kind;
mod simd;
mod sobol;
mod view_volume;

pub use camera::{Camera, CameraSettings, FovAxis, Projection, RayArrays};
pub use camera_error::CameraError;
pub use film_settings::{FilmError, FilmSettings};
pub use filter::Filter;
pub use lens::Lens;
pub use pixel_sampler::{PixelSampler, SampleStream};
pub use sampler_kind::SamplerKind;
pub use view_volume::ViewVolume;
