//! `sample` finds directions as often as `pdf` says: Pearson's test over cells of the sphere.

use super::{
    sphere::{CELLS, Sphere},
    *,
};

const SAMPLES: u64 = 40_000;
/// Cells with fewer expected samples are counted together.
const MIN_EXPECTED: f64 = 5.0;

/// The statistic of one test, as a number of standard deviations of a normal variable (Wilson, Hilferty 1931).
pub(super) struct Outcome {
    pub(super) z: f64,
    /// The integral of the density.
    pub(super) total: f64,
}

/// Counts the samples of `sample` in cells against the integrals of `pdf`. Samples that fail, and those of delta lobes,
/// are counted in one more cell, which holds the rest of the density.
pub(super) fn chi_square(
    sphere: &Sphere,
    seed: u64,
    pdf: impl Fn(DVec3) -> f64,
    sample: impl Fn([f64; 3]) -> Option<BsdfSample>,
) -> Outcome {
    // A part of a cell may be wrong by 0.4 of the samples.
    let integrals = sphere.integrals_within(1e-5, 1, pdf);
    let total: f64 = integrals.iter().sum();
    let mut counts = vec![0.0; CELLS];
    let mut rest = 0.0;
    for index in 0..SAMPLES {
        match sample(numbers(seed, index)) {
            Some(sample) if !sample.is_delta => counts[sphere.cell(sample.wi)] += 1.0,
            _ => rest += 1.0,
        }
    }
    let mut rest_expected = (1.0 - total).max(0.0) * SAMPLES as f64;
    let mut groups = Vec::new();
    for (observed, expected) in counts.into_iter().zip(integrals.into_iter().map(|part| part * SAMPLES as f64)) {
        if expected >= MIN_EXPECTED {
            groups.push((observed, expected));
        } else {
            rest += observed;
            rest_expected += expected;
        }
    }
    if rest_expected >= MIN_EXPECTED {
        groups.push((rest, rest_expected));
    } else if rest > 5.0 * MIN_EXPECTED {
        return Outcome { z: f64::INFINITY, total };
    }
    Outcome { z: deviation(&groups), total }
}

fn deviation(groups: &[(f64, f64)]) -> f64 {
    if groups.len() < 2 {
        return 0.0;
    }
    let statistic: f64 = groups.iter().map(|(o, e)| (o - e) * (o - e) / e).sum();
    let ninth = 2.0 / (9.0 * (groups.len() - 1) as f64);
    let freedom = (groups.len() - 1) as f64;
    (transcendental::cbrt(statistic / freedom) - (1.0 - ninth)) / ninth.sqrt()
}

/// Distance of a normal variable above its mean for one of `tests` to come there by chance with 1 % (Šidák 1967).
pub(super) fn threshold(tests: usize) -> f64 {
    let level = 1.0 - transcendental::pow(0.99, 1.0 / tests as f64);
    let (mut low, mut high) = (2.0, 10.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if upper_tail(middle) > level { low = middle } else { high = middle }
    }
    high
}

/// Probability that a normal variable is above `z` ≥ 2: Laplace's continued fraction.
fn upper_tail(z: f64) -> f64 {
    let fraction = (1..200).rev().fold(z, |below, k| z + f64::from(k) / below);
    transcendental::exp(-0.5 * z * z) / (core::f64::consts::TAU.sqrt() * fraction)
}

/// Index of refraction to put cells around.
pub(super) fn ior(bsdf: &Bsdf) -> f64 {
    match bsdf {
        Bsdf::Single(Bxdf::Dielectric(dielectric)) => dielectric.ior,
        _ => 1.5,
    }
}

#[test]
fn tails_of_the_normal_distribution() {
    for (z, expected) in [(2.0, 0.022_750_131_948), (3.0, 0.001_349_898_032), (5.0, 2.866_515_719e-7)] {
        assert!((upper_tail(z) / expected - 1.0).abs() < 1e-9, "{z}");
    }
    assert!((threshold(1) - 2.326_347_874).abs() < 1e-8);
}

#[test]
fn samples_follow_their_density() {
    let all = surfaces().into_iter().chain(leaning());
    let surfaces: Vec<Surface> = all.filter(|surface| !surface.bsdf.is_delta()).collect();
    let angles: Vec<f64> = ANGLES.into_iter().chain([89.9, 130.0, 175.0]).collect();
    let limit = threshold(surfaces.len() * angles.len());
    let mut failures = Vec::new();
    for (at, Surface { name, bsdf }) in surfaces.iter().enumerate() {
        for (step, &degrees) in angles.iter().enumerate() {
            let wo = at_angle(degrees, 0.4);
            let seed = (at * 100 + step) as u64;
            let sphere = Sphere::around(wo, ior(bsdf));
            let outcome = chi_square(&sphere, seed, |wi| bsdf.pdf(wo, wi), |u| bsdf.sample(wo, u));
            println!("{name} at {degrees}°, seed {seed}: z = {:.2}, ∫ pdf = {:.6}", outcome.z, outcome.total);
            if !(outcome.z < limit && outcome.total < 1.001) {
                failures.push(format!("{name} at {degrees}°, seed {seed}: z {:.2}, ∫ {:.6}", outcome.z, outcome.total));
            }
        }
    }
    assert!(failures.is_empty(), "beyond {limit:.2}: {failures:#?}");
}

#[test]
fn densities_integrate_to_what_can_be_sampled() {
    let total = |bsdf: Bsdf, degrees: f64| {
        let wo = at_angle(degrees, 0.0);
        Sphere::around(wo, ior(&bsdf)).integrals(|wi| bsdf.pdf(wo, wi)).iter().sum::<f64>()
    };
    for degrees in ANGLES {
        for diffuse in [Bsdf::from(Lambert { albedo: Rgb::WHITE }), eon(0.7).into()] {
            assert!((total(diffuse, degrees) - 1.0).abs() < 1e-4, "{degrees}°");
        }
    }
    // A lobe of Phong is whole along the normal; a half of it is above the surface at the horizon.
    for exponent in [0.0, 1.0, 30.0, 1000.0] {
        assert!((total(phong(exponent).into(), 0.0) - 1.0).abs() < 1e-4, "{exponent}");
        assert!((total(phong(exponent).into(), 90.0 - 1e-7) - 0.5).abs() < 1e-3, "{exponent}");
    }
    // The sum of the chances but for the mirror's.
    assert!((total(blend().into(), 0.0) - 0.9).abs() < 0.01);
}

/// Wrong densities and wrong samples, of which each must be found.
#[test]
fn broken_densities_and_samples_are_caught() {
    let wo = at_angle(60.0, 0.4);
    let sphere = Sphere::around(wo, 1.5);
    let limit = threshold(1);
    let [gold, highlight, glass, rough]: [Bsdf; 4] =
        [metal(0.5).into(), phong(50.0).into(), Dielectric::clear(1.5, 0.5).into(), eon(0.5).into()];
    let half = |wi: DVec3| (wo + wi).normalize();
    let wrong = [
        (
            "sampled a little rougher than the density",
            chi_square(&sphere, 1, |wi| gold.pdf(wo, wi), |u| metal(0.51).sample(wo, u)).z,
        ),
        (
            "without the Jacobian of reflection",
            chi_square(&sphere, 2, |wi| 4.0 * wo.dot(half(wi)) * gold.pdf(wo, wi), |u| gold.sample(wo, u)).z,
        ),
        (
            "a density of uniform hemispheres for cosines",
            chi_square(
                &sphere,
                3,
                |wi| if wi.z > 0.0 { 1.0 / core::f64::consts::TAU } else { 0.0 },
                |u| Lambert { albedo: Rgb::WHITE }.sample(wo, u),
            )
            .z,
        ),
        (
            "an azimuth that is not uniform",
            chi_square(&sphere, 4, |wi| highlight.pdf(wo, wi), |u| highlight.sample(wo, [u[0], u[1], u[2] * u[2]])).z,
        ),
        (
            "transmission as often as reflection",
            chi_square(&sphere, 5, |wi| glass.pdf(wo, wi), |u| glass.sample(wo, [u[0] * 0.5, u[1], u[2]])).z,
        ),
        ("too large by 3 %", chi_square(&sphere, 6, |wi| 1.03 * glass.pdf(wo, wi), |u| glass.sample(wo, u)).z),
        ("a failed sample now and then", {
            let sample = |u: [f64; 3]| rough.sample(wo, u).filter(|_| u[0] > 0.002);
            chi_square(&sphere, 7, |wi| rough.pdf(wo, wi), sample).z
        }),
    ];
    for (what, z) in wrong {
        println!("{what}: z = {z:.1}");
        assert!(z > limit, "{what}: z = {z:.2} is not beyond {limit:.2}");
    }
}
