//! Nearest points of one instance, in world space.
//!
//! Coordinates of geometries are at most [`MAX_COORDINATE`], so that squares of distances stay in range. A transform may
//! move an instance farther away. Its coordinates are then multiplied by a power of two, which is exact, before they are
//! squared.

use core::ops::ControlFlow;

use glam::DVec3;
use rt_geometry::{MAX_COORDINATE, Sphere, nearest_on_triangle};
use rt_math::{Aabb, Transform, float::power_of_two_scale};

use super::geometry::{Blas, Geometry};
use super::instances::Instance;
use super::triangle_mesh::TriangleMesh;
use crate::region::Region as _;
use crate::{Accelerator, PointHit, RegionQuery, SphereRegion};

/// 2⁻⁶⁰⁰: the square of any finite number times this is finite.
const SHRINK: f64 = f64::from_bits((1023 - 600) << 52);

/// Length of a vector; infinite only if no finite number is as large.
#[inline]
fn length(vector: DVec3) -> f64 {
    let square = vector.length_squared();
    // A power of two changes no digit, so that the order of lengths is kept.
    if square.is_finite() { square.sqrt() } else { (vector * SHRINK).length() / SHRINK }
}

/// Distance of a box from a point; infinite only if no finite number is as large.
#[inline]
pub(super) fn distance_to_box(aabb: &Aabb, point: DVec3) -> f64 {
    length((aabb.min - point).max(point - aabb.max).max(DVec3::ZERO))
}

/// Nearest point of one instance, at a distance that is finite and at most `radius`.
pub(super) fn nearest_of(geometry: &Blas<'_>, instance: &Instance, point: DVec3, radius: f64) -> Option<PointHit> {
    let Some(transform) = &instance.world_from_local else { return geometry.nearest_point(point, radius) };
    let is_far = instance.bounds.max_abs() > MAX_COORDINATE;
    match &geometry.geometry {
        Geometry::Mesh(mesh) if is_far => {
            let scale = scale_to_one(instance, point);
            let nearest = |index| on_placed_triangle(mesh, transform, index, point, scale);
            nearest_placed(geometry, transform, nearest, point, radius)
        }
        Geometry::Mesh(mesh) => {
            let nearest = |index| on_placed_triangle(mesh, transform, index, point, 1.0);
            nearest_placed(geometry, transform, nearest, point, radius)
        }
        Geometry::Spheres(spheres) => {
            let factor = transform.uniform_scale()?;
            let local = transform.inverse_point(point);
            if is_far || !local.abs().cmple(DVec3::splat(MAX_COORDINATE)).all() {
                let scale = scale_to_one(instance, point);
                let nearest = |index: u32| {
                    let sphere = spheres.as_slice().get(index as usize)?;
                    Some(on_placed_sphere(sphere, transform, factor, point, scale))
                };
                return nearest_placed(geometry, transform, nearest, point, radius);
            }
            // Wider than the rounding of both transforms; distances in world space decide.
            let largest = point.abs().max_element() + transform.point(DVec3::ZERO).abs().max_element() + radius;
            let radius_there = (radius + largest * 1e-12) / factor;
            let hit = geometry.nearest_point(local, radius_there)?;
            let nearest = transform.point(hit.point);
            let distance = nearest.distance(point);
            (distance <= radius).then_some(PointHit { point: nearest, distance, ..hit })
        }
    }
}

/// Power of two by which the coordinates of an instance and a point are multiplied before they are squared.
fn scale_to_one(instance: &Instance, point: DVec3) -> f64 {
    let Aabb { min, max } = instance.bounds;
    power_of_two_scale(min.abs().max(max.abs()).max(point.abs()))
}

/// Nearest point of a triangle in world space, computed with coordinates times `scale`.
#[inline]
fn on_placed_triangle(
    mesh: &TriangleMesh<'_>,
    world_from_local: &Transform,
    index: u32,
    point: DVec3,
    scale: f64,
) -> Option<DVec3> {
    let vertices = mesh.triangle(index)?.map(|vertex| world_from_local.point(vertex) * scale);
    Some(nearest_on_triangle(vertices, point * scale) / scale)
}

/// Nearest point of a sphere in world space, which the transform makes `factor` times as large. It is computed with
/// coordinates times `scale`.
fn on_placed_sphere(sphere: &Sphere, world_from_local: &Transform, factor: f64, point: DVec3, scale: f64) -> DVec3 {
    let centre = world_from_local.point(sphere.centre()) * scale;
    let away = point * scale - centre;
    // Scaled first, as its square may underflow. The topmost point for the centre.
    let outwards = (away / away.abs().max_element()).try_normalize().unwrap_or(DVec3::Y);
    (centre + outwards * (sphere.radius() * factor * scale)) / scale
}

fn nearest_placed(
    geometry: &Blas<'_>,
    world_from_local: &Transform,
    nearest: impl Fn(u32) -> Option<DVec3>,
    point: DVec3,
    radius: f64,
) -> Option<PointHit> {
    let mut query = NearestPlaced { nearest, world_from_local, point, radius, found: None };
    let _ = geometry.tree().traverse_region(&mut query);
    query.found
}

/// The nearest point in world space of primitives in their own space. Distances of boxes are those of their images, as a
/// transform need not keep the order of distances.
struct NearestPlaced<'q, F> {
    /// Nearest point of a primitive in world space.
    nearest: F,
    world_from_local: &'q Transform,
    point: DVec3,
    radius: f64,
    found: Option<PointHit>,
}

impl<F: Fn(u32) -> Option<DVec3>> RegionQuery for NearestPlaced<'_, F> {
    fn bounds(&self) -> Aabb {
        let region = SphereRegion { centre: self.point, radius: self.radius.next_up() }.bounds();
        if region.is_finite() { self.world_from_local.inverse().aabb(&region) } else { region }
    }

    fn query_point(&self) -> DVec3 {
        self.world_from_local.inverse_point(self.point)
    }

    fn distance_to(&self, aabb: &Aabb) -> Option<f64> {
        let distance = distance_to_box(&self.world_from_local.aabb(aabb), self.point);
        (distance <= self.radius).then_some(distance)
    }

    fn test_primitive(&mut self, index: u32, _: impl FnOnce(DVec3) -> bool) -> ControlFlow<()> {
        let Some(nearest) = (self.nearest)(index) else { return ControlFlow::Continue(()) };
        let distance = length(nearest - self.point);
        let is_tie = || distance == self.radius && self.found.is_none_or(|best| index < best.primitive);
        if distance.is_finite() && (distance < self.radius || is_tie()) {
            self.radius = distance;
            self.found = Some(PointHit { point: nearest, distance, instance: 0, primitive: index });
        }
        ControlFlow::Continue(())
    }
}
