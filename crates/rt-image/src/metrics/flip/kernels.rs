//! Filters of ꟻLIP: contrast sensitivity of the eye, edge and point detectors.

use core::f64::consts::PI;

use rt_math::transcendental::exp;

use crate::metrics::plane::Plane;

/// Contrast sensitivity of the eye as sums of Gaussians `a · √(π/b) · exp(−π² x² / b)` over x in degrees (Johnson and
/// Fairchild 2003). Pairs (a, b) are for the achromatic, red–green and yellow–blue components.
const SENSITIVITIES: [&[[f64; 2]]; 3] = [&[[1.0, 0.0047]], &[[1.0, 0.0053]], &[[34.1, 0.04], [13.5, 0.025]]];
/// The greatest `b`.
const WIDEST: f64 = 0.04;
/// Width in degrees of the features that are detected: two standard deviations.
const FEATURE_WIDTH: f64 = 0.082;

/// Filters for a number of pixels per degree, all of one length.
#[derive(Clone, Debug)]
pub(super) struct Kernels {
    radius: u32,
    /// For each component its terms, as filters across and down.
    blurs: [Vec<[Vec<f64>; 2]>; 3],
    /// A Gaussian, and its first and second derivatives, with weights that sum to 1 and to −1.
    gaussian: Vec<f64>,
    edge: Vec<f64>,
    point: Vec<f64>,
}

impl Kernels {
    pub(super) fn new(pixels_per_degree: f64) -> Self {
        let sigma = 0.5 * FEATURE_WIDTH * pixels_per_degree;
        let feature_radius = (3.0 * sigma).ceil();
        let blur_radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil();
        let radius = feature_radius.max(blur_radius) as u32;
        // Each filter ends at its own radius, also where the longest one goes on.
        let taps = |end: f64, f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let offsets = -i64::from(radius)..=i64::from(radius);
            offsets.map(|x| x as f64).map(|x| if x.abs() <= end { f(x) } else { 0.0 }).collect()
        };
        let gaussian = |x: f64| exp(-x * x / (2.0 * sigma * sigma));
        Self {
            radius,
            blurs: SENSITIVITIES.map(|terms| {
                let gaussian = |b: f64| {
                    taps(blur_radius, &move |x| exp(-(PI * PI / b) * x * x / (pixels_per_degree * pixels_per_degree)))
                };
                blur(terms.iter().map(|&[a, b]| (a * (PI / b).sqrt(), gaussian(b))).collect())
            }),
            gaussian: balanced(taps(feature_radius, &gaussian)),
            edge: balanced(taps(feature_radius, &|x| -x * gaussian(x))),
            point: balanced(taps(feature_radius, &|x| (x * x / (sigma * sigma) - 1.0) * gaussian(x))),
        }
    }

    /// Radius of a filter in pixels.
    pub(super) const fn radius(&self) -> u32 {
        self.radius
    }

    /// Each component of opponent colours as the eye blurs it.
    pub(super) fn blurred(&self, opponent: &[Plane; 3]) -> [Plane; 3] {
        core::array::from_fn(|component| {
            let terms = self.blurs[component].iter().map(|[across, down]| opponent[component].filtered(across, down));
            terms.reduce(|sum, term| sum.combined(&term, |a, b| a + b)).unwrap_or_else(|| opponent[component].clone())
        })
    }

    /// Strength of the edge and of the point at each place of a plane of luminance.
    pub(super) fn features(&self, luminance: &Plane) -> Vec<[f64; 2]> {
        let strength = |derivative: &[f64]| {
            let across = luminance.filtered(derivative, &self.gaussian);
            let down = luminance.filtered(&self.gaussian, derivative);
            across.combined(&down, |x, y| (x * x + y * y).sqrt()).values
        };
        strength(&self.edge).into_iter().zip(strength(&self.point)).map(|(edge, point)| [edge, point]).collect()
    }
}

/// Filters across and down for a sum of Gaussians with these weights, which keeps constant planes.
fn blur(terms: Vec<(f64, Vec<f64>)>) -> Vec<[Vec<f64>; 2]> {
    let sum: f64 = terms.iter().map(|(weight, gaussian)| weight * squared(gaussian.iter().sum())).sum();
    let filters = terms.into_iter().map(|(weight, gaussian)| {
        let down = gaussian.iter().map(|value| weight / sum * value).collect();
        [gaussian, down]
    });
    filters.collect()
}

/// Scales the positive weights to sum to 1, and the negative ones to −1.
fn balanced(weights: Vec<f64>) -> Vec<f64> {
    let positive: f64 = weights.iter().map(|weight| weight.max(0.0)).sum();
    let negative: f64 = weights.iter().map(|weight| (-weight).max(0.0)).sum();
    weights
        .into_iter()
        .map(|weight| {
            if weight > 0.0 {
                weight / positive
            } else if weight < 0.0 {
                weight / negative
            } else {
                0.0
            }
        })
        .collect()
}

fn squared(x: f64) -> f64 {
    x * x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(kernels: &Kernels, value: impl Fn(i64, i64) -> f64) -> Plane {
        let radius = i64::from(kernels.radius());
        let side = -radius..=radius;
        let values = side.clone().flat_map(|y| side.clone().map(move |x| [x, y]));
        Plane { width: 2 * radius as usize + 1, values: values.map(|[x, y]| value(x, y)).collect() }
    }

    #[test]
    fn radii_are_those_of_the_paper() {
        // 3 √(0.04 / 2π²) · 67.02 = 9.05, and 3 · 0.041 · 67.02 = 8.24.
        let kernels = Kernels::new(crate::metrics::Flip::PIXELS_PER_DEGREE);
        assert_eq!(kernels.radius(), 10);
        assert_eq!((kernels.gaussian[0], kernels.edge[20], kernels.point[0]), (0.0, 0.0, 0.0));
        assert!(kernels.gaussian[1] > 0.0);
    }

    #[test]
    fn flat_planes_stay_flat_and_have_no_features() {
        for pixels_per_degree in [1.0, 25.0, 67.0, 150.0] {
            let kernels = Kernels::new(pixels_per_degree);
            let flat = plane(&kernels, |_, _| 0.75);
            for blurred in kernels.blurred(&[flat.clone(), flat.clone(), flat.clone()]) {
                assert!((blurred.values[0] - 0.75).abs() < 1e-14);
            }
            let [edge, point] = kernels.features(&flat)[0];
            assert!(edge < 1e-14 && point < 1e-14, "{edge} {point}");
        }
    }

    #[test]
    fn blurs_agree_with_the_sums_of_gaussians() {
        let ppd = 30.0;
        let kernels = Kernels::new(ppd);
        let dot = plane(&kernels, |x, y| if [x, y] == [2, 1] { 1.0 } else { 0.0 });
        let [.., blurred] = kernels.blurred(&[dot.clone(), dot.clone(), dot]);
        let value = |x: f64, y: f64| -> f64 {
            let squared = (x * x + y * y) / (ppd * ppd);
            let term = |a: f64, b: f64| a * (PI / b).sqrt() * exp(-PI * PI * squared / b);
            term(34.1, 0.04) + term(13.5, 0.025)
        };
        let side = -f64::from(kernels.radius()) as i32..=kernels.radius() as i32;
        let sum: f64 = side.clone().flat_map(|y| side.clone().map(move |x| value(x.into(), y.into()))).sum();
        assert!((blurred.values[0] - value(2.0, 1.0) / sum).abs() < 1e-15);
    }

    #[test]
    fn a_full_step_is_a_full_edge_and_no_point() {
        let kernels = Kernels::new(67.0);
        // The middle of the filter lies on the half that is lit, and has no weight.
        let step =
            |turned: bool| plane(&kernels, move |x, y| if (if turned { y } else { x }) >= 0 { 1.0 } else { 0.0 });
        for turned in [false, true] {
            let [edge, _] = kernels.features(&step(turned))[0];
            assert!((edge - 1.0).abs() < 1e-14, "{edge}");
        }
    }

    #[test]
    fn a_line_is_a_point_across_and_no_edge() {
        let kernels = Kernels::new(67.0);
        let line = plane(&kernels, |x, _| if x == 0 { 1.0 } else { 0.0 });
        let [edge, point] = kernels.features(&line)[0];
        assert!(edge < 1e-15 && point > 0.1, "{edge} {point}");
    }
}
