//! Planted faults: each is put into an estimate that passes without it, and must be detected.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use rt_camera::SamplerKind;
use rt_math::{DVec3, Rgb, Sampler, transcendental::sincos};
use rt_scene_io::Integrator;
use rt_shading::{
    ColorTexture,
    bsdf::{Bsdf, Lambert, PhongLobe},
    light::{LightSampling, LightSet},
};

use super::{
    Case, Checks, Conditions, Fallible,
    area_light::{ALBEDO, AreaLight, Receiver, irradiance_from},
    cases,
    enclosures::Enclosure,
    estimate::{Estimate, MAX_Z, mean_of},
    faulty_samplers::{self, PATTERN, SPP, area_light},
    slopes::{TOLERANCE, rmse, slope},
};

cases! {
    "faults", "lights, densities, weights, depths and samplers that are wrong on purpose, and their right twins",
        "wrong ones are found, right ones pass", "> 5 σ; 5 σ", faults;
    "fault-slope", "a pattern that has lost its strata",
        "its slope is found to be that of another", "0.1 abs", lost_strata;
}

struct Fault {
    what: &'static str,
    truth: fn() -> f64,
    /// The estimate of a seed, with or without the fault.
    estimate: fn(is_wrong: bool, seed: u64) -> Fallible<f64>,
}

const FAULTS: [Fault; 11] = [
    Fault { what: "a light that is 1 % too bright", truth: one_light, estimate: bright_light },
    Fault { what: "a light that shines to both sides", truth: || 0.0, estimate: two_sided_light },
    Fault { what: "a density of light samples that is 2 % too great", truth: one_light, estimate: light_density },
    Fault { what: "a choice of lights that is not divided by", truth: two_lights, estimate: forgotten_choice },
    Fault { what: "a BSDF's density without its cosine", truth: || 0.5, estimate: density_without_cosine },
    Fault { what: "a highlight of n + 1 in place of n + 2", truth: || 1.0, estimate: highlight },
    Fault { what: "weights of two strategies that add up to more than 1", truth: one_light, estimate: weights },
    Fault { what: "one bounce too few", truth: || 1.96875, estimate: missing_bounce },
    Fault {
        what: "the same numbers for place and light",
        truth: faulty_samplers::truth,
        estimate: faulty_samplers::repeating,
    },
    Fault {
        what: "half-jittered numbers for a light",
        truth: faulty_samplers::truth,
        estimate: faulty_samplers::half_jittered,
    },
    Fault { what: "coordinates in the wrong order", truth: faulty_samplers::truth, estimate: faulty_samplers::shifted },
];

const GROUND: Receiver = Receiver::ground(0.25);

/// A second one, smaller and aside.
fn other() -> AreaLight {
    AreaLight::disk(0.3, 0.7, 1.0)
}

fn one_light() -> f64 {
    area_light().irradiance(&GROUND)
}

fn two_lights() -> f64 {
    one_light() + other().irradiance(&GROUND)
}

fn faults(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let seeds = conditions.count(64, 256);
    for Fault { what, truth, estimate } in &FAULTS {
        let z = |is_wrong| {
            let found = Estimate::of_seeds(what, seeds, |seed| estimate(is_wrong, seed));
            found.map(|found| found.z(truth()))
        };
        let (right, wrong) = (z(false)?, z(true)?);
        checks.note(format!("{what}: z = {wrong:+.1}; without it {right:+.2}"));
        checks.check(right.abs() <= MAX_Z, || format!("the right twin of {what}: z = {right}"));
        checks.check(wrong.abs() > MAX_Z, || format!("{what} is not found: z = {wrong}"));
    }
    Ok(())
}

/// Irradiance from an image of the changed light.
fn bright_light(is_wrong: bool, seed: u64) -> Fallible<f64> {
    let mut image = area_light().scene(&GROUND, 1e-9, "")?;
    if is_wrong {
        for material in image.scene.appearance.materials.iter_mut().filter(|material| material.name == "lamp") {
            material.emission = ColorTexture::Constant(Rgb::gray(1.01));
        }
    }
    Ok(image.mean(Integrator::Path, PATTERN, SPP, seed)? * PI / ALBEDO)
}

/// A light that faces away.
fn two_sided_light(is_wrong: bool, seed: u64) -> Fallible<f64> {
    let turned = AreaLight::Quad(DVec3::new(-0.5, -0.5, 1.0), [DVec3::X, DVec3::Y]);
    let mut image = turned.scene(&GROUND, 1e-9, "")?;
    if is_wrong {
        for material in &mut image.scene.appearance.materials {
            material.emission_sides = rt_shading::light::EmissionSides::Both;
        }
    }
    image.mean(Integrator::Path, PATTERN, SPP, seed)
}

fn light_density(is_wrong: bool, seed: u64) -> Fallible<f64> {
    let light = area_light().light()?;
    let scale = if is_wrong { 1.02 } else { 1.0 };
    Ok(mean_of(PATTERN, SPP, seed, |sample| irradiance_from(&light, &GROUND, sample.next_2d()) / scale))
}

fn forgotten_choice(is_wrong: bool, seed: u64) -> Fallible<f64> {
    let lights = LightSet::new(vec![area_light().light()?, other().light()?], LightSampling::Tree, 1.0);
    Ok(mean_of(PATTERN, SPP, seed, |sample| {
        let (u, choice) = (sample.next_2d(), sample.next_1d());
        let Some(light) = lights.sample_li(GROUND.point, Some(GROUND.normal), choice, u) else { return 0.0 };
        let pdf = if is_wrong { light.sample.pdf } else { light.pdf };
        light.sample.radiance.g * light.sample.direction.z.max(0.0) / pdf
    }))
}

/// Half of the sky emits.
fn density_without_cosine(is_wrong: bool, seed: u64) -> Fallible<f64> {
    let bsdf = Bsdf::from(Lambert { albedo: Rgb::WHITE });
    Ok(mean_of(PATTERN, SPP, seed, |sample| {
        let [u, v] = sample.next_2d();
        let Some(found) = bsdf.sample(DVec3::Z, [0.5, u, v]) else { return 0.0 };
        let sky = if found.wi.x > 0.0 { 1.0 } else { 0.0 };
        let pdf = if is_wrong { 1.0 / TAU } else { found.pdf };
        sky * found.value.g * found.wi.z / pdf
    }))
}

/// Along the normal.
fn highlight(is_wrong: bool, seed: u64) -> Fallible<f64> {
    let lobe = PhongLobe { reflectance: Rgb::WHITE, exponent: 10.0 };
    let scale = if is_wrong { 11.0 / 12.0 } else { 1.0 };
    Ok(mean_of(PATTERN, SPP, seed, |sample| {
        let [u, v] = sample.next_2d();
        lobe.sample(DVec3::Z, [0.5, u, v]).map_or(0.0, |found| scale * found.weight().g)
    }))
}

/// Directions to the light and of a diffuse surface, weighted by the power heuristic; the fault weights the second by the
/// balance heuristic.
fn weights(is_wrong: bool, seed: u64) -> Fallible<f64> {
    let light = area_light().light()?;
    Ok(mean_of(PATTERN, SPP, seed, |sample| {
        let power = |drawn: f64, other: f64| drawn * drawn / (drawn * drawn + other * other);
        let by_light = light.sample_li(GROUND.point, sample.next_2d()).map_or(0.0, |light| {
            let cos = light.direction.z.max(0.0);
            light.radiance.g * cos / light.pdf * power(light.pdf, cos * FRAC_1_PI)
        });
        let [u, v] = sample.next_2d();
        let ((sin_phi, cos_phi), radius) = (sincos(TAU * v), u.sqrt());
        let direction = DVec3::new(radius * cos_phi, radius * sin_phi, (1.0 - u).sqrt());
        let by_surface = light.intersect(GROUND.point, direction).map_or(0.0, |at| {
            let (drawn, other) = (direction.z * FRAC_1_PI, light.pdf_li(GROUND.point, direction));
            let weight = if is_wrong { drawn / (drawn + other) } else { power(drawn, other) };
            PI * light.le(direction, at.normal).g * weight
        });
        by_light + by_surface
    }))
}

fn missing_bounce(is_wrong: bool, seed: u64) -> Fallible<f64> {
    let depth = if is_wrong { 3 } else { 4 };
    Enclosure::Cube.emissive(0.5, depth)?.mean(Integrator::Path, PATTERN, SPP, seed)
}

/// Random points in place of jittered ones.
fn lost_strata(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const JITTERED: f64 = -0.75;
    let seeds = conditions.count(256, 1024);
    for (pattern, is_wrong) in [(SamplerKind::Jittered, false), (SamplerKind::Random, true)] {
        let below = |[x, y]: [f64; 2]| if y < 0.3 + 0.2 * x { 1.0 } else { 0.0 };
        let slope = slope(&[16, 64, 256, 1024], |spp| {
            rmse(seeds, 0.4, &|seed| Ok(mean_of(pattern, spp, seed, |sample| below(sample.next_2d()))))
        })?;
        let name = if is_wrong { "random points that pass for jittered ones" } else { "jittered points" };
        checks.note(format!("{name}: slope {slope:.3}"));
        checks.check(((slope - JITTERED).abs() > TOLERANCE) == is_wrong, || format!("{name}: slope {slope}"));
    }
    Ok(())
}
