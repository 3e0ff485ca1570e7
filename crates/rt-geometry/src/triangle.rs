//! Single triangles in `f64`.

use crate::area::{area_vector, unit_normal};
use crate::error::{ShapeError, check_coordinates};
use crate::{ShapeHit, ShearedRay, SurfaceInteraction, SurfaceNeeds};
use rt_math::float::{UNIT_ROUNDOFF, gamma};
use rt_math::{Aabb, DVec3, Interval, Ray};

/// A flat triangle; its front is the side from which the vertices run counter-clockwise.
///
/// Its texture coordinates are the barycentric weights of the second and third vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    vertices: [DVec3; 3],
}

impl Triangle {
    /// The triangle with these vertices.
    ///
    /// # Errors
    /// If it has no area or a number is not finite.
    pub fn new(vertices: [DVec3; 3]) -> Result<Self, ShapeError> {
        check_coordinates(vertices)?;
        if area_vector(vertices) == DVec3::ZERO { Err(ShapeError::NoArea(vertices)) } else { Ok(Self { vertices }) }
    }

    /// The vertices in order.
    pub const fn vertices(&self) -> [DVec3; 3] {
        self.vertices
    }

    /// The smallest box around the triangle.
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(self.vertices)
    }

    /// The hit within `span`, from either side; `None` on a miss, when seen exactly edge-on, and for rays without a
    /// direction. See [`ShearedRay`] for the test.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        ShearedRay::new(ray).intersect(self.vertices, span)
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, _ray: &Ray, hit: &ShapeHit, needs: SurfaceNeeds) -> SurfaceInteraction {
        let (point, point_error) = point_at(self.vertices, weights(hit.uv));
        let uv = if needs.uv { hit.uv } else { [0.0; 2] };
        SurfaceInteraction::flat(point, point_error, unit_normal(self.vertices), uv)
    }
}

/// All three barycentric weights, from those of the second and third vertex.
pub(crate) fn weights([v, w]: [f64; 2]) -> [f64; 3] {
    [1.0 - v - w, v, w]
}

/// The point with these barycentric weights, and the bound on its error per axis.
///
/// The first part bounds the rounding of the sum (PBR 4th ed., section 6.8.5). The second is for the test that a ray
/// spawned there undergoes: its shear mixes the axes, so its error is governed by the largest extent.
pub(crate) fn point_at(vertices: [DVec3; 3], weights: [f64; 3]) -> (DVec3, DVec3) {
    let [a, b, c] = [0, 1, 2].map(|i| vertices[i] * weights[i]);
    let extent = Aabb::from_points(vertices).extent().max_element();
    (a + b + c, (a.abs() + b.abs() + c.abs()) * gamma(7) + DVec3::splat(3.0 * UNIT_ROUNDOFF * extent))
}
