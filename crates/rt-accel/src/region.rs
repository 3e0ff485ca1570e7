//! Parts of space that can be searched for primitives.

use glam::DVec3;
use rt_math::Aabb;

/// A part of space.
pub trait Region {
    /// A box around it; sides may be infinite. It must not change.
    fn bounds(&self) -> Aabb;

    /// True if it has a point in common with a box. May be true for a box that lies just outside.
    fn overlaps(&self, aabb: &Aabb) -> bool;
}

impl<R: Region> Region for &R {
    fn bounds(&self) -> Aabb {
        (**self).bounds()
    }

    fn overlaps(&self, aabb: &Aabb) -> bool {
        (**self).overlaps(aabb)
    }
}

impl Region for Aabb {
    fn bounds(&self) -> Aabb {
        *self
    }

    /// Exact; boxes are closed.
    fn overlaps(&self, aabb: &Aabb) -> bool {
        Self::overlaps(self, aabb)
    }
}

/// All points within a radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereRegion {
    /// Its centre.
    pub centre: DVec3,
    /// Its radius; a ball of negative or NaN radius is empty.
    pub radius: f64,
}

impl Region for SphereRegion {
    fn bounds(&self) -> Aabb {
        // Rounded outward, so that a box which touches the ball touches this one.
        let [min, max] = [self.centre - self.radius, self.centre + self.radius];
        Aabb::new(
            DVec3::from_array(min.to_array().map(f64::next_down)),
            DVec3::from_array(max.to_array().map(f64::next_up)),
        )
    }

    fn overlaps(&self, aabb: &Aabb) -> bool {
        self.radius >= 0.0 && aabb.distance_squared(self.centre) <= self.radius * self.radius
    }
}
