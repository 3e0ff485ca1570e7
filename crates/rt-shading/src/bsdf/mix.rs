//! Several models at once.

use super::{BsdfSample, Bxdf, Lambert, side::Side};
use rt_math::{DVec3, Rgb};

/// The greatest number of lobes of a [`Mix`].
pub const MAX_LOBES: usize = 4;

/// Why a [`Mix`] was refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MixError {
    /// Too many lobes, or none.
    #[error("a mix has 1 to {MAX_LOBES} lobes, not {0}")]
    Count(usize),
    /// A weight that is negative or not finite.
    #[error("the weight of a lobe must be at least 0 and finite, not {0}")]
    Weight(f64),
}

/// A weighted sum of models: f = Σ weight · f of each.
///
/// Weights that sum to 1 blend surfaces, and weights of 1 lay lobes over each other: then it is for their colours to leave
/// no more than 1 in sum. A sample chooses one lobe, about by how much light it scatters, and its density is that of all
/// lobes together, as multiple importance sampling by the balance heuristic (Veach 1997, 9.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix {
    lobes: [(f64, Bxdf); MAX_LOBES],
    /// How often each lobe is chosen.
    chances: [f64; MAX_LOBES],
    count: usize,
}

impl Mix {
    /// The sum of `lobes`, each with its weight.
    pub fn new(lobes: &[(f64, Bxdf)]) -> Result<Self, MixError> {
        if lobes.is_empty() || lobes.len() > MAX_LOBES {
            return Err(MixError::Count(lobes.len()));
        }
        if let Some(&(weight, _)) = lobes.iter().find(|(weight, _)| !(*weight >= 0.0 && weight.is_finite())) {
            return Err(MixError::Weight(weight));
        }
        let mut mix = Self {
            lobes: [(0.0, Bxdf::Lambert(Lambert { albedo: Rgb::BLACK })); MAX_LOBES],
            chances: [0.0; MAX_LOBES],
            count: lobes.len(),
        };
        mix.lobes[..lobes.len()].copy_from_slice(lobes);
        let strength = |&(weight, lobe): &(f64, Bxdf)| (weight * lobe.strength()).max(0.0);
        let sum: f64 = lobes.iter().map(strength).sum();
        if sum > 0.0 {
            for (chance, lobe) in mix.chances.iter_mut().zip(lobes) {
                *chance = strength(lobe) / sum;
            }
        }
        Ok(mix)
    }

    /// The lobes with their weights.
    pub fn lobes(&self) -> &[(f64, Bxdf)] {
        &self.lobes[..self.count]
    }

    /// The mix of the lobes that are not diffuse; `None` if there are none.
    pub fn without_diffuse(&self) -> Option<Self> {
        let mut kept = self.lobes;
        let mut count = 0;
        for lobe in self.lobes().iter().filter(|(_, lobe)| !lobe.is_diffuse()) {
            kept[count] = *lobe;
            count += 1;
        }
        Self::new(&kept[..count]).ok()
    }

    /// As [`super::Bsdf::eval`].
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.lobes().iter().fold(Rgb::BLACK, |sum, (weight, lobe)| sum + lobe.eval(wo, wi) * *weight)
    }

    /// As [`super::Bsdf::pdf`].
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.lobes().iter().zip(self.chances).map(|((_, lobe), chance)| chance * lobe.pdf(wo, wi)).sum()
    }

    /// As [`super::Bsdf::eval_with_pdf`].
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        self.lobes().iter().zip(self.chances).fold((Rgb::BLACK, 0.0), |(value, pdf), ((weight, lobe), chance)| {
            let (lobe_value, lobe_pdf) = lobe.eval_with_pdf(wo, wi);
            (value + lobe_value * *weight, pdf + chance * lobe_pdf)
        })
    }

    /// As [`super::Bsdf::sample`].
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        Side::of(wo, u)?;
        let (index, within) = self.choose(u[0])?;
        let ((weight, lobe), chance) = (self.lobes[index], self.chances[index]);
        let sample = lobe.sample(wo, [within, u[1], u[2]])?;
        let (value, pdf) = if sample.is_delta {
            (sample.value * weight, sample.pdf * chance)
        } else {
            self.eval_with_pdf(wo, sample.wi)
        };
        BsdfSample { value, pdf, ..sample }.if_finite()
    }

    /// The lobe that `u` chooses, and where in the range of that lobe it lies, in \[0, 1\].
    fn choose(&self, u: f64) -> Option<(usize, f64)> {
        let mut below = 0.0;
        let mut last = None;
        for (index, &chance) in self.chances.iter().enumerate().filter(|(_, chance)| **chance > 0.0) {
            let within = ((u - below) / chance).max(0.0);
            if within < 1.0 {
                return Some((index, within));
            }
            // Rounding may leave the sum of the chances below 1.
            last = Some((index, within.min(1.0)));
            below += chance;
        }
        last
    }
}
