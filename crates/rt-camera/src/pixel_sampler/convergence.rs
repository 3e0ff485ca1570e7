//! Tests of how fast the error of a pixel's mean falls with the number of samples.

use super::*;
use rt_math::transcendental::{exp, log2};

/// A function on the unit square and its integral.
struct Integrand {
    name: &'static str,
    value: fn([f64; 2]) -> f64,
    integral: f64,
}

const OBLIQUE_EDGE: Integrand =
    Integrand { name: "oblique edge", value: |[x, y]| f64::from(y < 0.3 + 0.2 * x), integral: 0.4 };
const AXIS_EDGE: Integrand =
    Integrand { name: "axis edge", value: |[x, _]| f64::from(x < 1.0 / 3.0), integral: 1.0 / 3.0 };
const DISC: Integrand = Integrand {
    name: "quarter disc",
    value: |[x, y]| f64::from(x * x + y * y < 1.0),
    integral: core::f64::consts::FRAC_PI_4,
};
// (√π/2 · erf 1)².
const SMOOTH: Integrand =
    Integrand { name: "smooth", value: |[x, y]| exp(-x * x - y * y), integral: 0.557_746_285_351_034 };

/// Root mean square error of a pixel's mean, over many pixels and the two first pairs of coordinates.
fn rmse(pattern: SamplerKind, spp: u32, integrand: &Integrand) -> f64 {
    const PIXELS: u32 = 128;
    let sampler = PixelSampler::new(pattern, spp, 2);
    let squared_errors = (0..PIXELS).map(|pixel| {
        let mut sums = [0.0; 2];
        for index in 0..spp {
            let mut sample = sampler.sample([pixel, 3], index);
            sums[0] += (integrand.value)(sample.next_2d());
            sums[1] += (integrand.value)(sample.next_2d());
        }
        sums.map(|sum| sum / f64::from(spp) - integrand.integral).map(|error| error * error).iter().sum::<f64>()
    });
    (squared_errors.sum::<f64>() / f64::from(2 * PIXELS)).sqrt()
}

/// Slope of log RMSE over log N, by least squares.
fn slope(pattern: SamplerKind, integrand: &Integrand) -> f64 {
    let points = [16u32, 64, 256, 1024].map(|spp| [log2(f64::from(spp)), log2(rmse(pattern, spp, integrand))]);
    let mean = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / points.len() as f64);
    let covariance = |axis: usize| points.iter().map(|p| (p[0] - mean[0]) * (p[axis] - mean[axis])).sum::<f64>();
    covariance(1) / covariance(0)
}

/// Mitchell 1996 for edges, Owen 1997 for smooth integrands.
#[test]
fn errors_fall_at_the_rate_that_theory_gives() {
    use SamplerKind::{BlueNoise, Halton, Jittered, MultiJittered, Random, Sobol};
    for (pattern, integrand, expected) in [
        (Random, OBLIQUE_EDGE, -0.5),
        (Random, SMOOTH, -0.5),
        (Jittered, OBLIQUE_EDGE, -0.75),
        (Jittered, AXIS_EDGE, -0.75),
        (Jittered, DISC, -0.75),
        (Jittered, SMOOTH, -1.0),
        (MultiJittered, OBLIQUE_EDGE, -0.75),
        (MultiJittered, AXIS_EDGE, -1.0),
        (MultiJittered, DISC, -0.75),
        (MultiJittered, SMOOTH, -1.0),
        (Sobol, OBLIQUE_EDGE, -0.75),
        (Sobol, AXIS_EDGE, -1.0),
        (Sobol, DISC, -0.75),
        (Sobol, SMOOTH, -1.5),
        (Halton, OBLIQUE_EDGE, -0.75),
        (Halton, AXIS_EDGE, -1.0),
        (Halton, DISC, -0.75),
        (Halton, SMOOTH, -1.0),
        (BlueNoise, OBLIQUE_EDGE, -0.75),
        (BlueNoise, AXIS_EDGE, -1.0),
        (BlueNoise, DISC, -0.75),
        (BlueNoise, SMOOTH, -1.5),
    ] {
        let slope = slope(pattern, &integrand);
        assert!(
            (slope - expected).abs() < 0.15,
            "{pattern:?}, {}: slope {slope} instead of {expected}",
            integrand.name
        );
    }
}

#[test]
fn errors_have_the_size_that_others_measured() {
    for (pattern, integrand, expected) in [
        (SamplerKind::Random, OBLIQUE_EDGE, 0.0298),
        (SamplerKind::Jittered, OBLIQUE_EDGE, 0.00621),
        (SamplerKind::Sobol, OBLIQUE_EDGE, 0.00476),
        (SamplerKind::Random, SMOOTH, 0.0129),
        (SamplerKind::Jittered, SMOOTH, 9.0e-4),
        (SamplerKind::Sobol, SMOOTH, 8.6e-5),
    ] {
        let rmse = rmse(pattern, 256, &integrand);
        assert!((rmse / expected - 1.0).abs() < 0.2, "{pattern:?}, {}: {rmse} instead of {expected}", integrand.name);
    }
}

#[test]
fn half_jittering_never_sees_a_border_narrower_than_a_quarter_cell() {
    let sampler = PixelSampler::new(SamplerKind::HalfJittered, 16, 2);
    let positions = (0..100).flat_map(|x| (0..16).map(move |index| sampler.sample([x, 0], index).next_2d()));
    let smallest = positions.flatten().fold(1.0, f64::min);
    assert!((1.0 / 16.0..1.1 / 16.0).contains(&smallest), "{smallest}");
}
