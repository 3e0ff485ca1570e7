//! Lobes of which a BSDF is composed.

use crate::{
    ColorTexture,
    bsdf::{Bsdf, Bxdf, Lambert, MAX_LOBES, Mix},
};
use rt_math::Rgb;

/// Lobe of a surface that scatters no light.
pub(crate) const BLACK: Bxdf = Bxdf::Lambert(Lambert { albedo: Rgb::BLACK });

/// Weighted lobes of a BSDF.
pub(crate) struct LobeList {
    lobes: [(f64, Bxdf); MAX_LOBES],
    count: usize,
}

impl Default for LobeList {
    fn default() -> Self {
        Self { lobes: [(0.0, BLACK); MAX_LOBES], count: 0 }
    }
}

impl LobeList {
    /// Adds a lobe, unless its coefficient is zero everywhere.
    pub(crate) fn push_scaled(&mut self, lobe: Bxdf, coefficient: &ColorTexture) {
        if !coefficient.is_zero() {
            self.push(lobe);
        }
    }

    pub(crate) fn push(&mut self, lobe: Bxdf) {
        self.push_weighted(1.0, lobe);
    }

    /// Adds a lobe. Those beyond [`MAX_LOBES`] are left out; loaders refuse such materials.
    pub(crate) fn push_weighted(&mut self, weight: f64, lobe: Bxdf) {
        if let Some(slot) = self.lobes.get_mut(self.count) {
            *slot = (weight, lobe);
            self.count += 1;
        }
    }

    pub(crate) fn push_all(&mut self, weight: f64, bsdf: &Bsdf) {
        match bsdf {
            Bsdf::Single(lobe) => self.push_weighted(weight, *lobe),
            Bsdf::Mix(mix) => mix.lobes().iter().for_each(|(within, lobe)| self.push_weighted(weight * within, *lobe)),
            // A mix contains no layered surface, which has lobes of its own.
            Bsdf::Layered(_) => {}
        }
    }

    pub(crate) fn into_bsdf(self) -> Bsdf {
        match &self.lobes[..self.count] {
            [] => Bsdf::Single(BLACK),
            [(1.0, lobe)] => Bsdf::Single(*lobe),
            lobes => Mix::new(lobes).map_or(Bsdf::Single(BLACK), Bsdf::Mix),
        }
    }
}
