//! Context of a ray-surface hit: material, side and the media on both sides.

use crate::{
    Material, Needs, SurfaceHit,
    interior_list::{InteriorList, MediumEntry, MediumInterface},
    viewed_surface::is_inside,
};
use rt_math::{DVec3, Ray};

/// Number of consecutive null interfaces that a ray may pass; each further one costs a bounce,
/// so that paths end.
pub(crate) const MAX_NULL_INTERFACES: u32 = 1024;

/// A hit of a ray with the properties of its material.
pub(crate) struct HitContext<'m> {
    pub(crate) material: &'m Material,
    /// Unit direction of the ray.
    pub(crate) direction: DVec3,
    /// World units per unit of the ray's parameter.
    pub(crate) length: f64,
    /// True if the ray comes from behind the surface.
    pub(crate) is_inside: bool,
    transmission: SurfaceTransmission,
}

/// Transmission through a surface.
#[derive(Clone, Copy, PartialEq)]
enum SurfaceTransmission {
    /// No light is transmitted, or the plan leaves refraction out.
    None,
    /// Thin dielectric: the same medium on both sides.
    Thin,
    Solid,
}

impl<'m> HitContext<'m> {
    /// Context of a hit; `None` if the surface has no material.
    #[inline]
    pub(crate) fn new(needs: &Needs, materials: &'m [Material], ray: &Ray, hit: &SurfaceHit) -> Option<Self> {
        let material = materials.get(hit.material as usize)?;
        let length = ray.direction.length();
        let direction = ray.direction / length;
        Some(Self::of(needs, material, (direction, length), is_inside(direction, &hit.interaction)))
    }

    /// Context of a hit on a material by a ray of this unit direction and length.
    #[inline]
    pub(crate) fn of(
        needs: &Needs,
        material: &'m Material,
        (direction, length): (DVec3, f64),
        is_inside: bool,
    ) -> Self {
        let transmission = if !needs.refraction {
            SurfaceTransmission::None
        } else if material.interior.is_some() {
            SurfaceTransmission::Solid
        } else if material.model.is_transmissive() {
            SurfaceTransmission::Thin
        } else {
            SurfaceTransmission::None
        };
        Self { material, direction, length, is_inside, transmission }
    }

    /// Media on both sides of the surface, given the interior list of the ray. `None` where scattered light
    /// stays on its side, and for a solid if the list is full. Call it once per hit: a solid that is left without having been
    /// entered is noted.
    #[inline]
    pub(crate) fn interface(
        &self,
        interior: &mut InteriorList,
        materials: &[Material],
        body: MediumEntry,
    ) -> Option<MediumInterface> {
        match self.transmission {
            SurfaceTransmission::None => None,
            SurfaceTransmission::Thin => Some(interior.thin_interface(materials)),
            SurfaceTransmission::Solid => interior.interface(materials, body, self.is_inside),
        }
    }

    /// False if the surface does not change the ray, so that only the [`interface`](Self::interface) is crossed.
    #[inline]
    pub(crate) fn is_visible(&self, interface: Option<&MediumInterface>) -> bool {
        let is_clear = |interface: &MediumInterface| interface.is_null() && self.material.is_clear();
        self.transmission != SurfaceTransmission::Solid
            || interface.is_some_and(|interface| interface.is_boundary && !is_clear(interface))
    }
}
