//! Estimates with standard errors, for tests of lights.

use super::{Emission, EmissionSides, Light, LightLiSample};
use rt_math::random::{hash, unit};
use rt_math::transcendental::sincos;
use rt_math::{DVec3, Frame, Rgb};
use std::f64::consts::TAU;

/// Mean of random numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    pub(super) mean: f64,
    pub(super) standard_error: f64,
}

impl Estimate {
    /// Mean of `f` over the unit square.
    pub(super) fn of(count: u32, f: impl Fn([f64; 2]) -> f64) -> Self {
        let (mut mean, mut squares) = (0.0, 0.0);
        for i in 0..count {
            let draw = |dimension| unit(hash(&[u64::from(count), u64::from(i), dimension]));
            let value = f([draw(0), draw(1)]);
            let from_mean = value - mean;
            mean += from_mean / f64::from(i + 1);
            squares += from_mean * (value - mean);
        }
        let n = f64::from(count);
        Self { mean, standard_error: (squares / (n - 1.0) / n).sqrt() }
    }

    /// Difference from the truth in standard errors; relative differences below 10⁻¹⁰ count as 0.
    pub(super) fn z(&self, truth: f64) -> f64 {
        let off = ((self.mean - truth).abs() - 1e-10 * truth.abs()).max(0.0);
        if off == 0.0 { 0.0 } else { off / self.standard_error }
    }

    /// Fails if the mean is more than five standard errors off.
    pub(super) fn assert(&self, what: &str, truth: f64) {
        let z = self.z(truth);
        println!("{what}: {:.8e} ± {:.1e}, truth {truth:.8e}, z = {z:.2}", self.mean, self.standard_error);
        assert!(z < 5.0, "{what}: {self:?}, truth {truth}, z = {z}");
    }
}

/// White light from the given sides.
pub(super) fn white(sides: EmissionSides) -> Emission {
    Emission::new(Rgb::WHITE, sides).expect("an emission")
}

/// Irradiance of a receiver, with `pdf` as density of the samples.
pub(super) fn irradiance_by(
    light: &Light,
    at: [DVec3; 2],
    count: u32,
    pdf: impl Fn(&LightLiSample) -> f64,
) -> Estimate {
    let [point, normal] = at;
    Estimate::of(count, |u| {
        let sample = light.sample_li(point, u);
        sample.map_or(0.0, |s| s.radiance.g * s.direction.dot(normal).max(0.0) / pdf(&s))
    })
}

/// Irradiance at a point (first) of a surface with a unit normal (second).
pub(super) fn irradiance(light: &Light, at: [DVec3; 2], count: u32) -> Estimate {
    irradiance_by(light, at, count, |sample| sample.pdf)
}

/// Solid angle of a cone around the light, and uniform directions within it.
fn cone(light: &Light, point: DVec3) -> (f64, impl Fn([f64; 2]) -> DVec3) {
    let around = light.bounds().map(|bounds| bounds.around());
    let towards = around.map_or(DVec3::Z, |around| around.centre() - point);
    let radius = around.map_or(f64::INFINITY, |around| 0.5 * around.extent().length() * 1.000_001);
    let sin = radius / towards.length();
    let one_minus_cos = if sin < 1.0 { sin * sin / (1.0 + (1.0 - sin * sin).sqrt()) } else { 2.0 };
    let frame = Frame::from_z(towards.try_normalize().unwrap_or(DVec3::Z));
    (TAU * one_minus_cos, move |u: [f64; 2]| {
        let below = u[0] * one_minus_cos;
        let (sin, cos) = sincos(TAU * u[1]);
        let across = (below * (2.0 - below)).sqrt();
        frame.from_local(DVec3::new(across * cos, across * sin, 1.0 - below))
    })
}

/// ∫ pdf dω over directions that depend on the bounds of the light alone.
pub(super) fn integral_of_pdf(light: &Light, point: DVec3, count: u32) -> Estimate {
    let (solid_angle, direction) = cone(light, point);
    Estimate::of(count, |u| solid_angle * light.pdf_li(point, direction(u)))
}

/// Irradiance from rays that depend on the bounds of the light alone.
pub(super) fn irradiance_by_rays(light: &Light, [point, normal]: [DVec3; 2], count: u32) -> Estimate {
    let (solid_angle, direction) = cone(light, point);
    Estimate::of(count, |u| {
        let direction = direction(u);
        let seen = light.intersect(point, direction).map_or(Rgb::BLACK, |at| light.le(direction, at.normal));
        solid_angle * seen.g * direction.dot(normal).max(0.0)
    })
}

/// Fails unless samples of the light give the same irradiance as rays.
pub(super) fn assert_rays_agree(light: &Light, at: [DVec3; 2], count: u32) {
    let (samples, rays) = (irradiance(light, at, count), irradiance_by_rays(light, at, count));
    let squared = |estimate: Estimate| estimate.standard_error * estimate.standard_error;
    let z = (samples.mean - rays.mean).abs() / (squared(samples) + squared(rays)).sqrt();
    println!("from {}: {:.6e}, by rays {:.6e}, z = {z:.2}", at[0], samples.mean, rays.mean);
    assert!(z < 5.0, "from {}: {samples:?}, by rays {rays:?}", at[0]);
}

/// Fails unless samples are valid and their density equals `pdf_li` within a relative `tolerance`. At the rim a direction may miss
/// the light: one of a thousand may do so.
pub(super) fn assert_samples_and_pdf_agree(light: &Light, point: DVec3, tolerance: f64) {
    let count = 2000;
    let (mut seen, mut passed_by) = (0, 0);
    for i in 0..count {
        let draw = |dimension| unit(hash(&[i, dimension, 77]));
        let Some(sample) = light.sample_li(point, [draw(0), draw(1)]) else { continue };
        assert!((sample.direction.length() - 1.0).abs() < 1e-14, "{sample:?}");
        assert!(sample.pdf > 0.0 && sample.pdf.is_finite() && !sample.radiance.is_black(), "{sample:?}");
        if let Some(on_light) = sample.point {
            let reached = point + sample.direction * sample.distance;
            assert!((reached - on_light).length() < 1e-9 * (1.0 + sample.distance), "{sample:?}");
            let off = sample.shadow_target().expect("a point") - on_light;
            let is_off = off.dot(sample.normal) * sample.direction.dot(sample.normal) < 0.0;
            assert!(is_off, "a shadow ray meets the light: {sample:?}");
        }
        let pdf = light.pdf_li(point, sample.direction);
        seen += 1;
        passed_by += u64::from(pdf == 0.0);
        assert!(pdf == 0.0 || (pdf / sample.pdf - 1.0).abs() < tolerance, "{pdf} for {sample:?}");
    }
    assert!(seen > count / 20, "only {seen} of {count} are samples");
    assert!(passed_by * 1000 <= count, "{passed_by} of {seen} samples pass the light by");
}
