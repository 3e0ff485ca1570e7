//! White furnace: the radiance is 1 from all directions (n² in a medium of index n). No surface may be brighter, and one that
//! absorbs nothing is equally bright.

use super::*;

const SAMPLES: u64 = 20_000;

/// Mean and standard error of what a surface reflects and transmits of the furnace's light.
struct Brightness {
    mean: f64,
    error: f64,
    /// The largest of all samples.
    max: f64,
}

/// The green channel, of light whose radiance was divided by n².
pub(super) fn energy(sample: &BsdfSample) -> f64 {
    sample.weight().g * sample.eta * sample.eta
}

fn brightness(bsdf: &Bsdf, wo: DVec3, seed: u64) -> Brightness {
    let (mut sum, mut squares, mut max) = (0.0, 0.0, 0.0f64);
    for index in 0..SAMPLES {
        let x = bsdf.sample(wo, numbers(seed, index)).map_or(0.0, |sample| energy(&sample));
        sum += x;
        squares += x * x;
        max = max.max(x);
    }
    let n = SAMPLES as f64;
    let mean = sum / n;
    // Rounding of a mean is no noise.
    let variance = (squares / n - mean * mean).max(0.0);
    Brightness { mean, error: (variance / n).sqrt() + 1e-12, max }
}

/// Surfaces that absorb nothing. White metal whose facets are smooth is one.
fn keeps_all(bsdf: &Bsdf) -> bool {
    match bsdf {
        Bsdf::Single(Bxdf::Dielectric(dielectric)) => dielectric.is_smooth(),
        Bsdf::Single(lobe) => {
            matches!(lobe, Bxdf::Lambert(_) | Bxdf::OrenNayar(_) | Bxdf::Mirror(_) | Bxdf::ThinGlass(_))
        }
        Bsdf::Mix(_) | Bsdf::Layered(_) => false,
    }
}

#[test]
fn no_surface_is_brighter_than_the_furnace() {
    for (at, Surface { name, bsdf }) in surfaces().iter().enumerate() {
        if disperses(bsdf) {
            continue;
        }
        for (step, degrees) in ANGLES.into_iter().chain([130.0]).enumerate() {
            let seed = 7000 + (at * 100 + step) as u64;
            let Brightness { mean, error, .. } = brightness(bsdf, at_angle(degrees, 0.4), seed);
            println!("{name} at {degrees}°: {mean:.5} ± {error:.5}");
            assert!(mean <= 1.0 + 5.0 * error, "{name} at {degrees}°, seed {seed}: {mean} ± {error}");
            let is_dark = keeps_all(bsdf) && mean < 1.0 - 5.0 * error;
            assert!(!is_dark, "{name} at {degrees}°, seed {seed}: {mean} ± {error} is less than 1");
        }
    }
}

/// The base receives the rest of the light, up to the interpolation error of the albedo table.
#[test]
fn plastic_keeps_all_light() {
    for roughness in [0.0, 0.03, 0.1, 0.23, 0.4, 0.6, 0.85, 1.0] {
        for (step, degrees) in ANGLES.into_iter().chain([80.0, 85.0, 89.9]).enumerate() {
            let seed = 500 + step as u64;
            let Brightness { mean, error, .. } = brightness(&gltf(0.0, roughness).into(), at_angle(degrees, 0.4), seed);
            println!("plastic {roughness} at {degrees}°: {mean:.5} ± {error:.5}");
            assert!((mean - 1.0).abs() <= 1e-3 + 5.0 * error, "{roughness} at {degrees}°: {mean} ± {error}");
        }
    }
}

#[test]
fn lobes_over_each_other_add_their_light() {
    let Brightness { mean, error, .. } = brightness(&layers().into(), DVec3::Z, 6);
    assert!((mean - 0.8).abs() < 5.0 * error, "{mean} ± {error}");
}

#[test]
fn a_clearcoat_with_its_own_normal_gains_no_energy() {
    for Surface { name, bsdf } in leaning() {
        for degrees in ANGLES {
            let Brightness { mean, error, .. } = brightness(&bsdf, at_angle(degrees, 0.4), 7);
            assert!(mean < 1.0 + 5.0 * error, "{name} at {degrees}°: {mean} ± {error}");
        }
    }
}

#[test]
fn visible_normals_bound_the_weight() {
    for Surface { name, bsdf } in surfaces() {
        let is_bounded = matches!(bsdf, Bsdf::Single(Bxdf::Conductor(_) | Bxdf::Dielectric(_)))
            || matches!(bsdf, Bsdf::Single(Bxdf::MetallicRoughness(gltf)) if gltf.metallic == 1.0);
        for degrees in ANGLES.into_iter().chain([89.99, 130.0]).filter(|_| is_bounded) {
            let max = brightness(&bsdf, at_angle(degrees, 0.4), 3).max;
            assert!(max <= 1.0 + 1e-9, "{name} at {degrees}°: {max}");
        }
    }
}

/// A surface whose lobes are wrong by a few per cent is found by the furnace.
#[test]
fn a_broken_value_is_caught() {
    let wo = at_angle(60.0, 0.0);
    let Brightness { mean, error, .. } = brightness(&eon(0.8).into(), wo, 4);
    assert!((mean - 1.0).abs() < 5.0 * error);
    assert!((1.03 * mean - 1.0).abs() > 5.0 * error, "3 % is within {error}");
    // Without the light that bounces between the grooves, these are dark.
    let once = |sample: BsdfSample| {
        let s = sample.wi.x * wo.x;
        let bounce = 1.0 + 0.8 * if s > 0.0 { s / wo.z.max(sample.wi.z) } else { s };
        bounce / (1.0 + 0.8 * (0.5 - 2.0 / (3.0 * core::f64::consts::PI)))
    };
    let single: f64 = (0..SAMPLES).filter_map(|index| eon(0.8).sample(wo, numbers(4, index))).map(once).sum();
    assert!(single / (SAMPLES as f64) < 1.0 - 5.0 * error, "{single}");
}
