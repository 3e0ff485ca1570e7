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
//! directions), [`Motion`] and [`TransformKeys`] (such that change with time), [`Rgb`], [`Frame`], the statistics ([`Probe`], [`Counters`]), the hash that all random numbers come
//! from ([`random`]), and the contracts [`Primitives`], [`NearestPoint`], [`Accelerator`] and
//! [`Sampler`], and the tests of triangles ([`ShearedRay`]) and spheres ([`RoundSphere`]), which structures may run on
//! copies of them.
//! **Does not own** any other shape, nor any structure, light or camera.
//!
//! Everything is `f64`. Functions whose last bit differs between platforms come from [`transcendental`].
//!
//! ```
//! use rt_math::{DVec3, Ray, Transform};
//!
//! // A transform maps source to target; its name says so, and products cancel.
//! let world_from_local = Transform::translate(DVec3::new(0.0, 0.0, -5.0)).then_first(&Transform::scale(DVec3::splat(2.0))?);
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
mod accelerator;
mod decide;
pub mod float;
mod frame;
mod hit;
mod interval;
mod motion;
mod motion_chain;
mod nearest_point;
mod primitives;
mod probe;
pub mod random;
mod ray;
mod rgb;
mod round_sphere;
mod sampler;
mod sheared_ray;
mod timeline;
pub mod transcendental;
mod transform;
mod transform_keys;

pub use aabb::{Aabb, FAR_FACTOR, OWN_BOX_PAD, SlabRay};
pub use accelerator::Accelerator;
pub use decide::{
    decide, decide_occluded, decide_offered, decide_offered_batch, decide_offered_occluded,
    decide_offered_occluded_batch, decide_triangle, own_box,
};
pub use frame::Frame;
pub use hit::Hit;
pub use interval::Interval;
pub use motion::{Motion, MotionError};
pub use motion_chain::MotionChain;
pub use nearest_point::NearestPoint;
pub use primitives::{BatchKernel, LeafLayout, Primitives};
pub use probe::{Counters, NoProbe, Probe, RayCounts, RayKind, Tally};
pub use ray::Ray;
pub use rgb::Rgb;
pub use round_sphere::RoundSphere;
pub use sampler::Sampler;
pub use sheared_ray::{ShearedRay, TriangleHit};
pub use timeline::{Interpolation, Timeline, TimelineError};
pub use transform::{Transform, TransformError};
pub use transform_keys::{TransformKeys, TransformKeysError};

pub use glam::{DMat3, DQuat, DVec2, DVec3, Vec2, Vec3};
