//! # rt-math: chapter 5, transformations
//!
//! The vocabulary that every other crate speaks, and the contracts between them:
//!
//! ```text
//!        p(t) = origin + t · direction          a ray; t is the same number in every space
//!
//!   Primitives ──── decide() ──── Accelerator   who is hit first?  one function answers, for every structure
//! ```
//!
//! **Owns** [`Ray`], [`Interval`], [`Aabb`] and its slab test, [`Transform`] (an affine map kept in both
//! directions), [`AnimatedTransform`] and [`KeyframedTransform`] (such that change with time), [`Rgb`], [`Frame`], the statistics ([`Probe`], [`Counters`]), the hash that all random numbers come
//! from ([`random`]), and the contracts [`Primitives`], [`ClosestPoint`], [`Accelerator`] and
//! [`Sampler`], and the tests of triangles ([`WatertightRay`]) and spheres ([`SphereKernel`]), which structures may run on
//! copies of them.
//! **Does not own** any other shape, nor any structure, light or camera.
//!
//! Everything is `f64`. Functions whose last bit differs between platforms come from [`transcendental`].
//!
//! ```
//! use rt_math::{DVec3, Ray, Transform};
//!
//! // A transform maps source to target; its name says so, and products cancel.
//! let world_from_local = Transform::translate(DVec3::new(0.0, 0.0, -5.0)).compose(&Transform::scale(DVec3::splat(2.0))?);
//! let ray = Ray::new(DVec3::ZERO, DVec3::NEG_Z);
//!
//! // The direction is not normalised on the way to local space, so `t` means the same in both.
//! let local = world_from_local.inverse_ray(&ray);
//! let t = 3.0;
//! assert_eq!(world_from_local.point(local.at(t)), ray.at(t));
//! # Ok::<(), rt_math::TransformError>(())
//! ```

#![forbid(unsafe_code)]

mod aabb;
mod animated_transform;
mod animated_transform_chain;
pub mod float;
mod frame;
mod interval;
mod keyframed_transform;
mod keyframes;
pub mod random;
mod ray;
mod rgb;
mod sampler;
pub mod stats;
pub mod transcendental;
mod transform;

pub use aabb::{Aabb, BOUNDS_PADDING, FAR_FACTOR, SlabRay};
pub use animated_transform::{AnimatedTransform, AnimatedTransformError};
pub use animated_transform_chain::AnimatedTransformChain;
pub use frame::Frame;
pub use interval::Interval;
pub use keyframed_transform::{KeyframedTransform, KeyframedTransformError};
pub use keyframes::{Interpolation, Keyframes, KeyframesError};
pub use ray::Ray;
pub use rgb::Rgb;
pub use sampler::Sampler;
pub use transform::{Transform, TransformError};

pub use glam::{DMat3, DQuat, DVec2, DVec3, Vec2, Vec3};
