//! The closed set of shapes.

use crate::{AxisBox, Plane, Sphere, Triangle};

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
