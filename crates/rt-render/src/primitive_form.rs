//! Form of a primitive, known without a ray.

use rt_geometry::{Shape, TransformedShape};
use rt_math::DVec3;

use crate::instance::{InstanceGeometry, Instances};

/// Form of a primitive in the space of the world, as needed by the tests of adaptive sampling in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PrimitiveForm {
    /// A sphere.
    Sphere { centre: DVec3, radius: f64 },
    /// An infinite plane, and its normal of any length.
    Plane { point: DVec3, normal: DVec3 },
    /// Flat, convex and bounded.
    Flat,
    /// Convex, with flat faces; `uv[0]` of a hit is the index of the face.
    Faces,
    /// Anything else.
    Other,
}

impl Instances<'_> {
    /// Form of an instance.
    pub(crate) fn form(&self, index: u32) -> PrimitiveForm {
        match &self.instances[index as usize].geometry {
            InstanceGeometry::Shape(shape) => PrimitiveForm::of(shape),
            InstanceGeometry::TransformedShape(placed) => PrimitiveForm::of_placed(placed),
            InstanceGeometry::Triangle(triangle) if triangle.mesh.data().normals.is_empty() => PrimitiveForm::Flat,
            InstanceGeometry::Triangle(_)
            | InstanceGeometry::Mesh(..)
            | InstanceGeometry::Group(..)
            | InstanceGeometry::Animated(_) => PrimitiveForm::Other,
        }
    }
}

impl PrimitiveForm {
    pub(crate) fn of(shape: &Shape) -> Self {
        match shape {
            Shape::Sphere(sphere) => Self::Sphere { centre: sphere.centre(), radius: sphere.radius() },
            Shape::Plane(plane) => Self::Plane { point: plane.point(), normal: plane.normal() },
            Shape::Triangle(_) | Shape::Rectangle(_) => Self::Flat,
            Shape::Disk(disk) if disk.inner_radius() == 0.0 => Self::Flat,
            Shape::Cuboid(_) => Self::Faces,
            _ => Self::Other,
        }
    }

    /// Form of a transformed shape. Affine maps preserve flatness and convexity; a sphere needs a uniform scale.
    pub(crate) fn of_placed(placed: &TransformedShape) -> Self {
        let map = placed.world_from_local();
        match Self::of(placed.shape()) {
            Self::Plane { point, normal } => Self::Plane { point: map.point(point), normal: map.normal(normal) },
            Self::Sphere { centre, radius } => map
                .uniform_scale()
                .map_or(Self::Other, |scale| Self::Sphere { centre: map.point(centre), radius: radius * scale }),
            form => form,
        }
    }
}
