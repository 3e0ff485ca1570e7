//! A surface from the side of its viewer.

use rt_geometry::SurfaceInteraction;
use rt_math::DVec3;

use crate::optics;

/// A surface as the ray that met it sees it.
pub(super) struct View {
    /// The surface, to start rays from.
    pub(super) surface: SurfaceInteraction,
    /// Unit direction of the ray.
    pub(super) direction: DVec3,
    /// Unit shading normal, turned to the viewer's side of the surface.
    pub(super) normal: DVec3,
    /// Unit geometric normal, turned against the ray.
    geometric_normal: DVec3,
    /// The ray comes from behind the surface: from the inside of a closed shape.
    pub(super) inside: bool,
}

impl View {
    pub(super) fn new(direction: DVec3, surface: &SurfaceInteraction) -> Self {
        let inside = direction.dot(surface.geometric_normal) > 0.0;
        let side = if inside { -1.0 } else { 1.0 };
        let geometric_normal = surface.geometric_normal * side;
        let normal = surface.shading_normal * side;
        if normal.dot(direction) < 0.0 {
            return Self { surface: *surface, direction, normal, geometric_normal, inside };
        }
        // Near silhouettes an interpolated normal may face away from the viewer: the surface is flat then, also for
        // the rays that leave it.
        let flat =
            SurfaceInteraction { shading_normal: surface.geometric_normal, shadow_point: surface.point, ..*surface };
        Self { surface: flat, direction, normal: geometric_normal, geometric_normal, inside }
    }

    /// The mirrored direction, on the viewer's side of the surface.
    pub(super) fn mirrored(&self) -> DVec3 {
        Self::kept_on_the_side_of(self.geometric_normal, optics::reflect(self.direction, self.normal))
    }

    /// The refracted direction, on the far side of the surface; `None` on total internal reflection. For `eta` see
    /// [`optics::refract`].
    pub(super) fn refracted(&self, eta: f64) -> Option<DVec3> {
        let refracted = optics::refract(self.direction, self.normal, eta)?;
        Some(Self::kept_on_the_side_of(-self.geometric_normal, refracted))
    }

    /// The direction, mirrored at the actual surface where an interpolated normal sends it through to the wrong side.
    fn kept_on_the_side_of(normal: DVec3, direction: DVec3) -> DVec3 {
        if direction.dot(normal) < 0.0 { optics::reflect(direction, normal) } else { direction }
    }
}
