//! Clamping of indirect light: less noise, but biased.

use crate::ShadingCounts;
use rt_math::Rgb;

/// Bound on a contribution of indirect light to a pixel.
///
/// Light is *indirect* if two or more surfaces have scattered it on its path to the camera. Direct light is exempt, whether sampled by
/// the light or by the BSDF. A contribution whose largest component exceeds the bound is scaled so that this component equals it,
/// which keeps the hue. Rare bright paths (fireflies) lose most; the mean of a pixel loses light, and the image is biased.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clamp {
    /// Largest component of a contribution, in units of radiance; infinite for none.
    max: f64,
}

impl Clamp {
    /// No bound.
    pub const NONE: Self = Self { max: f64::INFINITY };

    /// Bound in units of radiance; `None` unless it is finite and above 0.
    pub fn new(max: f64) -> Option<Self> {
        (max.is_finite() && max > 0.0).then_some(Self { max })
    }

    /// Bound in units of radiance; `None` if there is none.
    pub fn bound(self) -> Option<f64> {
        self.is_set().then_some(self.max)
    }

    /// True if contributions of paths that this many surfaces have scattered are bounded.
    #[inline(always)]
    pub(crate) fn applies_after(self, scattered: u32) -> bool {
        self.is_set() && scattered >= 2
    }

    /// Contribution of a path that this many surfaces have scattered, within the bound if there is one for it.
    #[inline(always)]
    pub(crate) fn apply(self, scattered: u32, contribution: Rgb, counts: &mut ShadingCounts) -> Rgb {
        if self.applies_after(scattered) { self.bounded(contribution, counts) } else { contribution }
    }

    #[inline(always)]
    fn is_set(self) -> bool {
        self.max < f64::INFINITY
    }

    /// Contribution within the bound. Non-finite contributions are unchanged.
    #[inline(never)]
    pub(super) fn bounded(self, contribution: Rgb, counts: &mut ShadingCounts) -> Rgb {
        let largest = contribution.max_component();
        if !(largest > self.max && largest < f64::INFINITY) {
            return contribution;
        }
        counts.clamped += 1;
        let bounded = contribution * (self.max / largest);
        let lost = contribution - bounded;
        let in_units = (lost.r + lost.g + lost.b) / 3.0 / self.unit();
        counts.clamped_units = counts.clamped_units.saturating_add(in_units as u64);
        bounded
    }

    /// Unit of sums of lost light: integer sums do not depend on the order. A tiny bound has no tiny unit, because sums would
    /// exceed 64 bits.
    const fn unit(self) -> f64 {
        self.max.max(1e-3) / 65536.0
    }

    /// Total radiance, mean of channels, that clamping has removed.
    pub fn lost(self, counts: &ShadingCounts) -> f64 {
        if self.is_set() { counts.clamped_units as f64 * self.unit() } else { 0.0 }
    }
}

impl Default for Clamp {
    fn default() -> Self {
        Self::NONE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_component_is_bounded_and_the_hue_kept() {
        let mut counts = ShadingCounts::default();
        let clamp = Clamp::new(2.0).expect("positive");
        assert_eq!(clamp.bounded(Rgb::new(8.0, 4.0, 0.0), &mut counts), Rgb::new(2.0, 1.0, 0.0));
        assert_eq!(clamp.bounded(Rgb::new(2.0, 1.0, 0.5), &mut counts), Rgb::new(2.0, 1.0, 0.5));
        assert_eq!((counts.clamped, clamp.lost(&counts)), (1, 3.0));
        assert!(clamp.bounded(Rgb::gray(f64::INFINITY), &mut counts).r.is_infinite(), "bad samples are told elsewhere");
        assert_eq!(counts.clamped, 1);
    }

    #[test]
    fn lost_light_of_a_tiny_bound_is_not_lost_in_the_sum() {
        let (mut counts, clamp) = (ShadingCounts::default(), Clamp::new(1e-300).expect("positive"));
        for _ in 0..1000 {
            clamp.bounded(Rgb::gray(3.0), &mut counts);
        }
        let lost = clamp.lost(&counts);
        assert!((lost / 3000.0 - 1.0).abs() < 1e-6, "{lost}");
    }

    #[test]
    fn only_light_of_two_surfaces_or_more_is_indirect() {
        let clamp = Clamp::new(1.0).expect("positive");
        assert_eq!([0, 1, 2, 9].map(|scattered| clamp.applies_after(scattered)), [false, false, true, true]);
        assert_eq!([0, 1, 2, 9].map(|scattered| Clamp::NONE.applies_after(scattered)), [false; 4]);
    }

    #[test]
    fn bounds_are_positive_numbers() {
        assert_eq!([0.0, -1.0, f64::NAN, f64::INFINITY].map(Clamp::new), [None; 4]);
        assert_eq!((Clamp::NONE.bound(), Clamp::new(3.0).and_then(Clamp::bound)), (None, Some(3.0)));
    }
}
