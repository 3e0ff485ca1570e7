//! Which of many lights to sample.

use super::bounds::importance_of;
use super::distribution::{accumulate, find, probability};
use rt_math::Rgb;

/// A light that was chosen, and how likely that was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Its place in the list of lights.
    pub index: u32,
    /// The probability of this choice, greater than 0.
    pub probability: f64,
}

/// Choice in proportion to power, the same for all points: cheap, and good where all lights reach everything.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerChoice {
    sums: Vec<f64>,
}

impl PowerChoice {
    /// The choice among lights of these powers. Those without power are never chosen.
    pub fn new(powers: impl IntoIterator<Item = Rgb>) -> Self {
        let mut sums: Vec<f64> = powers.into_iter().map(importance_of).collect();
        // Sums of the greatest powers overflow.
        let greatest = sums.iter().fold(1.0f64, |a, &b| a.max(b));
        sums.iter_mut().for_each(|power| *power /= greatest);
        accumulate(&mut sums);
        Self { sums }
    }

    /// The light that belongs to `u` in `[0, 1)`. `None` if no light has power.
    pub fn choose(&self, u: f64) -> Option<Choice> {
        let (index, _) = find(&self.sums, u)?;
        Some(Choice { index: u32::try_from(index).ok()?, probability: probability(&self.sums, index) })
    }

    /// The probability with which a light is chosen; 0 for one that is not there.
    pub fn probability(&self, index: u32) -> f64 {
        probability(&self.sums, index as usize)
    }
}
