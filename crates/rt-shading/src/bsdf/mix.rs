//! Weighted sums of lobes.

use super::{BsdfSample, Bxdf, Lambert, side::Side};
use rt_math::{DVec3, Rgb};

/// Maximum number of lobes of a [`Mix`].
pub const MAX_LOBES: usize = 4;

/// Error of [`Mix::new`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MixError {
    /// Too many lobes, or none.
    #[error("a mix has 1 to {MAX_LOBES} lobes, not {0}")]
    Count(usize),
    /// A weight that is negative or not finite.
    #[error("the weight of a lobe must be at least 0 and finite, not {0}")]
    Weight(f64),
}

/// A weighted sum of lobes: f = Σ weight · f of each.
///
/// Weights that sum to 1 blend surfaces. Weights of 1 add lobes, whose albedos must then sum to 1 at most. A sample chooses
/// one lobe in proportion to its approximate albedo. Its density is that of all lobes, by the balance heuristic (Veach 1997,
/// 9.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix {
    lobes: [(f64, Bxdf); MAX_LOBES],
    /// Sampling probability of each lobe.
    probabilities: [f64; MAX_LOBES],
    count: usize,
}

impl Mix {
    /// Weighted sum of `lobes`.
    pub fn new(lobes: &[(f64, Bxdf)]) -> Result<Self, MixError> {
        if lobes.is_empty() || lobes.len() > MAX_LOBES {
            return Err(MixError::Count(lobes.len()));
        }
        if let Some(&(weight, _)) = lobes.iter().find(|(weight, _)| !(*weight >= 0.0 && weight.is_finite())) {
            return Err(MixError::Weight(weight));
        }
        let mut mix = Self {
            lobes: [(0.0, Bxdf::Lambert(Lambert { albedo: Rgb::BLACK })); MAX_LOBES],
            probabilities: [0.0; MAX_LOBES],
            count: lobes.len(),
        };
        mix.lobes[..lobes.len()].copy_from_slice(lobes);
        let strength = |&(weight, lobe): &(f64, Bxdf)| (weight * lobe.strength()).max(0.0);
        let sum: f64 = lobes.iter().map(strength).sum();
        if sum > 0.0 {
            for (probability, lobe) in mix.probabilities.iter_mut().zip(lobes) {
                *probability = strength(lobe) / sum;
            }
        }
        Ok(mix)
    }

    /// Lobes with their weights.
    pub fn lobes(&self) -> &[(f64, Bxdf)] {
        &self.lobes[..self.count]
    }

    /// Sampling probability of each lobe.
    pub(super) fn probabilities(&self) -> &[f64] {
        &self.probabilities[..self.count]
    }

    /// Mix of the lobes that are not diffuse; `None` if there are none.
    pub fn without_diffuse(&self) -> Option<Self> {
        let mut kept = self.lobes;
        let mut count = 0;
        for lobe in self.lobes().iter().filter(|(_, lobe)| !lobe.is_diffuse()) {
            kept[count] = *lobe;
            count += 1;
        }
        Self::new(&kept[..count]).ok()
    }

    /// Implements [`super::Bsdf::eval_with_pdf`].
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        self.lobes().iter().zip(self.probabilities).fold(
            (Rgb::BLACK, 0.0),
            |(value, pdf), ((weight, lobe), probability)| {
                let (lobe_value, lobe_pdf) = lobe.eval_with_pdf(wo, wi);
                (value + lobe_value * *weight, pdf + probability * lobe_pdf)
            },
        )
    }

    /// Implements [`super::Bsdf::sample`].
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        Side::of(wo, u)?;
        let (index, within) = self.choose(u[0])?;
        let ((weight, lobe), probability) = (self.lobes[index], self.probabilities[index]);
        let sample = lobe.sample(wo, [within, u[1], u[2]])?;
        let (value, pdf) = if sample.is_delta {
            (sample.value * weight, sample.pdf * probability)
        } else {
            self.eval_with_pdf(wo, sample.wi)
        };
        BsdfSample { value, pdf, ..sample }.if_finite()
    }

    /// Index of the lobe that `u` chooses, and `u` remapped to \[0, 1\] within it.
    fn choose(&self, u: f64) -> Option<(usize, f64)> {
        let mut below = 0.0;
        let mut last = None;
        for (index, &probability) in
            self.probabilities.iter().enumerate().filter(|(_, probability)| **probability > 0.0)
        {
            let within = ((u - below) / probability).max(0.0);
            if within < 1.0 {
                return Some((index, within));
            }
            // Rounding may make the sum of the probabilities less than 1.
            last = Some((index, within.min(1.0)));
            below += probability;
        }
        last
    }
}
