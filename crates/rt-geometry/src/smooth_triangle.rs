//! Interpolated normals of triangles, also for lanes.

use crate::triangle::weights;
use rt_math::{Real, Vector3};

/// Point of a triangle with interpolated normals, for one number or for lanes.
#[derive(Clone, Copy, Debug)]
pub struct SmoothPoint<R: Real> {
    /// Unit, on the same side as the geometric normal.
    pub normal: Vector3<R>,
    /// The point lifted towards the smooth surface, for shadow rays.
    pub shadow_point: Vector3<R>,
    /// True if the normal was flipped: normals of a file may point to the back.
    pub is_turned: R::Mask,
    /// False where the normals of the vertices cancel. All other fields are then not valid.
    pub is_valid: R::Mask,
}

/// Interpolated normal and lifted point, given a point with its geometric normal, and the vertices with their normals. Barycentric
/// coordinates are those of the second and third vertex; `direction` is that of the ray.
///
/// The point is the mean of the projections of the hit point on the tangent planes of the vertices, on the side of the ray.
/// Source: Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021.
#[inline(always)]
pub fn smooth_point<R: Real>(
    (point, geometric_normal): (Vector3<R>, Vector3<R>),
    corners: [Vector3<R>; 3],
    normals: [Vector3<R>; 3],
    uv: [R; 2],
    direction: Vector3<R>,
) -> SmoothPoint<R> {
    let (weights, zero, one) = (weights(uv), uv[0].splat(0.0), uv[0].splat(1.0));
    let sum = normals[0] * weights[0] + normals[1] * weights[1] + normals[2] * weights[2];
    let (normal, is_valid) = sum.try_normalize();
    let is_turned = normal.dot(geometric_normal).lt(zero);
    let front = R::select(is_turned, -one, one);
    let viewer = R::select(direction.dot(geometric_normal).gt(zero), -front, front);
    let mut lift = Vector3::new(zero, zero, zero);
    let ([a, b, c], [d, e, f], [u, v, w]) = (corners, normals, weights);
    for (corner, normal, weight) in [(a, d, u), (b, e, v), (c, f, w)] {
        let normal = normal * viewer;
        lift = lift + normal * (weight * (corner - point).dot(normal).max(zero));
    }
    let shadow_point = point + lift;
    SmoothPoint { normal: normal * front, shadow_point, is_turned, is_valid }
}
