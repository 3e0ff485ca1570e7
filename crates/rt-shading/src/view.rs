//! A surface from the side of its viewer.

use rt_geometry::SurfaceInteraction;
use rt_math::DVec3;

use crate::optics;

/// A surface as the ray that met it sees it.
pub(crate) struct View<'s> {
    /// The surface, to start rays from. Its shading normal is the one that is shaded with.
    pub(crate) surface: &'s SurfaceInteraction,
    /// True if it is seen from behind its geometric normal: from the inside of a closed shape.
    pub(crate) is_inside: bool,
    /// Unit direction of the ray.
    pub(crate) direction: DVec3,
    /// Unit shading normal, turned to the viewer's side of the surface.
    pub(crate) normal: DVec3,
    /// Unit geometric normal, turned against the ray.
    geometric_normal: DVec3,
}

impl<'s> View<'s> {
    /// The surface as seen along a unit direction, from the `inside` or not ([`is_inside`]).
    #[inline]
    pub(crate) fn new(direction: DVec3, inside: bool, surface: &'s mut SurfaceInteraction) -> Self {
        let side = if inside { -1.0 } else { 1.0 };
        let geometric_normal = surface.geometric_normal * side;
        let normal = turned_to(-direction, surface.shading_normal * side).unwrap_or(geometric_normal);
        // Shadow rays take their side from the normal that is shaded with.
        surface.shading_normal = normal * side;
        Self { surface, is_inside: inside, direction, normal, geometric_normal }
    }

    /// The mirrored direction, on the viewer's side of the surface.
    #[inline(always)]
    pub(crate) fn mirrored(&self) -> DVec3 {
        Self::kept_on_the_side_of(self.geometric_normal, optics::reflect(self.direction, self.normal))
    }

    /// The refracted direction, on the far side of the surface; `None` on total internal reflection. For `eta` see
    /// [`optics::refract`].
    #[inline(always)]
    pub(crate) fn refracted(&self, eta: f64) -> Option<DVec3> {
        let refracted = optics::refract(self.direction, self.normal, eta)?;
        Some(Self::kept_on_the_side_of(-self.geometric_normal, refracted))
    }

    /// The direction, mirrored at the actual surface where an interpolated normal sends it through to the wrong side.
    #[inline(always)]
    fn kept_on_the_side_of(normal: DVec3, direction: DVec3) -> DVec3 {
        if direction.dot(normal) < 0.0 { optics::reflect(direction, normal) } else { direction }
    }
}

/// True if a ray comes from behind the surface: from the inside of a closed shape.
#[inline]
pub(crate) fn is_inside(direction: DVec3, surface: &SurfaceInteraction) -> bool {
    direction.dot(surface.geometric_normal) > 0.0
}

/// The unit normal itself if it faces the viewer, who is in the unit direction `wo`.
///
/// Near silhouettes an interpolated normal may face away. It is bent until it is perpendicular to the view, and no
/// further, so that shading does not jump there. `None` if it points straight away.
#[inline]
fn turned_to(wo: DVec3, normal: DVec3) -> Option<DVec3> {
    let facing = normal.dot(wo);
    if facing >= 0.0 { Some(normal) } else { (normal - wo * facing).try_normalize() }
}
