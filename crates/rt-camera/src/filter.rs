//! Reconstruction filters, sampled by importance.

use rt_math::{
    DVec2, Float64,
    transcendental::{exp, log, sincos},
};

use crate::{
    float_lanes::{FloatLanes, LANES},
    mitchell,
    simd::vectorize,
};

/// A Gaussian is cut at this many standard deviations.
const GAUSSIAN_CUT: f64 = 3.0;

/// Share of a two-dimensional normal distribution within [`GAUSSIAN_CUT`] standard deviations: 1 − exp(−9/2).
const GAUSSIAN_MASS: f64 = 0.9888910034617577;

/// Reconstruction filter of a pixel. Widths are in pixels.
///
/// Instead of splatting each sample over many pixels, samples are placed where the filter is large (Ernst, Stamminger,
/// Greiner 2006). Every pixel then owns its samples. Their mean, weighted by the sign of the filter, is the filtered
/// radiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// The pixel's own square.
    Box,
    /// A pyramid of total width 2: the product of two triangles.
    Tent,
    /// A round bell of standard deviation `sigma`, cut at the distance `3·sigma`.
    Gaussian {
        /// Standard deviation in pixels, positive.
        sigma: f64,
    },
    /// Mitchell and Netravali (1988) with B = C = 1/3 and total width 4; it has negative lobes.
    Mitchell,
}

impl Filter {
    /// Distance from the pixel's centre, in pixels, beyond which the filter is 0: along an axis, or in all
    /// directions for the Gaussian.
    pub fn radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian { sigma } => GAUSSIAN_CUT * sigma,
            Self::Mitchell => mitchell::RADIUS,
        }
    }

    /// True if it is negative somewhere. All samples of other filters have weight 1.
    pub const fn has_negative_lobes(self) -> bool {
        matches!(self, Self::Mitchell)
    }

    /// Value at an offset from the pixel's centre, in pixels; its integral over the plane is 1.
    pub fn value(self, offset: DVec2) -> f64 {
        match self {
            Self::Box => f64::from(offset.abs().max_element() <= 0.5),
            Self::Tent => (1.0 - offset.x.abs()).max(0.0) * (1.0 - offset.y.abs()).max(0.0),
            Self::Gaussian { sigma } => {
                let squared = offset.length_squared() / (sigma * sigma);
                if squared > GAUSSIAN_CUT * GAUSSIAN_CUT {
                    return 0.0;
                }
                exp(-0.5 * squared) / (core::f64::consts::TAU * sigma * sigma * GAUSSIAN_MASS)
            }
            Self::Mitchell => mitchell::value(offset.x) * mitchell::value(offset.y),
        }
    }

    /// Maps a point of `[0, 1)²` to an offset from the pixel's centre, in pixels, with density proportional to the
    /// filter's absolute value. Also returns the weight of a sample there: 1, or for filters with negative lobes ±(∫|f|
    /// / ∫f). The mean weight is 1.
    #[inline]
    pub fn sample(self, u: [f64; 2]) -> (DVec2, f64) {
        match self {
            Self::Box => (DVec2::from_array(u) - 0.5, 1.0),
            Self::Tent => (DVec2::from_array(u.map(sample_triangle)), 1.0),
            Self::Gaussian { sigma } => (DVec2::from_array(sample_gaussian(sigma, u)), 1.0),
            Self::Mitchell => {
                let ([x, x_weight], [y, y_weight]) = (mitchell::sample(u[0]), mitchell::sample(u[1]));
                (DVec2::new(x, y), x_weight * y_weight)
            }
        }
    }

    /// Version of [`sample`](Self::sample) for many points of the unit square, which become offsets, with the same bits. Appends the
    /// weights.
    pub fn sample_all(self, points: &mut [[f64; 2]], weights: &mut Vec<f64>) {
        if let Self::Gaussian { sigma } = self
            && points.len() >= LANES / 2
        {
            weights.resize(weights.len() + points.len(), 1.0);
            vectorize(
                #[inline(always)]
                || {
                    for points in points.chunks_mut(LANES) {
                        let mut lanes = [FloatLanes([0.0; LANES]); 2];
                        for (lane, point) in points.iter().enumerate() {
                            (lanes[0].0[lane], lanes[1].0[lane]) = (point[0], point[1]);
                        }
                        let [x, y] = sample_gaussian(sigma, lanes);
                        for ((point, x), y) in points.iter_mut().zip(x.0).zip(y.0) {
                            *point = [x, y];
                        }
                    }
                },
            );
            return;
        }
        for point in points {
            let (offset, weight) = self.sample(*point);
            *point = offset.to_array();
            weights.push(weight);
        }
    }
}

/// The radius of a two-dimensional normal distribution has a closed inverse (Box and Muller 1958).
#[inline(always)]
fn sample_gaussian<R: Float64>(sigma: f64, [u, v]: [R; 2]) -> [R; 2] {
    let radius = (log(-(u * GAUSSIAN_MASS - 1.0)) * -2.0).sqrt() * sigma;
    let (sin, cos) = sincos(v * core::f64::consts::TAU);
    [cos * radius, sin * radius]
}

/// Inverts the cumulative distribution of `1 − |x|` on [−1, 1].
fn sample_triangle(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 * (1.0 - u)).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::random::{hash, mix, unit};

    const FILTERS: [Filter; 5] =
        [Filter::Box, Filter::Tent, Filter::Gaussian { sigma: 0.5 }, Filter::Gaussian { sigma: 2.0 }, Filter::Mitchell];

    #[test]
    fn many_samples_have_the_bits_of_single_ones() {
        for filter in FILTERS {
            for count in [0, 1, 3, 4, 8, 21] {
                let number = |index, dimension| unit(hash(&[index, dimension]));
                let mut points: Vec<[f64; 2]> = (0..count).map(|index| [number(index, 0), number(index, 1)]).collect();
                points.iter_mut().take(1).for_each(|point| *point = [0.0; 2]);
                let single: Vec<_> = points.iter().map(|point| filter.sample(*point)).collect();
                let mut weights = vec![7.0];
                filter.sample_all(&mut points, &mut weights);
                assert_eq!(weights.len(), points.len() + 1);
                for ((point, weight), (offset, of_single)) in points.iter().zip(&weights[1..]).zip(single) {
                    assert_eq!(point.map(f64::to_bits), offset.to_array().map(f64::to_bits), "{filter:?}");
                    assert_eq!(*weight, of_single);
                }
            }
        }
    }

    /// Integral over a square by the midpoint rule.
    fn integrate(f: impl Fn(DVec2) -> f64, corner: DVec2, side: f64, steps: u32) -> f64 {
        let step = side / f64::from(steps);
        let at = |i: u32, j: u32| corner + (DVec2::new(f64::from(i), f64::from(j)) + 0.5) * step;
        (0..steps).flat_map(|j| (0..steps).map(move |i| (i, j))).map(|(i, j)| f(at(i, j))).sum::<f64>() * step * step
    }

    /// Mean of `weight · f(offset)` over a fine regular grid of the unit square.
    fn sampled_mean(filter: Filter, f: impl Fn(DVec2) -> f64) -> f64 {
        let weighted = |u: DVec2| {
            let (offset, weight) = filter.sample(u.to_array());
            weight * f(offset)
        };
        // 2 · 367 steps, so that no step straddles the border of a lobe of the Mitchell filter.
        integrate(weighted, DVec2::ZERO, 1.0, 734)
    }

    #[test]
    fn values_integrate_to_one_and_vanish_beyond_the_radius() {
        for filter in FILTERS {
            let radius = filter.radius();
            let integral = integrate(|p| filter.value(p), DVec2::splat(-radius), 2.0 * radius, 800);
            assert!((integral - 1.0).abs() < 2e-4, "{filter:?}: {integral}");
            assert_eq!(filter.value(DVec2::X * radius * 1.001), 0.0);
            assert_eq!(filter.value(DVec2::NEG_Y * radius * 1.001), 0.0);
        }
    }

    #[test]
    fn constants_are_preserved() {
        for filter in FILTERS {
            let mean = sampled_mean(filter, |_| 1.0);
            assert!((mean - 1.0).abs() < 1e-10, "{filter:?}: {mean}");
        }
    }

    #[test]
    fn weighted_samples_integrate_against_the_filter() {
        let image = |p: DVec2| (1.0 + p.y) * (1.0 - p.x * p.x) + p.x * p.x * p.y * p.y;
        for filter in FILTERS {
            let radius = filter.radius();
            let exact = integrate(|p| filter.value(p) * image(p), DVec2::splat(-radius), 2.0 * radius, 1000);
            let mean = sampled_mean(filter, image);
            assert!((mean - exact).abs() < 1e-3 * (1.0 + exact.abs()), "{filter:?}: {mean} instead of {exact}");
        }
    }

    #[test]
    fn samples_have_the_density_of_the_filter() {
        let (bins, draws) = (12u32, 100_000u32);
        for filter in FILTERS {
            let radius = filter.radius();
            let side = 2.0 * radius / f64::from(bins);
            let mut counts = vec![0.0; (bins * bins) as usize];
            for index in 0..draws {
                let bits = hash(&[u64::from(index)]);
                let (offset, weight) = filter.sample([unit(bits), unit(mix(bits))]);
                assert!(weight * filter.value(offset) >= 0.0, "{filter:?} at {offset}");
                let [column, row] = ((offset + radius) / side).to_array().map(|x| (x as u32).min(bins - 1));
                counts[(row * bins + column) as usize] += 1.0;
            }
            let mass = |bin: u32| {
                let corner = DVec2::new(f64::from(bin % bins), f64::from(bin / bins)) * side - radius;
                integrate(|p| filter.value(p).abs(), corner, side, 60)
            };
            let masses: Vec<_> = (0..bins * bins).map(mass).collect();
            let total: f64 = masses.iter().sum();
            let expected = masses.iter().map(|mass| mass / total * f64::from(draws));
            let terms: Vec<_> =
                expected.zip(counts).filter(|(e, _)| *e > 8.0).map(|(e, c)| (c - e) * (c - e) / e).collect();
            let freedom = terms.len() as f64;
            let chi2: f64 = terms.iter().sum();
            let limit = 5.0 * (2.0 * freedom).sqrt();
            assert!((chi2 - freedom).abs() < limit, "{filter:?}: chi² = {chi2} with {freedom} bins");
        }
    }

    #[test]
    fn offsets_stay_within_the_radius() {
        let below_one = 1.0 - f64::EPSILON / 2.0;
        for filter in FILTERS {
            for u in [0.0, 1e-300, 0.25, 0.5, 0.75, below_one] {
                assert!(filter.has_negative_lobes() || filter.sample([u; 2]).1 == 1.0, "{filter:?}");
                for v in [0.0, 0.5, below_one] {
                    let (offset, weight) = filter.sample([u, v]);
                    assert!(
                        offset.abs().max_element() <= filter.radius() * (1.0 + 1e-12),
                        "{filter:?} {u} {v}: {offset}"
                    );
                    assert!(weight.is_finite());
                }
            }
        }
    }

    #[test]
    fn the_mass_of_the_gaussian_is_that_of_the_formula() {
        assert_eq!(GAUSSIAN_MASS, 1.0 - exp(-0.5 * GAUSSIAN_CUT * GAUSSIAN_CUT));
    }

    #[test]
    fn known_offsets() {
        assert_eq!(Filter::Box.sample([0.25, 0.5]), (DVec2::new(-0.25, 0.0), 1.0));
        assert_eq!(Filter::Tent.sample([0.125, 0.875]), (DVec2::new(-0.5, 0.5), 1.0));
        let (median, _) = Filter::Gaussian { sigma: 1.0 }.sample([0.5, 0.0]);
        // The radius that holds half of the truncated mass.
        assert!((1.0 - exp(-0.5 * median.x * median.x) - 0.5 * GAUSSIAN_MASS).abs() < 1e-15);
        assert!(Filter::Mitchell.sample([0.5, 0.5]).0.length() < 1e-15);
    }
}
