//! A surface from the side of its viewer.

use crate::{
    bsdf::{BsdfSample, Scattering},
    optics,
};
use rt_geometry::SurfaceInteraction;
use rt_math::{DVec3, Frame};

/// Least cosine between the viewer and the shading normal that a BSDF gets.
///
/// A normal that was turned is perpendicular to the view up to rounding, of which the sign is noise. The square of this
/// cosine is below the rounding of 1, so that the direction with the raised cosine is still a unit vector.
pub(crate) const MIN_COSINE: f64 = 1e-8;

/// Surface at a hit, relative to the ray.
pub(crate) struct ViewedSurface<'s> {
    /// The surface, to start rays from. Its shading normal is the one that is shaded with.
    pub(crate) surface: &'s SurfaceInteraction,
    /// True if it is seen from behind its geometric normal: from the inside of a closed shape.
    pub(crate) is_inside: bool,
    /// Unit direction of the ray.
    pub(crate) direction: DVec3,
    /// Unit shading normal on the viewer's side of the surface.
    pub(crate) normal: DVec3,
    /// Unit geometric normal that faces the origin of the ray.
    geometric_normal: DVec3,
}

impl<'s> ViewedSurface<'s> {
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

    /// Shading coordinates, of which z is the shading normal on the outside, and the unit direction to the viewer in them.
    ///
    /// The geometric normal gives the side of the viewer: the sign of the cosine follows [`is_inside`](Self::is_inside).
    /// From this sign, BSDFs derive reflection, transmission, and the relative index of refraction.
    #[inline]
    pub(crate) fn shading_coordinates(&self) -> (Frame, DVec3) {
        let frame = Frame::from_z(self.surface.shading_normal);
        let mut wo = frame.to_local(-self.direction);
        let side = if self.is_inside { -1.0 } else { 1.0 };
        if wo.z * side < MIN_COSINE {
            wo.z = MIN_COSINE * side;
        }
        (frame, wo)
    }

    /// True if the direction is on the side of the geometric surface that light of this kind leaves to.
    #[inline]
    pub(crate) fn is_on_side_of(&self, kind: Scattering, wi: DVec3) -> bool {
        wi.dot(self.side_of(kind)) > 0.0
    }

    /// Direction of the next ray of a camera path, for a BSDF sample `wi` (world space).
    ///
    /// `None` if an interpolated normal has sent it to the wrong side of the actual surface. With `keeps_single`, the one
    /// direction of a specular BSDF is kept on its side, as [`mirrored`](Self::mirrored) and [`refracted`](Self::refracted) keep it.
    #[inline]
    pub(crate) fn continued(&self, sample: &BsdfSample, wi: DVec3, keeps_single: bool) -> Option<DVec3> {
        if self.is_on_side_of(sample.kind, wi) {
            return Some(wi);
        }
        (sample.is_delta && keeps_single).then(|| Self::kept_on_the_side_of(self.side_of(sample.kind), wi))
    }

    /// Unit geometric normal of the side that light of this kind leaves to.
    #[inline(always)]
    fn side_of(&self, kind: Scattering) -> DVec3 {
        match kind {
            Scattering::Reflection => self.geometric_normal,
            Scattering::Transmission => -self.geometric_normal,
        }
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
/// Near silhouettes an interpolated normal may face away. It is turned until it is perpendicular to the view, and no
/// further, so that shading does not jump there. `None` if it points straight away.
#[inline]
fn turned_to(wo: DVec3, normal: DVec3) -> Option<DVec3> {
    let facing = normal.dot(wo);
    if facing >= 0.0 { Some(normal) } else { (normal - wo * facing).try_normalize() }
}
