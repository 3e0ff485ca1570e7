//! Queries at a point: the nearest surface, and inside or outside.

use core::ops::ControlFlow;

use glam::DVec3;
use rt_geometry::{Hit, MAX_COORDINATE, is_on_triangle};
use rt_math::{Aabb, Interval, Ray};

use super::geometry::{Blas, Geometry};
use super::instances::Instances;
use super::placed_points::{distance_to_box, nearest_of};
use super::ray_queries::Scene;
use super::triangle_mesh::TriangleMesh;
use crate::ray_query::abort_without_memory;
use crate::region::Region as _;
use crate::{Accelerator, PointHit, RegionQuery, SphereRegion, WideBvh};

/// Directions that are tried for a point whose ray passes through an edge. One is enough for all but constructed points.
const N_DIRECTIONS: u32 = 16;

/// Most instances whose nearest points are computed one by one: the traversal of the tree takes a microsecond to start.
const N_NEAREST: u32 = 8;

/// Most instances whose bounds are tested one by one for a point inside, which takes hundredths of that each.
const N_CONTAINING: u32 = 64;

/// Largest barycentric weight that counts as a hit on an edge: rounding of one minus two others stays far below.
const EDGE_WEIGHT: f64 = 1e-15;

impl Scene<'_> {
    /// The point of a surface nearest to `point`, within `radius`, inclusive and possibly infinite. Of equally near
    /// instances the first counts. `None` without one, and for a coordinate that is NaN or of a magnitude above
    /// [`MAX_COORDINATE`].
    ///
    /// Transforms may move instances farther away than that: the distance is finite and right to rounding of their
    /// coordinates. Distances below 10⁻¹⁵⁴ may be 0. An instance beyond the range of numbers has no nearest point.
    pub fn nearest_point(&self, point: DVec3, radius: f64) -> Option<PointHit> {
        // Squared distances beyond overflow.
        if !point.abs().cmple(DVec3::splat(MAX_COORDINATE)).all() {
            return None;
        }
        let instances = self.top_level();
        let mut query = NearestInstance { instances, point, radius, found: None };
        let _ = self.traverse_instances(&mut query, N_NEAREST);
        query.found
    }

    /// True if the point lies inside an instance or on its surface.
    ///
    /// A point is inside a mesh if a ray from it crosses the surface an odd number of times. So the triangles need no
    /// common orientation. The mesh has to be closed. Crossings, and points on the surface, are decided exactly: a ray
    /// through an edge or a vertex is replaced by one in another direction. False for NaN.
    pub fn contains(&self, point: DVec3) -> bool {
        let instances = self.top_level();
        let test = |index| {
            instances.get(index).is_some_and(|(instance, geometry)| {
                let transform = instance.world_from_local.as_ref();
                let local = transform.map_or(point, |transform| transform.inverse_point(point));
                match &geometry.geometry {
                    _ if !instance.bounds.padded().contains(point) => false,
                    Geometry::Mesh(mesh) => is_on_surface(geometry, mesh, local) || mesh_contains(geometry, local),
                    Geometry::Spheres(spheres) => any_around(geometry.tree(), local, |index| {
                        let sphere = spheres.as_slice().get(index as usize);
                        sphere.is_some_and(|sphere| local.distance(sphere.centre()) <= sphere.radius())
                    }),
                }
            })
        };
        self.traverse_instances(&mut Around { point, test }, N_CONTAINING).is_break()
    }

    /// Passes instances to the query, one by one or, if there are more than `n_listed`, by the tree.
    fn traverse_instances<Q: RegionQuery>(&self, query: &mut Q, n_listed: u32) -> ControlFlow<()> {
        let n = self.instances.len() as u32;
        if n <= n_listed {
            (0..n).try_for_each(|index| query.test_primitive(index, |_| true))
        } else {
            self.tree.bvh.traverse_region(query)
        }
    }

    /// Distance from the nearest surface: negative inside, as by [`contains`](Self::contains), and 0 on it. `None` in an empty scene,
    /// and where [`nearest_point`](Self::nearest_point) has none.
    pub fn signed_distance(&self, point: DVec3) -> Option<f64> {
        let distance = self.nearest_point(point, f64::INFINITY)?.distance;
        Some(if distance > 0.0 && self.contains(point) { -distance } else { distance })
    }
}

/// True if `test` is true for a primitive whose bounds contain the point, up to rounding.
fn any_around(tree: &WideBvh, point: DVec3, test: impl FnMut(u32) -> bool) -> bool {
    tree.traverse_region(&mut Around { point, test }).is_break()
}

/// Primitives whose bounds contain a point, up to rounding. It ends with the first for which `test` is true.
struct Around<F> {
    point: DVec3,
    test: F,
}

impl<F: FnMut(u32) -> bool> RegionQuery for Around<F> {
    fn bounds(&self) -> Aabb {
        Aabb::new(self.point, self.point).padded()
    }

    fn query_point(&self) -> DVec3 {
        self.point
    }

    fn distance_to(&self, aabb: &Aabb) -> Option<f64> {
        aabb.padded().contains(self.point).then_some(0.0)
    }

    fn test_primitive(&mut self, index: u32, _: impl FnOnce(DVec3) -> bool) -> ControlFlow<()> {
        if (self.test)(index) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

fn is_on_surface(geometry: &Blas<'_>, mesh: &TriangleMesh<'_>, point: DVec3) -> bool {
    let mut found = false;
    geometry.tree().visit_overlapping(mesh, &Aabb::new(point, point), |index| {
        found = mesh.triangle(index).is_some_and(|triangle| is_on_triangle(triangle, point));
        if found { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    found
}

fn mesh_contains(geometry: &Blas<'_>, point: DVec3) -> bool {
    let mut hits = Vec::new();
    let mut is_inside = false;
    for attempt in 0..N_DIRECTIONS {
        let ray = Ray::new(point, direction(attempt));
        let found = geometry.try_all_hits(&ray, Interval::FORWARD, &mut hits);
        found.unwrap_or_else(|_| abort_without_memory());
        is_inside = hits.len() % 2 == 1;
        if !hits.iter().any(is_on_edge) {
            break;
        }
    }
    is_inside
}

/// True if the hit may lie on an edge, where it is reported once for each triangle.
fn is_on_edge(hit: &Hit) -> bool {
    let [v, w] = hit.uv;
    v.min(w).min(1.0 - v - w) <= EDGE_WEIGHT
}

/// Directions that are unlikely to be parallel to an edge or face: a spiral of points on the sphere by the golden
/// ratio.
fn direction(attempt: u32) -> DVec3 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let fraction = (f64::from(attempt) + 0.5) * GOLDEN;
    let fraction = fraction - fraction.floor();
    DVec3::new(0.137 + 0.573 * fraction, 0.291 - 0.734 * fraction, 1.0 - 0.377 * f64::from(attempt))
}

/// The nearest point of all instances.
struct NearestInstance<'s, 'a> {
    instances: Instances<'s, 'a>,
    point: DVec3,
    /// The radius, later the smallest distance. Inclusive: an equally near instance must still be found.
    radius: f64,
    found: Option<PointHit>,
}

impl RegionQuery for NearestInstance<'_, '_> {
    fn bounds(&self) -> Aabb {
        SphereRegion { centre: self.point, radius: self.radius.next_up() }.bounds()
    }

    fn query_point(&self) -> DVec3 {
        self.point
    }

    fn distance_to(&self, aabb: &Aabb) -> Option<f64> {
        let distance = distance_to_box(aabb, self.point);
        (distance <= self.radius).then_some(distance)
    }

    fn test_primitive(&mut self, index: u32, _: impl FnOnce(DVec3) -> bool) -> ControlFlow<()> {
        let Some((instance, geometry)) = self.instances.get(index) else { return ControlFlow::Continue(()) };
        if self.distance_to(&instance.bounds).is_some()
            && let Some(hit) = nearest_of(geometry, instance, self.point, self.radius)
            && (hit.distance < self.radius || self.found.is_none_or(|best| instance.id < best.instance))
        {
            self.radius = hit.distance;
            self.found = Some(PointHit { instance: instance.id, ..hit });
        }
        ControlFlow::Continue(())
    }
}
