//! Media along a path, and absorption in them.

use crate::{
    InteriorList, Material, ShadingCounts, SurfaceHit,
    bsdf::Scattering,
    hit_context::MAX_NULL_INTERFACES,
    interior_list::{InteriorLists, ListRange, MediumInterface},
    medium::{Medium, absorb},
};
use rt_math::Rgb;

/// Media that a path is inside of.
#[derive(Clone, Debug, Default)]
pub(crate) struct MediumTracker {
    pub(crate) interior: InteriorList,
    /// Ray parameter where the current medium began.
    medium_start: f64,
    /// Consecutive null interfaces.
    null_interfaces: u32,
}

/// Media of a ray of a stream, as [`MediumTracker`] has them of a single path.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RayMedia {
    pub(crate) interior: ListRange,
    medium_start: f64,
    null_interfaces: u32,
}

impl RayMedia {
    /// A ray that starts in these media.
    #[inline(always)]
    pub(crate) const fn new(interior: ListRange) -> Self {
        Self { interior, medium_start: 0.0, null_interfaces: 0 }
    }
}

impl MediumTracker {
    /// Continues with a ray of a stream.
    #[inline(always)]
    pub(crate) fn resume(&mut self, lists: &InteriorLists, media: RayMedia) {
        lists.read(media.interior, &mut self.interior);
        (self.medium_start, self.null_interfaces) = (media.medium_start, media.null_interfaces);
    }

    /// Media for a stream.
    pub(crate) fn suspend(&self, lists: &mut InteriorLists) -> RayMedia {
        let Self { medium_start, null_interfaces, .. } = *self;
        RayMedia { interior: lists.push(&self.interior), medium_start, null_interfaces }
    }

    /// Starts a ray in these media.
    pub(crate) const fn new(interior: InteriorList) -> Self {
        Self { interior, medium_start: 0.0, null_interfaces: 0 }
    }

    /// The media of this ray, from a parameter on.
    pub(crate) fn at(&self, medium_start: f64) -> Self {
        Self { medium_start, ..self.clone() }
    }

    /// Media on the side of a surface to which light is reflected, or transmitted.
    pub(crate) fn side(&self, interface: Option<&MediumInterface>, kind: Scattering) -> InteriorList {
        let mut side = self.interior.clone();
        if let (Some(interface), Scattering::Transmission) = (interface, kind) {
            side.cross(interface);
        }
        side
    }

    /// Restarts with a camera ray in these media, and keeps its memory.
    pub(crate) fn restart(&mut self, camera_media: &InteriorList) {
        self.interior.clone_from(camera_media);
        self.start_ray();
    }

    /// Starts the next ray of the path.
    #[inline(always)]
    pub(crate) const fn start_ray(&mut self) {
        (self.medium_start, self.null_interfaces) = (0.0, 0);
    }

    /// True if each further null interface costs a bounce.
    pub(crate) const fn null_limit_exceeded(&self) -> bool {
        self.null_interfaces > MAX_NULL_INTERFACES
    }

    /// Number of bounces that null interfaces have cost since the last surface.
    pub(crate) const fn null_interface_bounces(&self) -> u32 {
        self.null_interfaces.saturating_sub(MAX_NULL_INTERFACES)
    }

    /// Applies the absorption of the medium before a surface, and returns it, per world unit. `length` is world units per unit of the ray
    /// parameter.
    pub(crate) fn absorb(
        &self,
        materials: &[Material],
        interface: Option<&MediumInterface>,
        t: f64,
        length: f64,
        light: &mut Rgb,
    ) -> Rgb {
        let Medium { absorption, .. } = interface.map_or_else(|| self.interior.medium(materials), |c| c.before);
        absorb(light, absorption, (t - self.medium_start) * length);
        absorption
    }

    /// True if the current medium absorbs.
    pub(crate) fn absorbs(&self, materials: &[Material]) -> bool {
        !self.interior.medium(materials).absorption.is_black()
    }

    /// Media on the near and the far side of a surface.
    pub(crate) fn media(&self, materials: &[Material], interface: Option<&MediumInterface>) -> [Medium; 2] {
        let around = || [self.interior.medium(materials); 2];
        interface.map_or_else(around, |interface| [interface.before, interface.after])
    }

    /// Passes a null interface, and applies the absorption of the medium before it if the next one
    /// absorbs differently. Returns true if it did.
    pub(crate) fn skip_interface(
        &mut self,
        interface: Option<&MediumInterface>,
        hit: &SurfaceHit,
        length: f64,
        light: &mut Rgb,
        counts: &mut ShadingCounts,
    ) -> bool {
        let mut is_dimmed = false;
        if let Some(interface) = interface {
            if interface.before.absorption != interface.after.absorption {
                is_dimmed = absorb(light, interface.before.absorption, (hit.t - self.medium_start) * length);
                self.medium_start = hit.t;
            }
            self.interior.cross(interface);
        } else {
            counts.interior_overflows += 1;
        }
        counts.null_interfaces += 1;
        self.null_interfaces += 1;
        is_dimmed
    }

    /// Continues in a scattered direction, through the surface if light is transmitted.
    pub(crate) fn scatter(&mut self, interface: Option<&MediumInterface>, kind: Scattering) {
        self.start_ray();
        if let (Some(interface), Scattering::Transmission) = (interface, kind) {
            self.interior.cross(interface);
        }
    }
}
