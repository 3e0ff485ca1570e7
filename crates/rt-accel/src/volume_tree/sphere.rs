//! Bounding spheres.

use core::f64::consts::PI;

use glam::DVec3;
use rt_math::{Aabb, Interval, SlabRay};

use super::quadric::{chord, entry, error_margin, sqrt_up};
use super::volume::BoundingVolume;

/// Sphere around the centre of some boxes.
///
/// Spheres have few numbers and a cheap test, but enclose poorly. One around a cube has 2.7 times its volume, and one
/// around long and thin contents is mostly empty.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoundingSphere {
    centre: DVec3,
    /// `f64::MAX` on overflow.
    radius: f64,
}

impl BoundingSphere {
    /// Centre, space of the primitives.
    pub fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Radius.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

/// Squared distance from a point to the farthest corner of a box around it.
fn reach_squared(centre: DVec3, aabb: &Aabb) -> f64 {
    (centre - aabb.min).max(aabb.max - centre).length_squared()
}

impl BoundingVolume for BoundingSphere {
    fn around(boxes: impl Iterator<Item = Aabb> + Clone) -> Self {
        let centre = boxes.clone().fold(Aabb::EMPTY, Aabb::union).centre();
        Self { centre, radius: sqrt_up(boxes.fold(0.0, |most: f64, own| most.max(reach_squared(centre, &own)))) }
    }

    fn encloses(&self, aabb: &Aabb) -> bool {
        sqrt_up(reach_squared(self.centre, aabb)) <= self.radius
    }

    #[inline(always)]
    fn enter(&self, ray: &SlabRay, span: Interval) -> Option<f64> {
        let offset = ray.ray.origin - self.centre;
        let Some(error_margin) = error_margin(&ray.ray, offset, self.radius) else { return Some(span.min) };
        let direction = ray.ray.direction;
        entry(chord(offset, direction, direction.abs().max_element(), self.radius, error_margin)?, span)
    }

    fn bounds(&self) -> Aabb {
        let reach = DVec3::splat(self.radius);
        Aabb::new((self.centre - reach).map(f64::next_down), (self.centre + reach).map(f64::next_up))
    }

    fn measure(&self) -> f64 {
        4.0 * PI * self.radius * self.radius
    }
}
