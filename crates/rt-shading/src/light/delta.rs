//! Delta lights: point, spot and directional.
//!
//! | light | emits | incident light at a distance d |
//! |---|---|---|
//! | point | radiant intensity I in all directions | I / d², or I at any distance |
//! | spot | I within a cone, with a smooth edge | as a point light, times the falloff of the cone |
//! | directional | parallel rays from infinitely far away | I |
//!
//! Ambient light is no light but a term of classical surfaces: [`Appearance::ambient`](crate::Appearance::ambient).

use super::light_bounds::LightBounds;
use super::light_sample::LightLiSample;
use core::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
use rt_geometry::ShadowRays;
use rt_math::transcendental::acos;
use rt_math::{Aabb, DVec3, Interval, Ray, Real, Rgb, Vector3};

/// Relative margin around `shadow_near`: shadow rays end this part of their length earlier. In spite of rounding, a sphere of this
/// radius around the light does not shadow it.
const SHADOW_NEAR_MARGIN: f64 = 1.0 / (1u64 << 40) as f64;

/// Relative bound on the rounding error of a dot product. Its computed sign is right if its absolute value exceeds this part of
/// the sum of the absolute products.
const SIGN_MARGIN: f64 = 1.0 / (1u64 << 40) as f64;

/// Attenuation of light with distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Falloff {
    /// No attenuation: classical ray tracing.
    None,
    /// Attenuation with the square of the distance: physics.
    InverseSquare,
}

/// Position, direction and cone of a delta light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeltaLightKind {
    /// Point light: emits in all directions.
    Point {
        /// World space.
        position: DVec3,
        /// Attenuation with distance.
        falloff: Falloff,
        /// Surfaces at this distance from the light or nearer do not shadow it; 0 for none. No established term.
        shadow_near: f64,
    },
    /// Directional light: parallel rays from infinitely far away.
    Directional {
        /// Unit vector in which the light travels, world space.
        direction: DVec3,
    },
    /// Spot light: emits from a point within a cone.
    Spot {
        /// World space.
        position: DVec3,
        /// Unit vector along the axis, in which the light travels, world space.
        direction: DVec3,
        /// Cosine of the angle from the axis up to which the light has its full intensity.
        cos_inner: f64,
        /// Cosine of the angle from the axis beyond which there is no light; less than `cos_inner`.
        cos_outer: f64,
        /// Attenuation with distance.
        falloff: Falloff,
    },
}

/// Cone of a spot light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotCone {
    /// Unit vector along the axis, in which the light travels, world space.
    pub direction: DVec3,
    /// Cosine of the angle from the axis up to which the light has its full intensity.
    pub cos_inner: f64,
    /// Cosine of the angle from the axis beyond which there is no light.
    pub cos_outer: f64,
}

/// Units of the intensity of a delta light.
///
/// A white Lambertian surface, lit perpendicularly by an intensity of 1, has this radiance under every integrator:
///
/// | units | radiance | intensity |
/// |---|---|---|
/// | [`Classical`](Self::Classical) | 1 | reflected by a coefficient kd, without 1/π |
/// | [`Physical`](Self::Physical) | 1/π | irradiance, from radiant intensity or luminous intensity |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LightUnits {
    /// Fractions of white, as in classical ray tracers.
    #[default]
    Classical,
    /// Intensity (W/sr, cd) of point lights and spots, irradiance (W/m², lx) of directional lights. The units match the
    /// radiance of emissive surfaces and environments.
    Physical,
}

/// Light whose direction or position is a Dirac delta distribution: rays never hit it.
#[derive(Clone, Debug, PartialEq)]
pub struct DeltaLight {
    /// Name for messages.
    pub name: String,
    /// Position, direction and cone.
    pub kind: DeltaLightKind,
    /// Intensity at unit distance with inverse-square falloff, otherwise at any distance.
    pub intensity: Rgb,
    /// Units of the intensity.
    pub units: LightUnits,
    /// True if objects cast shadows in this light.
    pub casts_shadows: bool,
}

/// Incident light of a delta light at a point, in the light's own units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeltaLiSample {
    /// Unit vector towards the light.
    pub direction: DVec3,
    /// Intensity after attenuation, without shadows and the cosine. See [`LightUnits`] for its factors.
    pub strength: Rgb,
    /// Distance to the light; infinite for directional light.
    pub distance: f64,
}

/// Incident light at points, one per lane, as [`DeltaLiSample`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeltaLiLanes<R: Real> {
    pub(crate) direction: Vector3<R>,
    pub(crate) strength: Vector3<R>,
    pub(crate) distance: R,
    /// False outside the cone of a spot, and at the light's own position: all else is not valid there.
    pub(crate) is_lit: R::Mask,
}

/// Set of rays that a delta light emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum EmittedRays {
    /// Parallel rays everywhere.
    Parallel {
        /// Unit vector in which the light travels, world space.
        direction: DVec3,
    },
    /// Rays from a point within a cone.
    Cone {
        /// World space.
        position: DVec3,
        /// Unit vector along the axis, world space.
        axis: DVec3,
        /// One minus the cosine of the cone's half-angle; 2 for all directions.
        one_minus_cos: f64,
        /// Distance at which rays start to hit surfaces.
        start: f64,
        /// Attenuation with distance.
        falloff: Falloff,
    },
}

impl LightUnits {
    /// Factor from an intensity to the irradiance that a BSDF reflects.
    pub const fn irradiance_factor(self) -> f64 {
        match self {
            Self::Classical => PI,
            Self::Physical => 1.0,
        }
    }

    /// Factor from an intensity to the light that coefficients of a classical surface reflect.
    pub const fn classical_factor(self) -> f64 {
        match self {
            Self::Classical => 1.0,
            Self::Physical => FRAC_1_PI,
        }
    }
}

impl DeltaLightKind {
    /// Position, world space; `None` for directional light.
    #[inline]
    pub const fn position(&self) -> Option<DVec3> {
        match *self {
            Self::Point { position, .. } | Self::Spot { position, .. } => Some(position),
            Self::Directional { .. } => None,
        }
    }

    /// Mutable position, world space; `None` for directional light.
    pub const fn position_mut(&mut self) -> Option<&mut DVec3> {
        match self {
            Self::Point { position, .. } | Self::Spot { position, .. } => Some(position),
            Self::Directional { .. } => None,
        }
    }

    /// Vector from a point to the light, world space; a unit vector for directional light.
    pub fn offset_from(&self, point: DVec3) -> DVec3 {
        match *self {
            Self::Point { position, .. } | Self::Spot { position, .. } => position - point,
            Self::Directional { direction } => -direction,
        }
    }

    /// Cone outside of which there is no light; `None` without one.
    pub const fn cone(&self) -> Option<SpotCone> {
        match *self {
            Self::Spot { direction, cos_inner, cos_outer, .. } => Some(SpotCone { direction, cos_inner, cos_outer }),
            Self::Point { .. } | Self::Directional { .. } => None,
        }
    }

    /// Distance from the light up to which surfaces do not shadow it; 0 for none.
    pub const fn shadow_near(&self) -> f64 {
        match *self {
            Self::Point { shadow_near, .. } => shadow_near,
            Self::Spot { .. } | Self::Directional { .. } => 0.0,
        }
    }
}

impl DeltaLight {
    /// Light without a name, in classical units, in which objects cast shadows.
    pub const fn new(kind: DeltaLightKind, intensity: Rgb) -> Self {
        Self { name: String::new(), kind, intensity, units: LightUnits::Classical, casts_shadows: true }
    }

    /// Incident light at `point` (world space), without shadows. `None` outside the cone of a spot, and at the light's own
    /// position.
    #[inline(always)]
    pub fn sample_li(&self, point: DVec3) -> Option<DeltaLiSample> {
        let DeltaLiLanes { direction, strength, distance, is_lit } = self.sample_li_lanes(Vector3::from(point));
        is_lit.then(|| DeltaLiSample {
            direction: direction.into(),
            strength: DVec3::from(strength).to_array().into(),
            distance,
        })
    }

    /// Version of [`sample_li`](Self::sample_li) for one point per lane.
    #[inline(always)]
    pub(crate) fn sample_li_lanes<R: Real>(&self, point: Vector3<R>) -> DeltaLiLanes<R> {
        let to_light = self.kind.position().map_or(point, |position| Vector3::splat(point.x, position) - point);
        self.sample_li_from(to_light)
    }

    /// Version of [`sample_li_lanes`](Self::sample_li_lanes), given the vectors from the points to the light, which directional light
    /// ignores.
    #[inline(always)]
    pub(crate) fn sample_li_from<R: Real>(&self, to_light: Vector3<R>) -> DeltaLiLanes<R> {
        let like = to_light.x;
        let (zero, one) = (like.splat(0.0), like.splat(1.0));
        let intensity = Vector3::splat(like, self.intensity.to_array().into());
        let falloff = match self.kind {
            DeltaLightKind::Directional { direction } => {
                return DeltaLiLanes {
                    direction: Vector3::splat(like, -direction),
                    strength: intensity,
                    distance: like.splat(f64::INFINITY),
                    is_lit: zero.lt(one),
                };
            }
            DeltaLightKind::Point { falloff, .. } | DeltaLightKind::Spot { falloff, .. } => falloff,
        };
        let distance = to_light.length();
        let direction = to_light / distance;
        let emitted = self.spot_falloff(-direction);
        let attenuated = match falloff {
            Falloff::None => emitted,
            Falloff::InverseSquare => emitted / (distance * distance),
        };
        let is_lit = direction.is_finite() & emitted.gt(zero);
        DeltaLiLanes { direction, strength: intensity * attenuated, distance, is_lit }
    }

    /// Incident irradiance as a sample among those of other lights: with the density 1. `None` if it is black.
    pub(super) fn sample_irradiance(&self, point: DVec3) -> Option<LightLiSample> {
        let DeltaLiSample { direction, strength, distance } = self.sample_li(point)?;
        let sample = LightLiSample {
            direction,
            distance,
            point: self.kind.position(),
            point_error: DVec3::ZERO,
            normal: -direction,
            radiance: strength * self.units.irradiance_factor(),
            pdf: 1.0,
        };
        (sample.radiance.is_finite() && !sample.radiance.is_black()).then_some(sample)
    }

    /// True if the light is certainly behind a surface with this normal: the cosine of [`sample_li`](Self::sample_li) would not
    /// be positive. The test takes no square root.
    #[inline(always)]
    pub(crate) fn is_behind<R: Real>(&self, point: Vector3<R>, normal: Vector3<R>) -> R::Mask {
        match self.kind {
            DeltaLightKind::Directional { .. } => point.x.lt(point.x),
            DeltaLightKind::Point { position, .. } | DeltaLightKind::Spot { position, .. } => {
                let offset = Vector3::splat(point.x, position) - point;
                // Far more than the rounding error of the cosine.
                normal.dot(offset).lt(normal.abs().dot(offset.abs()) * -SIGN_MARGIN)
            }
        }
    }

    /// Relative intensity, 0 to 1, in the direction `wo` (unit) in which light leaves.
    #[inline(always)]
    pub(crate) fn spot_falloff<R: Real>(&self, wo: Vector3<R>) -> R {
        let (zero, one) = (wo.x.splat(0.0), wo.x.splat(1.0));
        match self.kind {
            DeltaLightKind::Spot { direction, cos_inner, cos_outer, .. } => {
                // The squared ramp of KHR_lights_punctual.
                let cos = wo.dot(Vector3::splat(zero, direction));
                let ramp = ((cos - cos_outer) / zero.splat(cos_inner - cos_outer)).max(zero).min(one);
                ramp * ramp
            }
            _ => one,
        }
    }

    /// Shadow ray from a surface to this light, and the interval in which a hit occludes the light.
    #[inline(always)]
    pub fn shadow_ray(&self, from: &ShadowRays<'_>, sample: &DeltaLiSample, time: f64) -> (Ray, Interval) {
        let ray = match self.kind.position() {
            Some(position) => from.to(position, time),
            None => from.towards(sample.direction, time),
        };
        let max = self.shadow_end(ray.direction.into());
        (ray, Interval { max, ..Interval::SPAWNED })
    }

    /// Parameter of a shadow ray of this direction at which it ends: hits beyond do not occlude the light.
    #[inline(always)]
    pub(crate) fn shadow_end<R: Real>(&self, direction: Vector3<R>) -> R {
        let like = direction.x;
        match self.kind {
            DeltaLightKind::Directional { .. } => like.splat(Interval::SPAWNED.max),
            DeltaLightKind::Point { shadow_near, .. } if shadow_near > 0.0 => {
                like.splat(1.0) - like.splat(shadow_near) / direction.length() - SHADOW_NEAR_MARGIN
            }
            DeltaLightKind::Point { .. } | DeltaLightKind::Spot { .. } => like.splat(Interval::SEGMENT.max),
        }
    }

    /// Rays from which light tracing starts paths.
    pub(crate) const fn emitted_rays(&self) -> EmittedRays {
        match self.kind {
            DeltaLightKind::Directional { direction } => EmittedRays::Parallel { direction },
            DeltaLightKind::Point { position, falloff, shadow_near } => {
                EmittedRays::Cone { position, axis: DVec3::Z, one_minus_cos: 2.0, start: shadow_near, falloff }
            }
            DeltaLightKind::Spot { position, direction, cos_outer, falloff, .. } => {
                EmittedRays::Cone { position, axis: direction, one_minus_cos: 1.0 - cos_outer, start: 0.0, falloff }
            }
        }
    }

    /// Power: the integral of the intensity over all directions. Directional light enters a bounding sphere of
    /// radius `scene_radius`.
    pub(super) fn power(&self, scene_radius: f64) -> Rgb {
        let measure = match self.kind {
            DeltaLightKind::Point { .. } => 2.0 * TAU,
            // The mean of a squared ramp is 1/3.
            DeltaLightKind::Spot { cos_inner, cos_outer, .. } => {
                TAU * (1.0 - cos_inner + (cos_inner - cos_outer) / 3.0)
            }
            DeltaLightKind::Directional { .. } => PI * scene_radius * scene_radius,
        };
        self.intensity * (self.units.irradiance_factor() * measure)
    }

    /// Bounds of position and directions; `None` for directional light.
    pub(super) fn bounds(&self) -> Option<LightBounds> {
        let position = self.kind.position()?;
        let around = Aabb::new(position, position);
        let power = self.power(0.0);
        Some(match self.kind {
            DeltaLightKind::Spot { direction, cos_outer, .. } => {
                // Light leaves up to π/2 from each normal of the cone.
                let spread = (acos(cos_outer.clamp(-1.0, 1.0)) - FRAC_PI_2).max(0.0);
                LightBounds::new(around, direction, spread, power)
            }
            _ => LightBounds::all_around(around, power),
        })
    }
}

#[cfg(test)]
mod tests;
