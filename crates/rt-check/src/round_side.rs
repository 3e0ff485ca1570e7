//! Curved sides of cylinders, cones and frusta in world space.

use rt_geometry::Shape;
use rt_math::DVec3;

use crate::objects::{Geometry, Object};
use crate::tolerance::tolerance;

/// Maximum deviation of a transform from a similarity around the axis, relative.
const ROUND: f64 = 1e-13;

/// Side of a circular cylinder, cone or frustum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoundSide {
    /// Ends of the axis.
    ends: [DVec3; 2],
    /// Radii at the ends; 0 at an apex.
    radii: [f64; 2],
}

impl RoundSide {
    /// Side of an object in world space; `None` for other shapes, and if the transform makes it elliptic or oblique.
    pub(crate) fn of(object: &Object<'_>) -> Option<Self> {
        let Geometry::Shape(Shape::Cylinder(quadric) | Shape::Cone(quadric) | Shape::Frustum(quadric)) =
            object.geometry
        else {
            return None;
        };
        let map = &object.world_from_local;
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| map.vector(axis));
        let (scale, height) = (x.length(), y.length());
        let is_round = (z.length() - scale).abs() <= ROUND * scale && x.dot(z).abs() <= ROUND * scale * scale;
        let is_upright = x.dot(y).abs().max(z.dot(y).abs()) <= ROUND * scale * height;
        (is_round && is_upright).then_some(Self {
            ends: quadric.heights().map(|y| map.point(DVec3::Y * y)),
            radii: quadric.radii().map(|radius| radius * scale),
        })
    }

    /// True if two sides coincide in more than a circle. `placement_errors` bounds the errors of both transforms.
    pub(crate) fn coincides(&self, other: &Self, placement_errors: f64) -> bool {
        let reach = [self, other]
            .into_iter()
            .flat_map(|side| side.ends)
            .fold(0.0, |max: f64, p| max.max(p.abs().max_element()));
        let allowed = tolerance(placement_errors, reach + self.radii[0].max(self.radii[1]));
        let [from, to] = self.ends;
        let length = (to - from).length();
        let axis = (to - from) / length;
        let along = other.ends.map(|end| (end - from).dot(axis));
        let is_coaxial = other.ends.iter().zip(along).all(|(end, t)| (*end - from - axis * t).length() <= allowed);
        let (low, high) = (along[0].min(along[1]).max(0.0), along[0].max(along[1]).min(length));
        let radius = |[a, b]: [f64; 2], share: f64| a + (b - a) * share;
        let differs = |t: f64| {
            let share = (t - along[0]) / (along[1] - along[0]);
            (radius(self.radii, t / length) - radius(other.radii, share)).abs() > allowed
        };
        is_coaxial && high - low > allowed && !differs(low) && !differs(high)
    }
}
