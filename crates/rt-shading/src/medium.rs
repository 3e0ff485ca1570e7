//! Clear media: index of refraction and absorption.

use rt_math::{Rgb, transcendental::exp};

/// Optical properties of a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Medium {
    /// Index of refraction.
    pub(crate) ior: f64,
    /// Absorption per world unit.
    pub(crate) absorption: Rgb,
}

impl Medium {
    pub(crate) const AIR: Self = Self { ior: 1.0, absorption: Rgb::BLACK };

    /// Transmittance over a distance in world units, possibly infinite (Beer's law).
    pub(crate) fn transmittance(&self, distance: f64) -> Rgb {
        // 0 · ∞ is not a number.
        self.absorption.map(|per_unit| if per_unit == 0.0 { 1.0 } else { exp(-per_unit * distance) })
    }
}

/// Applies Beer's law over a distance in world units. Returns true if the medium absorbs.
pub(crate) fn absorb(weight: &mut Rgb, absorption: Rgb, distance: f64) -> bool {
    if absorption.is_black() {
        return false;
    }
    *weight *= absorption.map(|per_unit| exp(-per_unit * distance));
    true
}

/// Transmittance of a medium that fills the whole way to a light. The end of the medium towards a light at infinity is unknown: such
/// light is not attenuated.
pub(crate) fn transmittance_to_light(absorption: Rgb, distance: f64) -> Rgb {
    if absorption.is_black() || !distance.is_finite() {
        return Rgb::WHITE;
    }
    Medium { absorption, ..Medium::AIR }.transmittance(distance)
}

/// Medium behind the surface of a dielectric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InteriorMedium {
    /// Index of refraction, positive; that of air is 1.
    pub ior: f64,
    /// Absorption per world unit (Beer's law): light falls by exp(−absorption · length).
    pub absorption: Rgb,
    /// Rank among overlapping dielectrics: the highest counts, among equals the one entered last.
    ///
    /// Glass has a higher priority than the liquid that reaches into its wall.
    pub priority: i32,
}

impl InteriorMedium {
    /// A medium that does not absorb, with priority 0.
    pub const fn clear(ior: f64) -> Self {
        Self { ior, absorption: Rgb::BLACK, priority: 0 }
    }

    /// True if it has the properties of air.
    pub fn is_air(&self) -> bool {
        self.ior == 1.0 && self.absorption.is_black()
    }
}
