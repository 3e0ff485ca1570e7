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
        let normal = turned_to(-direction, surface.shading_normal * side).unwrap_or(geometric_normal);
        // Shadow rays take their side from the normal that is shaded with.
        let surface = SurfaceInteraction { shading_normal: normal * side, ..*surface };
        Self { surface, direction, normal, geometric_normal, inside }
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

/// The unit normal itself if it faces the viewer, who is in the unit direction `wo`.
///
/// Near silhouettes an interpolated normal may face away. It is bent until it is perpendicular to the view, and no
/// further, so that shading does not jump there. `None` if it points straight away.
fn turned_to(wo: DVec3, normal: DVec3) -> Option<DVec3> {
    let facing = normal.dot(wo);
    if facing >= 0.0 { Some(normal) } else { (normal - wo * facing).try_normalize() }
}
