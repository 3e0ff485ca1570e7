//! Shapes under affine transforms.

use crate::{AxisBox, Plane, Shape, ShapeHit, Sphere, SurfaceInteraction, SurfaceNeeds, Triangle};
use rt_math::float::gamma;
use rt_math::{Aabb, DMat3, DVec3, Interval, Ray, Transform};

/// A shape somewhere in the world: rays are taken to its local space, where the parameter `t` is the same.
///
/// Its front is the image of the local front, also under a mirroring map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    shape: Shape,
    world_from_local: Transform,
}

impl Placed {
    /// The shape, moved by a transform.
    pub const fn new(shape: Shape, world_from_local: Transform) -> Self {
        Self { shape, world_from_local }
    }

    /// The shape in its local space.
    pub const fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Where it stands.
    pub const fn world_from_local(&self) -> &Transform {
        &self.world_from_local
    }

    /// A box in world space around the shape, widened by the rounding of the transform: the smallest one but for a
    /// turned box. `None` for a plane.
    pub fn bounds(&self) -> Option<Aabb> {
        let map = &self.world_from_local;
        let around = |point: DVec3, reach: DVec3| {
            let (point, error) = map.point_with_error(point, DVec3::ZERO);
            Aabb::new(point - reach - error, point + reach + error)
        };
        match &self.shape {
            // An ellipsoid reaches as far along an axis as that row of the linear part is long.
            Shape::Sphere(sphere) => {
                let rows = map.linear().transpose();
                let reach = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
                Some(around(sphere.centre(), reach * (sphere.radius() * (1.0 + gamma(8)))))
            }
            Shape::AxisBox(axis_box) => Some(map.aabb(&axis_box.bounds())),
            Shape::Plane(_) => None,
            Shape::Triangle(triangle) => {
                Some(triangle.vertices().iter().fold(Aabb::EMPTY, |sum, &v| sum.union(around(v, DVec3::ZERO))))
            }
        }
    }

    /// The first hit of a world-space ray at or after `span.min`, if it is not after `span.max`.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        self.shape.intersect(&self.world_from_local.inverse_ray(ray), span)
    }

    /// The surface in world space at a hit of [`intersect`](Self::intersect) with this world-space ray.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: SurfaceNeeds) -> SurfaceInteraction {
        let local = self.world_from_local.inverse_ray(ray);
        self.shape.surface(&local, hit, needs).transformed(&self.world_from_local)
    }

    /// A world-space shape that looks the same in all respects, texture coordinates included: anything that is only
    /// moved, a sphere that is scaled alike along all axes, a box that is scaled along its axes without mirroring, a
    /// triangle under any map that does not mirror. `None` if there is none.
    pub fn baked(&self) -> Option<Shape> {
        let linear = self.world_from_local.linear();
        let scale = diagonal(&linear).filter(|scale| scale.min_element() > 0.0);
        let keeps_uv = match &self.shape {
            Shape::Sphere(_) => scale.is_some_and(|s| s.x == s.y && s.y == s.z),
            Shape::AxisBox(_) => scale.is_some(),
            Shape::Plane(_) => linear == DMat3::IDENTITY,
            Shape::Triangle(_) => !self.world_from_local.flips_handedness(),
        };
        if keeps_uv { self.baked_without_uv() } else { None }
    }

    /// A world-space shape with the same points and the same front, but maybe other texture coordinates: a sphere
    /// that stays round, a box that is scaled along its axes, any plane, any triangle. `None` if there is none.
    pub fn baked_without_uv(&self) -> Option<Shape> {
        let map = &self.world_from_local;
        match &self.shape {
            Shape::Sphere(sphere) => {
                let radius = sphere.radius() * map.uniform_scale()?;
                Sphere::new(map.point(sphere.centre()), radius).ok().map(Shape::Sphere)
            }
            Shape::AxisBox(axis_box) => {
                diagonal(&map.linear())?;
                let Aabb { min, max } = axis_box.bounds();
                let (a, b) = (map.point(min), map.point(max));
                AxisBox::new(a.min(b), a.max(b)).ok().map(Shape::AxisBox)
            }
            Shape::Plane(plane) => {
                Plane::new(map.point(plane.point()), map.normal(plane.normal())).ok().map(Shape::Plane)
            }
            Shape::Triangle(triangle) => {
                let [a, b, c] = triangle.vertices().map(|v| map.point(v));
                // A mirror turns the winding around: two vertices change places, so that the front stays.
                let vertices = if map.flips_handedness() { [a, c, b] } else { [a, b, c] };
                Triangle::new(vertices).ok().map(Shape::Triangle)
            }
        }
    }
}

/// The diagonal of a matrix that has nothing else.
fn diagonal(m: &DMat3) -> Option<DVec3> {
    let diagonal = DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z);
    (*m == DMat3::from_diagonal(diagonal)).then_some(diagonal)
}
