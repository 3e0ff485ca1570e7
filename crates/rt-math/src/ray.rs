//! Rays.

use glam::DVec3;

/// A half-line `origin + t · direction`, at one time of the shutter.
///
/// The direction **need not be unit**. Transforms preserve the parameter `t` of a point instead of the length, so that
/// `t` is the same in world and in local space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start of the ray, in the space that the ray is expressed in.
    pub origin: DVec3,
    /// Direction, of any non-zero length.
    pub direction: DVec3,
    /// Time of the ray within the shutter interval, 0 to 1. Only moving objects depend on it.
    pub time: f64,
}

impl Ray {
    /// A ray at time 0.
    #[inline]
    pub const fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, time: 0.0 }
    }

    /// The point at parameter `t`.
    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}
