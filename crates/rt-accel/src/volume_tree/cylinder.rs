//! Axis-aligned bounding cylinders.

use core::f64::consts::PI;

use glam::DVec3;
use rt_math::{Aabb, FAR_FACTOR, Interval, SlabRay};

use super::quadric::{chord, entry, error_margin, sqrt_up};
use super::volume::BoundingVolume;
use crate::axis::Axis;

/// Cylinder with caps along the x, y or z axis, with the smallest surface of the three.
///
/// Fits long and flat contents as well as a box does, and upright round contents better.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoundingCylinder {
    axis: Axis,
    centre: DVec3,
    /// `f64::MAX` on overflow.
    radius: f64,
    /// Coordinates of the caps on the axis.
    caps: [f64; 2],
}

impl BoundingCylinder {
    /// Index of the coordinate axis along which the cylinder lies.
    pub fn axis(&self) -> usize {
        self.axis as usize
    }

    /// Centre, space of the primitives.
    pub fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Radius.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Coordinates of the caps on the axis.
    pub fn caps(&self) -> [f64; 2] {
        self.caps
    }

    /// Part of the ray between the caps. Monotone as the slab test: see [`Aabb::clip`].
    #[inline(always)]
    fn between_caps(&self, ray: &SlabRay) -> Interval {
        let (origin, inverse) = (ray.ray.origin[self.axis as usize], ray.inverse[self.axis as usize]);
        let near = usize::from(inverse.is_sign_negative());
        let t_near = (self.caps[near] - origin) * inverse;
        let t_far = (self.caps[near ^ 1] - origin) * inverse * FAR_FACTOR;
        // A NaN is no constraint.
        Interval::new(
            if t_near > f64::NEG_INFINITY { t_near } else { f64::NEG_INFINITY },
            if t_far < f64::INFINITY { t_far } else { f64::INFINITY },
        )
    }
}

/// Part of a vector at right angles to an axis.
#[inline(always)]
fn across(axis: Axis, mut vector: DVec3) -> DVec3 {
    vector[axis as usize] = 0.0;
    vector
}

/// Squared distances from the lines through a point, along x, y and z, to the farthest edges of a box around it.
fn reach_squared(centre: DVec3, aabb: &Aabb) -> DVec3 {
    let farthest = (centre - aabb.min).max(aabb.max - centre);
    let square = farthest * farthest;
    DVec3::new(square.y + square.z, square.x + square.z, square.x + square.y)
}

impl BoundingVolume for BoundingCylinder {
    fn around(boxes: impl Iterator<Item = Aabb> + Clone) -> Self {
        let union = boxes.clone().fold(Aabb::EMPTY, Aabb::union);
        let centre = union.centre();
        let reach = boxes.fold(DVec3::ZERO, |most, own| most.max(reach_squared(centre, &own)));
        let [x, y, z] = Axis::ALL.map(|axis| {
            let caps = [union.min[axis as usize], union.max[axis as usize]];
            Self { axis, centre, radius: sqrt_up(reach[axis as usize]), caps }
        });
        let smaller = |a: Self, b: Self| if b.measure() < a.measure() { b } else { a };
        smaller(smaller(x, y), z)
    }

    fn encloses(&self, aabb: &Aabb) -> bool {
        let axis = self.axis as usize;
        self.caps[0] <= aabb.min[axis]
            && aabb.max[axis] <= self.caps[1]
            && sqrt_up(reach_squared(self.centre, aabb)[axis]) <= self.radius
    }

    #[inline(always)]
    fn enter(&self, ray: &SlabRay, span: Interval) -> Option<f64> {
        let between = self.between_caps(ray);
        let offset = ray.ray.origin - self.centre;
        let inside = match error_margin(&ray.ray, offset, self.radius + (self.caps[1] - self.caps[0])) {
            None => between,
            Some(error_margin) => {
                let direction = ray.ray.direction;
                let speed = direction.abs().max_element();
                let [offset, direction] = [offset, direction].map(|vector| across(self.axis, vector));
                let inside = chord(offset, direction, speed, self.radius, error_margin)?;
                Interval::new(between.min.max(inside.min), between.max.min(inside.max))
            }
        };
        entry(inside, span)
    }

    fn bounds(&self) -> Aabb {
        let reach = DVec3::splat(self.radius);
        let mut bounds = Aabb::new((self.centre - reach).map(f64::next_down), (self.centre + reach).map(f64::next_up));
        bounds.min[self.axis as usize] = self.caps[0];
        bounds.max[self.axis as usize] = self.caps[1];
        bounds
    }

    fn measure(&self) -> f64 {
        2.0 * PI * self.radius * (self.radius + (self.caps[1] - self.caps[0]))
    }
}
