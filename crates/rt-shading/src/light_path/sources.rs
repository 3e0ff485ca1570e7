//! The lights that paths begin at.

use super::targets::{Aim, Targets, within_cone};
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
pub(super) struct Departing {
    pub(super) ray: Ray,
    pub(super) span: Interval,
    /// Power that the path carries.
    pub(super) power: Rgb,
    /// True if the light does not weaken with the distance.
    pub(super) is_unweakened: bool,
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
    pub(super) fn depart(&self, lighting: Lighting<'_>, time: f64, sampler: &mut impl Sampler) -> Option<Departing> {
        let choice = self.choice.choose(sampler.next_1d())?;
        let ball = if self.targets.len() > 1 { sampler.next_1d() } else { 0.0 };
        let u = sampler.next_2d();
        let index = choice.index as usize;
        let departing = match lighting.emitters.emitters().get(index) {
            Some(emitter) => self.leave_emitter(emitter, ball, u, sampler),
            None => self.leave_light(lighting.appearance.lights.get(index - self.emitters)?, ball, u),
        }?;
        let ray = Ray { time, ..departing.ray };
        Some(Departing { ray, power: departing.power / choice.probability, ..departing })
    }

    fn leave_emitter(
        &self,
        emitter: &Emitter,
        ball: f64,
        u: [f64; 2],
        sampler: &mut impl Sampler,
    ) -> Option<Departing> {
        let from = emitter.depart(sampler.next_2d(), sampler.next_1d())?;
        let normal = from.surface.geometric_normal;
        let aim = self.targets.direction_from(from.surface.point, ball, u).or_else(|| {
            let local = cosine_hemisphere(u);
            Some(Aim { at: Frame::from_z(normal).from_local(local), pdf: local.z * FRAC_1_PI })
        })?;
        let cos = aim.at.dot(normal);
        (cos > 0.0).then(|| Departing {
            ray: from.surface.spawn_ray(aim.at, 0.0),
            span: Interval::SPAWNED,
            power: from.radiance * (cos / (from.pdf * aim.pdf)),
            is_unweakened: false,
        })
    }

    fn leave_light(&self, light: &Light, ball: f64, u: [f64; 2]) -> Option<Departing> {
        let (position, falloff, nearest) = match light.kind {
            LightKind::Directional { direction } => {
                let aim = self.targets.point_across(direction, ball, u)?;
                let ray = Ray::new(aim.at - direction * self.reach, direction);
                let power = light.intensity * (light.units.irradiance_factor() / aim.pdf);
                return Some(Departing { ray, span: Interval::FORWARD, power, is_unweakened: false });
            }
            LightKind::Point { position, falloff, lamp_radius } => (position, falloff, lamp_radius),
            LightKind::Spot { position, falloff, .. } => (position, falloff, 0.0),
        };
        let aim = self.targets.direction_from(position, ball, u).unwrap_or_else(|| {
            let (axis, width) = match light.kind {
                LightKind::Spot { direction, cos_outer, .. } => (direction, 1.0 - cos_outer),
                _ => (DVec3::Z, 2.0),
            };
            Aim { at: within_cone(axis, width, u), pdf: 1.0 / (TAU * width) }
        });
        let power = light.intensity * (light.beam(aim.at) * light.units.irradiance_factor() / aim.pdf);
        let span = Interval { min: nearest, ..Interval::FORWARD };
        let is_unweakened = falloff == Falloff::None;
        (!power.is_black()).then(|| Departing { ray: Ray::new(position, aim.at), span, power, is_unweakened })
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
