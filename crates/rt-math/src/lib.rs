//! # rt-math: vectors, transforms, random numbers
//!
//! Types and arithmetic of all other crates:
//!
//! ```text
//!        p(t) = origin + t · direction          a ray; t is the same number in every space
//!
//!        world ◀── world_from_local ── local    products cancel: a_from_b · b_from_c = a_from_c
//! ```
//!
//! **Owns** [`Ray`], [`Interval`], [`Aabb`] and its slab test, [`Transform`] (an affine map with its inverse),
//! [`AnimatedTransform`], [`KeyframedTransform`], [`Rgb`] and [`Frame`]. Also error-free arithmetic ([`float`]), the
//! hash behind all random numbers ([`random`]), the interface [`Sampler`], and the connection of points to cameras
//! ([`CameraWiSample`]).
//!
//! **Does not own** shapes and their intersection (rt-geometry), accelerators, lights or cameras.
//!
//! Numbers are `f64`. Computations that are generic over [`Real`] also take lanes of them, or `f32` as [`F32`]. [`Vec2`] and
//! [`Vec3`] store pairs and triples in `f32`. Functions whose last bit differs between platforms come from [`transcendental`].
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
mod camera_wi_sample;
pub mod float;
mod frame;
mod interval;
mod keyframed_transform;
mod keyframes;
pub mod random;
mod ray;
mod real;
mod rgb;
mod sampler;
pub mod stats;
pub mod transcendental;
mod transform;
mod vector3;

pub use aabb::{Aabb, BOUNDS_PADDING, FAR_FACTOR, SlabRay};
pub use animated_transform::{AnimatedTransform, AnimatedTransformError};
pub use animated_transform_chain::AnimatedTransformChain;
pub use camera_wi_sample::CameraWiSample;
pub use frame::{Frame, tangents};
pub use interval::Interval;
pub use keyframed_transform::{KeyframedTransform, KeyframedTransformError};
pub use keyframes::{Interpolation, Keyframes, KeyframesError};
pub use ray::Ray;
pub use real::{F32, Float64, Mask, Real};
pub use rgb::Rgb;
pub use sampler::{Sampler, Samplers};
pub use transform::{Transform, TransformError};
pub use vector3::Vector3;

pub use glam::{DMat3, DQuat, DVec2, DVec3, Vec2, Vec3};
