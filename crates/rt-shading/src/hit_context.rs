//! Context of a ray-surface hit: material, side and the media on both sides.

use crate::{
    Material, ShadingFeatures, SurfaceHit,
    interior_list::{InteriorList, MediumEntry, MediumInterface},
    viewed_surface::is_inside,
};
use rt_math::{DVec3, Ray};

/// Number of consecutive null interfaces that a ray may pass; each further one costs a bounce,
/// so that paths end.
pub const MAX_NULL_INTERFACES: u32 = 1024;

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

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SurfaceTransmission {
    /// No light is transmitted, or the plan leaves refraction out.
    None,
    /// Thin dielectric: the same medium on both sides.
    Thin,
    Solid,
}

impl SurfaceTransmission {
    /// Transmission through surfaces of a material.
    #[inline]
    pub(crate) fn of(features: &ShadingFeatures, material: &Material) -> Self {
        if !features.refraction {
            Self::None
        } else if material.interior.is_some() {
            Self::Solid
        } else if material.model.is_transmissive() {
            Self::Thin
        } else {
            Self::None
        }
    }

    /// Version of [`HitContext::interface`] for a hit of a ray that comes from behind the surface if it `is_inside`.
    #[inline]
    pub(crate) fn interface(
        self,
        interior: &mut InteriorList,
        materials: &[Material],
        entry: MediumEntry,
        is_inside: bool,
    ) -> Option<MediumInterface> {
        match self {
            Self::None => None,
            Self::Thin => Some(interior.thin_interface(materials)),
            Self::Solid => interior.interface(materials, entry, is_inside),
        }
    }

    /// Version of [`HitContext::is_visible`] for a surface of this material.
    #[inline]
    pub(crate) fn is_visible(self, material: &Material, interface: Option<&MediumInterface>) -> bool {
        let is_clear = |interface: &MediumInterface| interface.is_null() && material.is_clear();
        match self {
            Self::None => true,
            Self::Thin => !material.is_air(),
            Self::Solid => interface.is_some_and(|interface| interface.is_boundary && !is_clear(interface)),
        }
    }
}

impl<'m> HitContext<'m> {
    /// Context of a hit; `None` if the surface has no material.
    #[inline]
    pub(crate) fn new(
        features: &ShadingFeatures,
        materials: &'m [Material],
        ray: &Ray,
        hit: &SurfaceHit,
    ) -> Option<Self> {
        let material = materials.get(hit.material as usize)?;
        let length = ray.direction.length();
        let direction = ray.direction / length;
        let is_inside = is_inside(direction, &hit.interaction);
        Some(Self { material, direction, length, is_inside, transmission: SurfaceTransmission::of(features, material) })
    }

    /// True if light passes the surface.
    pub(crate) fn transmits_light(&self) -> bool {
        self.transmission != SurfaceTransmission::None
    }

    /// True if shadow rays pass the surface although it is visible. They do not pass a bubble in glass, which
    /// [`ShadowMedia`](crate::shadow_media::ShadowMedia) finds.
    pub(crate) fn is_passed_by_shadow_rays(&self, hit: &SurfaceHit) -> bool {
        !hit.casts_shadow && !self.material.passes_shadow_rays()
    }

    /// Media on both sides of the surface, given the interior list of the ray. `None` where scattered light
    /// stays on its side, and for a solid if the list is full. Call it once per hit: a solid that is left without having been
    /// entered is noted.
    #[inline]
    pub(crate) fn interface(
        &self,
        interior: &mut InteriorList,
        materials: &[Material],
        entry: MediumEntry,
    ) -> Option<MediumInterface> {
        self.transmission.interface(interior, materials, entry, self.is_inside)
    }

    /// False if the surface does not change the ray, so that only the [`interface`](Self::interface) is crossed.
    #[inline]
    pub(crate) fn is_visible(&self, interface: Option<&MediumInterface>) -> bool {
        self.transmission.is_visible(self.material, interface)
    }
}
