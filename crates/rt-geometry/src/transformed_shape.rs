//! Shapes under affine transforms.

use crate::{Cuboid, InteractionFlags, Plane, Shape, ShapeHit, Sphere, SurfaceInteraction, Triangle};
use rt_math::{Aabb, DMat3, DVec3, Interval, Ray, Transform};
use std::sync::Arc;

/// Shape with a transform: rays are mapped to its local space, where the parameter `t` is the same.
///
/// Its front is the image of the local front, also under a mirroring map.
#[derive(Clone, Debug, PartialEq)]
pub struct TransformedShape {
    shape: Shape,
    world_from_local: Transform,
}

impl TransformedShape {
    /// Shape with a transform.
    pub const fn new(shape: Shape, world_from_local: Transform) -> Self {
        Self { shape, world_from_local }
    }

    /// The shape in its local space.
    pub const fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Transform from local to world space.
    pub const fn world_from_local(&self) -> &Transform {
        &self.world_from_local
    }

    /// The smallest box in world space around the shape, widened by the rounding of the transform. `None` for infinite
    /// shapes.
    ///
    /// A world coordinate of a point is its dot product with a row of the linear part, plus the translation. So the
    /// extent along the axis is the support function of that row.
    pub fn bounds(&self) -> Option<Aabb> {
        let map = &self.world_from_local;
        let local = self.shape.bounds()?;
        let rows = map.linear().transpose();
        let support = |sign: f64| {
            let along = |row: DVec3| self.shape.support(row * sign);
            Some(DVec3::new(along(rows.x_axis)?, along(rows.y_axis)?, along(rows.z_axis)?) * sign)
        };
        // A support is a sum of products like the map of a point, with twice the roundings.
        let (_, error) = map.point_with_error(local.min.abs().max(local.max.abs()), DVec3::ZERO);
        let (min, max) = (support(-1.0)?, support(1.0)?);
        Some(Aabb::new(map.translation() + min - error * 2.0, map.translation() + max + error * 2.0))
    }

    /// The first hit of a world-space ray at or after `span.min`, if it is not after `span.max`.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        self.shape.intersect(&self.world_from_local.inverse_ray(ray), span)
    }

    /// The surface in world space at a hit of [`intersect`](Self::intersect) with this world-space ray.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
        let local = self.world_from_local.inverse_ray(ray);
        self.shape.surface(&local, hit, needs).transformed(&self.world_from_local)
    }

    /// Equivalent world-space shape, texture coordinates included, or `None`. Exists for translated shapes, planes and
    /// polygons among them, and for uniformly scaled spheres. Boxes may be scaled along their axes without mirroring,
    /// and triangles mapped without mirroring.
    pub fn bake_transform(&self) -> Option<Shape> {
        let linear = self.world_from_local.linear();
        let scale = diagonal(&linear).filter(|scale| scale.min_element() > 0.0);
        let keeps_uv = match &self.shape {
            Shape::Sphere(_) => scale.is_some_and(|s| s.x == s.y && s.y == s.z),
            Shape::Cuboid(_) => scale.is_some(),
            Shape::Plane(_) | Shape::Polygon(_) => linear == DMat3::IDENTITY,
            Shape::Triangle(_) => !self.world_from_local.flips_handedness(),
            _ => false,
        };
        if keeps_uv { self.bake_transform_ignoring_uv() } else { None }
    }

    /// Equivalent world-space shape with perhaps other texture coordinates, or `None`. Exists for spheres that stay
    /// round, boxes that are scaled along their axes, planes, triangles, and polygons that rounding keeps flat.
    pub fn bake_transform_ignoring_uv(&self) -> Option<Shape> {
        let map = &self.world_from_local;
        match &self.shape {
            Shape::Sphere(sphere) => {
                let radius = sphere.radius() * map.uniform_scale()?;
                Sphere::new(map.point(sphere.centre()), radius).ok().map(Shape::Sphere)
            }
            Shape::Cuboid(axis_box) => {
                diagonal(&map.linear())?;
                let Aabb { min, max } = axis_box.bounds();
                let (a, b) = (map.point(min), map.point(max));
                Cuboid::new(a.min(b), a.max(b)).ok().map(Shape::Cuboid)
            }
            Shape::Plane(plane) => {
                Plane::new(map.point(plane.point()), map.normal(plane.normal())).ok().map(Shape::Plane)
            }
            Shape::Triangle(triangle) => {
                let [a, b, c] = triangle.vertices().map(|v| map.point(v));
                // A mirroring map reverses the winding: exchanging two vertices preserves the front.
                let vertices = if map.flips_handedness() { [a, c, b] } else { [a, b, c] };
                Triangle::new(vertices).ok().map(Shape::Triangle)
            }
            Shape::Polygon(polygon) => polygon.mapped(map).map(Arc::new).map(Shape::Polygon),
            // All others are at the origin of their local space, along its axes.
            _ => None,
        }
    }
}

/// Diagonal of a diagonal matrix.
fn diagonal(m: &DMat3) -> Option<DVec3> {
    let diagonal = DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z);
    (*m == DMat3::from_diagonal(diagonal)).then_some(diagonal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategies::vector;
    use proptest::prelude::*;

    fn shapes() -> [Shape; 4] {
        let sphere = Sphere::new(DVec3::new(0.5, -1.0, 0.25), 2.0).expect("a sphere");
        let solid = Cuboid::new(DVec3::new(-1.0, -2.0, 0.0), DVec3::new(1.0, 0.5, 3.0)).expect("a box");
        let floor = Plane::new(DVec3::new(0.0, 1.0, 2.0), DVec3::new(0.5, 1.0, -0.5)).expect("a plane");
        let flat = Triangle::new([DVec3::new(-2.0, 0.0, 0.5), DVec3::new(2.0, -1.0, 0.0), DVec3::new(0.0, 2.0, 1.0)]);
        [Shape::Sphere(sphere), Shape::Cuboid(solid), Shape::Plane(floor), Shape::Triangle(flat.expect("a triangle"))]
    }

    /// Translation, rotation, and scale by factors of either sign.
    fn transform() -> impl Strategy<Value = Transform> {
        (vector(20.0), vector(1.0), -7.0..7.0f64, vector(3.0)).prop_filter_map(
            "flat",
            |(offset, axis, angle, factors)| {
                let turn = Transform::rotate(axis, angle).ok()?;
                let scale = Transform::scale(factors).ok()?;
                (factors.abs().min_element() > 0.1).then(|| Transform::translate(offset).compose(&turn).compose(&scale))
            },
        )
    }

    fn first(placed: &TransformedShape, ray: &Ray) -> Option<(ShapeHit, SurfaceInteraction)> {
        let hit = placed.intersect(ray, Interval::FORWARD)?;
        Some((hit, placed.surface(ray, &hit, InteractionFlags::ALL)))
    }

    proptest! {
        #[test]
        fn a_placed_shape_is_the_shape_in_local_space(map in transform(), from in vector(8.0), to in vector(1.0)) {
            let local = Ray::new(from, to - from);
            let ray = map.ray(&local);
            for shape in shapes() {
                let placed = TransformedShape::new(shape.clone(), map);
                let expected = shape.intersect(&local, Interval::FORWARD);
                let found = first(&placed, &ray);
                let (Some(expected), Some((hit, surface))) = (expected, found) else { continue };
                prop_assume!((hit.t - expected.t).abs() < 1e-6);
                let point = map.point(local.at(expected.t));
                // Intersections of grazing rays may differ slightly.
                let slid = (hit.t - expected.t).abs() * ray.direction.length();
                prop_assert!((surface.point - point).length() < 1e-7 + 2.0 * slid);
                prop_assert!((surface.geometric_normal.length() - 1.0).abs() < 1e-15);
                let front = shape.surface(&local, &expected, InteractionFlags::ALL).geometric_normal;
                prop_assert_eq!(
                    front.dot(local.direction) < 0.0,
                    surface.geometric_normal.dot(ray.direction) < 0.0,
                    "the same side is seen"
                );
                if let Some(bounds) = placed.bounds() {
                    prop_assert!(bounds.padded().contains(surface.point));
                }
            }
        }

        #[test]
        fn baked_shapes_look_the_same(
            offset in vector(20.0), from in vector(20.0), to in vector(1.0), scale in vector(3.0), uniform in 0.1..5.0f64,
        ) {
            prop_assume!(scale.abs().min_element() > 0.1);
            let moved = Transform::translate(offset);
            let stretched = moved.compose(&Transform::scale(scale.abs()).expect("regular"));
            let enlarged = moved.compose(&Transform::scale(DVec3::splat(uniform)).expect("regular"));
            let [sphere, solid, floor, flat] = shapes();
            for (shape, map) in [(sphere, enlarged), (solid, stretched), (floor, moved), (flat, stretched)] {
                let placed = TransformedShape::new(shape, map);
                let baked = placed.bake_transform().expect("the same kind of shape");
                let ray = Ray::new(from, map.point(to) - from);
                let baked_hit = baked.intersect(&ray, Interval::FORWARD);
                let (Some((hit, surface)), Some(baked_hit)) = (first(&placed, &ray), baked_hit) else { continue };
                prop_assume!((hit.t - baked_hit.t).abs() < 1e-6);
                let baked_surface = baked.surface(&ray, &baked_hit, InteractionFlags::ALL);
                prop_assert!((surface.point - baked_surface.point).length() < 1e-6);
                prop_assert!((surface.geometric_normal - baked_surface.geometric_normal).length() < 1e-6);
                let uv = |k: usize| (surface.uv[k] - baked_surface.uv[k]).abs();
                prop_assert!(uv(0) < 1e-4 && uv(1) < 1e-4, "{:?} {:?}", surface.uv, baked_surface.uv);
            }
        }

        #[test]
        fn baked_without_uv_has_the_same_points_and_front(
            offset in vector(20.0), axis in vector(1.0), angle in -7.0..7.0f64, scale in vector(3.0), mirror in any::<bool>(),
            from in vector(20.0), to in vector(1.0),
        ) {
            prop_assume!(axis.length() > 0.1 && scale.abs().min_element() > 0.1);
            let moved = Transform::translate(offset);
            let stretched = moved.compose(&Transform::scale(scale).expect("regular"));
            let turned = stretched.compose(&Transform::rotate(axis, angle).expect("an axis"));
            let factor = DVec3::new(2.0, if mirror { -2.0 } else { 2.0 }, 2.0);
            let round = Transform::rotate(axis, angle).expect("an axis")
                .compose(&Transform::scale(factor).expect("regular"));
            let [sphere, solid, floor, flat] = shapes();
            for (shape, map) in [(sphere, round), (solid, stretched), (floor, turned), (flat, turned)] {
                let placed = TransformedShape::new(shape, map);
                let baked = placed.bake_transform_ignoring_uv().expect("the same kind of shape");
                let ray = Ray::new(from, map.point(to) - from);
                let baked_hit = baked.intersect(&ray, Interval::FORWARD);
                let (Some((hit, surface)), Some(baked_hit)) = (first(&placed, &ray), baked_hit) else { continue };
                prop_assume!((hit.t - baked_hit.t).abs() < 1e-6);
                let baked_surface = baked.surface(&ray, &baked_hit, InteractionFlags::ALL);
                prop_assert!((surface.geometric_normal - baked_surface.geometric_normal).length() < 1e-6);
            }
        }
    }

    #[test]
    fn only_what_stays_the_same_is_baked() {
        let [sphere, solid, floor, flat] = shapes();
        let turn = Transform::rotate(DVec3::Y, 0.3).expect("an axis");
        let mirror = Transform::scale(DVec3::new(-1.0, 1.0, 1.0)).expect("regular");
        let stretch = Transform::scale(DVec3::new(1.0, 2.0, 1.0)).expect("regular");
        let baked = |shape: Shape| {
            [turn, mirror, stretch].map(|map| {
                let placed = TransformedShape::new(shape.clone(), map);
                (placed.bake_transform().is_some(), placed.bake_transform_ignoring_uv().is_some())
            })
        };
        assert_eq!(baked(sphere), [(false, true), (false, true), (false, false)]);
        assert_eq!(baked(solid), [(false, false), (false, true), (true, true)]);
        assert_eq!(baked(floor), [(false, true); 3]);
        assert_eq!(baked(flat), [(true, true), (false, true), (true, true)]);
    }

    #[test]
    fn the_box_of_a_turned_ellipsoid_is_tight() {
        let sphere = Shape::Sphere(Sphere::new(DVec3::X, 1.0).expect("a sphere"));
        let stretch = Transform::scale(DVec3::new(3.0, 1.0, 1.0)).expect("regular");
        let map = Transform::rotate(DVec3::Z, std::f64::consts::FRAC_PI_4).expect("an axis").compose(&stretch);
        let bounds = TransformedShape::new(sphere, map).bounds().expect("bounded");
        let (centre, reach) = (4.5f64.sqrt(), 5.0f64.sqrt());
        let expected = Aabb::new(
            DVec3::new(centre - reach, centre - reach, -1.0),
            DVec3::new(centre + reach, centre + reach, 1.0),
        );
        assert!((bounds.min - expected.min).length() < 1e-14 && (bounds.max - expected.max).length() < 1e-14);
    }
}
