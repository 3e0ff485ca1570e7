//! Regions of space to search for primitives.

use glam::DVec3;
use rt_math::Aabb;

/// Query region: queries find the primitives whose boxes it overlaps.
///
/// It must be conservative: it overlaps every box that holds one of its points, so that no primitive is missed.
pub trait Region {
    /// Bounds; sides may be infinite. Must be constant.
    fn bounds(&self) -> Aabb;

    /// True if the region and a box have a point in common. May be true for a box just outside.
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
    /// Centre.
    pub centre: DVec3,
    /// Radius; a sphere of negative or NaN radius is empty.
    pub radius: f64,
}

impl Region for SphereRegion {
    fn bounds(&self) -> Aabb {
        // Rounded outward: every box that `overlaps` accepts touches the bounds. Distances below 1e-154 have no square.
        let radius = self.radius * (1.0 + 8.0 * f64::EPSILON) + 2e-154;
        let [min, max] = [self.centre - radius, self.centre + radius];
        Aabb::new(
            DVec3::from_array(min.to_array().map(f64::next_down)),
            DVec3::from_array(max.to_array().map(f64::next_up)),
        )
    }

    /// True for every box that touches the sphere, and for boxes within some rounding errors of it.
    fn overlaps(&self, aabb: &Aabb) -> bool {
        let square = self.radius * self.radius * (1.0 + 8.0 * f64::EPSILON) + f64::MIN_POSITIVE;
        self.radius >= 0.0 && aabb.distance_squared(self.centre) <= square
    }
}
