//! The full geometry of a hit, computed once, for the winner.

use rt_math::{DVec3, Ray, Transform, float::UNIT_ROUNDOFF};

/// What the consumer of a [`SurfaceInteraction`] will look at, so that the rest is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurfaceNeeds {
    /// Texture coordinates; left `[0, 0]` otherwise.
    pub uv: bool,
    /// Interpolated normals; the geometric normal otherwise.
    pub shading_normal: bool,
}

impl SurfaceNeeds {
    /// Everything.
    pub const ALL: Self = Self { uv: true, shading_normal: true };
}

/// The surface around a hit, in the space that the shape was asked in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceInteraction {
    /// The hit point, re-projected on the surface.
    pub point: DVec3,
    /// Bound on the absolute error of `point`, per axis.
    pub point_error: DVec3,
    /// Where shadow rays start: `point`, or for interpolated normals the point lifted to the surface that these
    /// normals suggest, so that flat triangles do not shadow themselves in bands (Hanika 2021).
    pub shadow_point: DVec3,
    /// Unit normal of the actual surface, on its front side: outside of closed shapes; for triangles the side from
    /// which the vertices run counter-clockwise.
    pub geometric_normal: DVec3,
    /// Unit normal to shade with, on the same side as `geometric_normal`.
    pub shading_normal: DVec3,
    /// Texture coordinates; `v` runs upwards.
    pub uv: [f64; 2],
}

impl SurfaceInteraction {
    /// The same surface seen from the target space of a transform. Normals are unit again; the error bound includes
    /// the rounding of the map.
    pub fn transformed(&self, target_from_source: &Transform) -> Self {
        let (point, point_error) = target_from_source.point_with_error(self.point, self.point_error);
        let shadow_point =
            if self.shadow_point == self.point { point } else { target_from_source.point(self.shadow_point) };
        let geometric_normal = target_from_source.normal(self.geometric_normal).normalize();
        let shading_normal = if self.shading_normal == self.geometric_normal {
            geometric_normal
        } else {
            target_from_source.normal(self.shading_normal).normalize()
        };
        Self { point, point_error, shadow_point, geometric_normal, shading_normal, uv: self.uv }
    }

    /// A ray that leaves the surface in `direction`: its origin is moved along the geometric normal, to the side of
    /// the direction, by the error bound of the hit point, so that it cannot meet the same surface again by rounding.
    ///
    /// Pharr, Jakob, Humphreys, PBR 4th ed., section 6.8.6.
    pub fn spawn_ray(&self, direction: DVec3, time: f64) -> Ray {
        Ray { origin: self.offset(self.point, direction), direction, time }
    }

    /// A shadow ray to `target`, which it reaches at `t = 1`.
    pub fn spawn_shadow_ray(&self, target: DVec3, time: f64) -> Ray {
        let origin = self.offset(self.shadow_point, target - self.shadow_point);
        Ray { origin, direction: target - origin, time }
    }

    /// A shadow ray in `direction`, to a light infinitely far away.
    pub fn spawn_shadow_ray_towards(&self, direction: DVec3, time: f64) -> Ray {
        Ray { origin: self.offset(self.shadow_point, direction), direction, time }
    }

    fn offset(&self, point: DVec3, direction: DVec3) -> DVec3 {
        let normal = self.geometric_normal;
        let distance = normal.abs().dot(self.point_error);
        let distance = if direction.dot(normal) < 0.0 { -distance } else { distance };
        let moved = point + normal * distance;
        // The addition rounds as well: one step further, away from the surface.
        let step = (moved - point).signum() * moved.abs() * (2.0 * UNIT_ROUNDOFF);
        moved + step
    }
}
