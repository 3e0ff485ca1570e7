//! Curved sides of cylinders, cones and frusta in world space.

use rt_geometry::{CappedQuadric, Shape};
use rt_math::{DVec3, Interval, Ray};

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
        let Geometry::Shape(shape @ (Shape::Cylinder(quadric) | Shape::Cone(quadric) | Shape::Frustum(quadric))) =
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
            radii: end_radii(shape)?.map(|radius| radius * scale),
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

/// Radii at the bottom and the top of a cylinder, cone or frustum; 0 at an apex.
pub(crate) fn end_radii(shape: &Shape) -> Option<[f64; 2]> {
    match shape {
        Shape::Cylinder(cylinder) => Some([cylinder.radius(); 2]),
        Shape::Cone(cone) => Some([larger_radius(cone), 0.0]),
        Shape::Frustum(frustum) => {
            let (small, large) = (frustum.radius(), larger_radius(frustum));
            Some(if is_wider_at_bottom(frustum, small, large) { [large, small] } else { [small, large] })
        }
        _ => None,
    }
}

/// Radius of the larger end.
fn larger_radius(quadric: &CappedQuadric) -> f64 {
    // The box is rounded outwards by one step.
    quadric.bounds().max.x.next_down()
}

/// True if a ray from below, between both radii, meets the frustum at its bottom: at its side it would be halfway up.
fn is_wider_at_bottom(frustum: &CappedQuadric, small: f64, large: f64) -> bool {
    let [bottom, top] = frustum.heights();
    let height = top - bottom;
    let ray = Ray::new(DVec3::new(small + (large - small) / 2.0, bottom - height, 0.0), DVec3::Y * height);
    // Without caps, the ray meets the side only: a narrowing side from inside.
    let narrows = |t: f64| {
        if frustum.has_caps() {
            t < 1.25
        } else {
            let next_to = Ray { origin: ray.origin + DVec3::X * ((large - small) / 4.0), ..ray };
            frustum.intersect(&next_to, Interval::FORWARD).is_some_and(|hit| hit.t < t)
        }
    };
    frustum.intersect(&ray, Interval::FORWARD).is_some_and(|hit| narrows(hit.t))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_belong_to_their_ends() {
        for caps in [true, false] {
            let frustum = |bottom, top| Shape::Frustum(CappedQuadric::frustum(bottom, top, 3.0, caps).unwrap());
            for radii in [[1.0, 0.25], [0.25, 1.0], [1.0, 1.0 + 1e-9], [1.0 + 1e-9, 1.0], [0.1, 100.0], [1.0, 1.0]] {
                assert_eq!(end_radii(&frustum(radii[0], radii[1])), Some(radii), "caps: {caps}");
            }
            assert_eq!(end_radii(&Shape::Cone(CappedQuadric::cone(0.7, 2.0, caps).unwrap())), Some([0.7, 0.0]));
            assert_eq!(
                end_radii(&Shape::Cylinder(CappedQuadric::cylinder(0.7, 1.0, 2.0, caps).unwrap())),
                Some([0.7; 2])
            );
        }
    }
}
