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
#[derive(Clone, Copy, Debug, PartialEq)]
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
