//! The lights that paths begin at.

use super::targets::{DirectionSample, Targets, within_cone};
use crate::{
    Falloff, Light, LightKind, Lighting,
    bsdf::cosine_hemisphere,
    emitter::{Emitter, EmitterSet, PowerChoice},
};
use core::f64::consts::{FRAC_1_PI, TAU};
use rt_math::{Aabb, DVec3, Frame, Interval, Ray, Rgb, Sampler};

/// The lights of a scene as beginnings of paths, one of which is chosen by its power.
///
/// | light | point | direction | power of a path |
/// |---|---|---|---|
/// | with extent | uniform by area | to a target, or else by the cosine | L cos θ / (p(x) p(ω)) |
/// | point, spot | its own | to a target, or else uniform | u I / p(ω) |
/// | directional | across it, before a target | its own | u E / p(x) |
///
/// The factor u is that of [`LightUnits::irradiance_factor`](crate::LightUnits::irradiance_factor), as for paths from the
/// camera. Light that does not weaken with the distance is spread as if it did, and made up for by the square of its whole way where it first meets a surface that spreads
/// it: behind a flat mirror there is the same light again. Lights whose shadows are switched off shine through everything, so
/// that mirrors and glass do nothing to them; they and the environment send no paths.
#[derive(Clone, Debug)]
pub struct LightSources {
    choice: PowerChoice,
    /// Lights without extent stand in the list behind this number of those with.
    emitters: usize,
    targets: Targets,
    /// A length beyond all that is bounded.
    reach: f64,
    /// Where transparent bodies are.
    bodies: Aabb,
}

/// The beginning of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeSample {
    pub(super) ray: Ray,
    pub(super) span: Interval,
    /// Power that the path carries.
    pub(super) power: Rgb,
    /// True if the light does not weaken with the distance.
    pub(super) no_falloff: bool,
}

impl LightSources {
    /// The lights of a scene whose sharp mirrors and glass are the targets. `bounds` is around all that is bounded, and
    /// `bodies` around all transparent bodies.
    pub fn new(lights: &[Light], emitters: &EmitterSet, targets: Targets, bounds: Aabb, bodies: Aabb) -> Self {
        let reach = if bounds.is_empty() { 1.0 } else { bounds.extent().length() };
        let with_extent = emitters.emitters().iter().map(|emitter| match emitter {
            Emitter::Environment(_) => Rgb::BLACK,
            emitter => emitter.power(reach),
        });
        let without = lights.iter().map(|light| power(light, &targets, reach));
        let choice = PowerChoice::new(with_extent.chain(without));
        Self { choice, emitters: emitters.emitters().len(), targets, reach, bodies }
    }

    /// True if no path from a light can be what is looked for.
    pub fn is_empty(&self) -> bool {
        self.targets.is_empty() || self.choice.choose(0.5).is_none()
    }

    /// What light is sent to.
    pub const fn targets(&self) -> &Targets {
        &self.targets
    }

    /// Where transparent bodies are.
    pub(super) const fn bodies(&self) -> Aabb {
        self.bodies
    }

    /// Draws the beginning of a path at a moment; `None` if its light would leave through the wrong side of its lamp.
    pub(super) fn sample_le(&self, lighting: Lighting<'_>, time: f64, sampler: &mut impl Sampler) -> Option<LeSample> {
        let choice = self.choice.choose(sampler.next_1d())?;
        let ball = if self.targets.len() > 1 { sampler.next_1d() } else { 0.0 };
        let u = sampler.next_2d();
        let index = choice.index as usize;
        let departing = match lighting.emitters.emitters().get(index) {
            Some(emitter) => self.sample_le_area(emitter, ball, u, sampler),
            None => self.sample_le_delta(lighting.appearance.lights.get(index - self.emitters)?, ball, u),
        }?;
        let ray = Ray { time, ..departing.ray };
        Some(LeSample { ray, power: departing.power / choice.probability, ..departing })
    }

    fn sample_le_area(
        &self,
        emitter: &Emitter,
        ball: f64,
        u: [f64; 2],
        sampler: &mut impl Sampler,
    ) -> Option<LeSample> {
        let from = emitter.sample_le(sampler.next_2d(), sampler.next_1d())?;
        let normal = from.surface.geometric_normal;
        let sample = self.targets.sample_direction(from.surface.point, ball, u).or_else(|| {
            let local = cosine_hemisphere(u);
            Some(DirectionSample { at: Frame::from_z(normal).from_local(local), pdf: local.z * FRAC_1_PI })
        })?;
        let cos = sample.at.dot(normal);
        (cos > 0.0).then(|| LeSample {
            ray: from.surface.spawn_ray(sample.at, 0.0),
            span: Interval::SPAWNED,
            power: from.radiance * (cos / (from.pdf * sample.pdf)),
            no_falloff: false,
        })
    }

    fn sample_le_delta(&self, light: &Light, ball: f64, u: [f64; 2]) -> Option<LeSample> {
        let (position, falloff, nearest) = match light.kind {
            LightKind::Directional { direction } => {
                let sample = self.targets.sample_disk(direction, ball, u)?;
                let ray = Ray::new(sample.at - direction * self.reach, direction);
                let power = light.intensity * (light.units.irradiance_factor() / sample.pdf);
                return Some(LeSample { ray, span: Interval::FORWARD, power, no_falloff: false });
            }
            LightKind::Point { position, falloff, shadow_near } => (position, falloff, shadow_near),
            LightKind::Spot { position, falloff, .. } => (position, falloff, 0.0),
        };
        let sample = self.targets.sample_direction(position, ball, u).unwrap_or_else(|| {
            let (axis, width) = match light.kind {
                LightKind::Spot { direction, cos_outer, .. } => (direction, 1.0 - cos_outer),
                _ => (DVec3::Z, 2.0),
            };
            DirectionSample { at: within_cone(axis, width, u), pdf: 1.0 / (TAU * width) }
        });
        let power = light.intensity * (light.beam(sample.at) * light.units.irradiance_factor() / sample.pdf);
        let span = Interval { min: nearest, ..Interval::FORWARD };
        let no_falloff = falloff == Falloff::None;
        (!power.is_black()).then(|| LeSample { ray: Ray::new(position, sample.at), span, power, no_falloff })
    }
}

/// Power by which a light is chosen; black for one that sends no paths.
fn power(light: &Light, targets: &Targets, reach: f64) -> Rgb {
    let at_distance = |falloff| if falloff == Falloff::None { reach * reach } else { 1.0 };
    let spread = match light.kind {
        _ if !light.casts_shadows => 0.0,
        LightKind::Directional { .. } => targets.area(),
        LightKind::Point { falloff, .. } => 2.0 * TAU * at_distance(falloff),
        LightKind::Spot { cos_outer, falloff, .. } => TAU * (1.0 - cos_outer) * at_distance(falloff),
    };
    light.intensity * (light.units.irradiance_factor() * spread)
}
