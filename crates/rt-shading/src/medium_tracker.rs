//! The way that a path takes through transparent bodies.

use crate::{
    Interior, Material, ShadingCounts, SurfaceHit,
    bsdf::Scattering,
    hit_context::MAX_NULL_INTERFACES,
    interior::{Medium, MediumInterface, absorb},
};
use rt_math::Rgb;

/// What a path is inside of, and since when.
#[derive(Clone, Debug, Default)]
pub(crate) struct MediumTracker {
    pub(crate) interior: Interior,
    /// Where on its ray the medium began.
    medium_start: f64,
    /// Surfaces passed in a row that did nothing to it.
    passages: u32,
}

impl MediumTracker {
    /// Back in air, at the start.
    pub(crate) fn reset(&mut self) {
        self.interior.clear();
        (self.medium_start, self.passages) = (0.0, 0);
    }

    /// True if so many surfaces were passed that each further one costs a bounce.
    pub(crate) const fn null_limit_exceeded(&self) -> bool {
        self.passages > MAX_NULL_INTERFACES
    }

    /// Takes off what the medium before a surface that is seen has absorbed, `length` world units being one of the parameter.
    pub(crate) fn absorb(
        &self,
        materials: &[Material],
        interface: Option<&MediumInterface>,
        t: f64,
        length: f64,
        light: &mut Rgb,
    ) {
        let medium = interface.map_or_else(|| self.interior.medium(materials), |c| c.before);
        absorb(light, medium.absorption, (t - self.medium_start) * length);
    }

    /// Media on the near and on the far side of a surface.
    pub(crate) fn media(&self, materials: &[Material], interface: Option<&MediumInterface>) -> [Medium; 2] {
        let around = || [self.interior.medium(materials); 2];
        interface.map_or_else(around, |interface| [interface.before, interface.after])
    }

    /// Goes through a surface that does nothing to the ray, and takes off what the medium before it has absorbed if the next one
    /// absorbs otherwise. Whether anything was taken.
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
        counts.passages += 1;
        self.passages += 1;
        is_dimmed
    }

    /// Goes on in another direction, through the surface if light is transmitted.
    pub(crate) fn scatter(&mut self, interface: Option<&MediumInterface>, kind: Scattering) {
        (self.medium_start, self.passages) = (0.0, 0);
        if let (Some(interface), Scattering::Transmission) = (interface, kind) {
            self.interior.cross(interface);
        }
    }
}
