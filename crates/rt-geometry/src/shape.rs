//! The closed set of shapes.

use crate::{AxisBox, Plane, Sphere, SurfaceInteraction, SurfaceNeeds, Triangle};
use rt_math::{Aabb, Interval, Ray};

/// A hit on a single shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeHit {
    /// Ray parameter.
    pub t: f64,
    /// Parameters for the shape to rebuild the surface from: barycentric weights of the second and third vertex for
    /// triangles, `[face, 0]` for boxes, unused otherwise.
    pub uv: [f64; 2],
}

/// Any single shape, in its own local space.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
    /// An axis-aligned box.
    AxisBox(AxisBox),
    /// An infinite plane.
    Plane(Plane),
    /// A triangle.
    Triangle(Triangle),
}

impl Shape {
    /// A box around the shape; `None` for a plane, which has none.
    pub fn bounds(&self) -> Option<Aabb> {
        match self {
            Self::Sphere(sphere) => Some(sphere.bounds()),
            Self::AxisBox(axis_box) => Some(axis_box.bounds()),
            Self::Plane(_) => None,
            Self::Triangle(triangle) => Some(triangle.bounds()),
        }
    }

    /// The first hit at or after `span.min`, if it is not after `span.max`; `None` on a miss and for rays with a NaN
    /// or without a direction.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        match self {
            Self::Sphere(sphere) => sphere.intersect(ray, span),
            Self::AxisBox(axis_box) => axis_box.intersect(ray, span),
            Self::Plane(plane) => plane.intersect(ray, span),
            Self::Triangle(triangle) => triangle.intersect(ray, span),
        }
    }

    /// The surface at a hit of this shape with this ray.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: SurfaceNeeds) -> SurfaceInteraction {
        match self {
            Self::Sphere(sphere) => sphere.surface(ray, hit, needs),
            Self::AxisBox(axis_box) => axis_box.surface(ray, hit, needs),
            Self::Plane(plane) => plane.surface(ray, hit, needs),
            Self::Triangle(triangle) => triangle.surface(ray, hit, needs),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rt_math::DVec3;

    fn shapes() -> [Shape; 4] {
        [
            Shape::Sphere(Sphere::new(DVec3::X, 1.0).expect("a sphere")),
            Shape::AxisBox(AxisBox::new(DVec3::NEG_ONE, DVec3::ONE).expect("a box")),
            Shape::Plane(Plane::new(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)).expect("a plane")),
            Shape::Triangle(Triangle::new([DVec3::X, DVec3::Y, DVec3::Z]).expect("a triangle")),
        ]
    }

    /// Numbers of all magnitudes, zeros, subnormals, infinities and NaN, and plain ones, so that some rays hit.
    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![any::<f64>(), -2.0..2.0f64, Just(0.0), Just(-0.0)]
    }

    fn any_ray() -> impl Strategy<Value = Ray> {
        prop::array::uniform6(number())
            .prop_map(|[a, b, c, d, e, f]| Ray::new(DVec3::new(a, b, c), DVec3::new(d, e, f)))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(5000))]

        #[test]
        fn any_ray_is_answered(ray in any_ray(), min in number(), max in number()) {
            let span = Interval::new(min, max);
            for shape in shapes() {
                let Some(hit) = shape.intersect(&ray, span) else { continue };
                prop_assert!(hit.t.is_finite() && span.contains(hit.t), "{shape:?}");
                prop_assert!(!ray.origin.is_nan() && !ray.direction.is_nan() && ray.direction != DVec3::ZERO, "{shape:?}");
            }
        }

        /// Shrinking the span from above drops hits and reveals none.
        #[test]
        fn a_shorter_span_reveals_nothing(ray in any_ray(), min in -3.0..3.0f64, max in -3.0..9.0f64) {
            for shape in shapes() {
                let long = shape.intersect(&ray, Interval::new(min, f64::INFINITY));
                let short = shape.intersect(&ray, Interval::new(min, max));
                prop_assert_eq!(short, long.filter(|hit| hit.t <= max), "{:?}", shape);
            }
        }
    }

    #[test]
    fn only_planes_are_unbounded() {
        assert_eq!(shapes().map(|shape| shape.bounds().is_some()), [true, true, false, true]);
    }
}
