//! Lights that light tracing starts paths from.

use super::projection_map::{DirectionSample, ProjectionMap, within_cone};
use crate::{
    Lighting,
    bsdf::cosine_hemisphere,
    light::{DeltaLight, Falloff, Light, LightPointSample, LightSet, PowerLightSampler, delta::EmittedRays},
};
use core::f64::consts::{FRAC_1_PI, TAU};
use rt_math::{Aabb, Frame, Interval, Ray, Rgb, Sampler};

/// Lights of a scene as origins of paths. One is sampled by its power.
///
/// | light | point | direction | power of a path |
/// |---|---|---|---|
/// | area light | uniform by area | to a target, or else by the cosine | L cos θ / (p(x) p(ω)) |
/// | point, spot | its own | to a target, or else uniform | u I / p(ω) |
/// | directional | on a disk before a target | its own | u E / p(x) |
///
/// The factor u is [`LightUnits::irradiance_factor`](crate::LightUnits::irradiance_factor), as in path tracing.
///
/// Light without falloff is traced as if it had one. At the first non-specular surface the square of the path length compensates
/// for it: a flat mirror does not weaken the light.
///
/// Lights that cast no shadows pass through all surfaces, so that mirrors and glass do not affect them. They and the
/// environment start no paths.
#[derive(Clone, Debug)]
pub struct LightSources {
    sampler: PowerLightSampler,
    projection_map: ProjectionMap,
    /// Length of the diagonal around all that is bounded.
    reach: f64,
    /// Bounds of dielectrics.
    dielectric_bounds: Aabb,
}

/// First ray of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightLeSample {
    pub(super) ray: Ray,
    pub(super) span: Interval,
    pub(super) power: Rgb,
    /// True if the light has no falloff with distance.
    pub(super) no_falloff: bool,
}

impl LightSources {
    /// Lights of a scene, and the map of its specular surfaces. `bounds` contains all that is bounded, and
    /// `dielectric_bounds` all dielectrics.
    pub fn new(lights: &LightSet, projection_map: ProjectionMap, bounds: Aabb, dielectric_bounds: Aabb) -> Self {
        let reach = if bounds.is_empty() { 1.0 } else { bounds.extent().length() };
        let power = |light: &Light| match light {
            Light::Environment(_) => Rgb::BLACK,
            Light::Delta(light) => power(light, &projection_map, reach),
            light => light.power(reach),
        };
        let sampler = PowerLightSampler::new(lights.lights().iter().map(power));
        Self { sampler, projection_map, reach, dielectric_bounds }
    }

    /// True if no light can reach a specular surface.
    pub fn is_empty(&self) -> bool {
        self.projection_map.is_empty() || self.sampler.sample(0.5).is_none()
    }

    /// The surfaces at which paths are aimed.
    pub const fn projection_map(&self) -> &ProjectionMap {
        &self.projection_map
    }

    /// Bounds of dielectrics.
    pub(super) const fn dielectric_bounds(&self) -> Aabb {
        self.dielectric_bounds
    }

    /// Samples the first ray of a path at a time; `None` if it would leave through the wrong side of its light.
    pub(super) fn sample_le(
        &self,
        lighting: Lighting<'_>,
        time: f64,
        sampler: &mut impl Sampler,
    ) -> Option<LightLeSample> {
        let choice = self.sampler.sample(sampler.next_1d())?;
        let target = if self.projection_map.len() > 1 { sampler.next_1d() } else { 0.0 };
        let u = sampler.next_2d();
        let sample = match lighting.lights.lights().get(choice.index as usize)? {
            Light::Delta(light) => self.sample_le_delta(light, target, u),
            light => self.sample_le_area(&light.sample_point(sampler.next_2d(), sampler.next_1d())?, target, u),
        }?;
        let ray = Ray { time, ..sample.ray };
        Some(LightLeSample { ray, power: sample.power / choice.probability, ..sample })
    }

    fn sample_le_area(&self, from: &LightPointSample, target: f64, u: [f64; 2]) -> Option<LightLeSample> {
        let normal = from.surface.geometric_normal;
        let sample = self.projection_map.sample_direction(from.surface.point, target, u).or_else(|| {
            let local = cosine_hemisphere(u);
            Some(DirectionSample { at: Frame::from_z(normal).from_local(local), pdf: local.z * FRAC_1_PI })
        })?;
        let cos = sample.at.dot(normal);
        (cos > 0.0).then(|| LightLeSample {
            ray: from.surface.spawn_ray(sample.at, 0.0),
            span: Interval::SPAWNED,
            power: from.radiance * (cos / (from.pdf * sample.pdf)),
            no_falloff: false,
        })
    }

    fn sample_le_delta(&self, light: &DeltaLight, target: f64, u: [f64; 2]) -> Option<LightLeSample> {
        let (position, axis, one_minus_cos, start, falloff) = match light.emitted_rays() {
            EmittedRays::Parallel { direction } => {
                let sample = self.projection_map.sample_disk(direction, target, u)?;
                let ray = Ray::new(sample.at - direction * self.reach, direction);
                let power = light.intensity * (light.units.irradiance_factor() / sample.pdf);
                return Some(LightLeSample { ray, span: Interval::FORWARD, power, no_falloff: false });
            }
            EmittedRays::Cone { position, axis, one_minus_cos, start, falloff } => {
                (position, axis, one_minus_cos, start, falloff)
            }
        };
        let sample = self.projection_map.sample_direction(position, target, u).unwrap_or_else(|| DirectionSample {
            at: within_cone(axis, one_minus_cos, u),
            pdf: 1.0 / (TAU * one_minus_cos),
        });
        let power =
            light.intensity * (light.spot_falloff(sample.at.into()) * light.units.irradiance_factor() / sample.pdf);
        let span = Interval { min: start, ..Interval::FORWARD };
        let no_falloff = falloff == Falloff::None;
        (!power.is_black()).then(|| LightLeSample { ray: Ray::new(position, sample.at), span, power, no_falloff })
    }
}

/// Power by which a delta light is sampled; black for one that starts no paths.
fn power(light: &DeltaLight, projection_map: &ProjectionMap, reach: f64) -> Rgb {
    let measure = match light.emitted_rays() {
        _ if !light.casts_shadows => 0.0,
        EmittedRays::Parallel { .. } => projection_map.area(),
        EmittedRays::Cone { one_minus_cos, falloff, .. } => {
            let at_distance = if falloff == Falloff::None { reach * reach } else { 1.0 };
            TAU * one_minus_cos * at_distance
        }
    };
    light.intensity * (light.units.irradiance_factor() * measure)
}
