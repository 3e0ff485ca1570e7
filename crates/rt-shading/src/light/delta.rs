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
use rt_math::{Aabb, DVec3, Interval, Ray, Rgb};

/// Relative margin inside of `shadow_near`. The surface of a sphere of this radius around the light must fall within it in
/// spite of rounding: shadow rays end this part of their length earlier.
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

    /// Distance from the light up to which surfaces do not shadow it; 0 for none.
    pub const fn shadow_near(&self) -> f64 {
        match *self {
            Self::Point { shadow_near, .. } => shadow_near,
            Self::Spot { .. } | Self::Directional { .. } => 0.0,
        }
    }
}

impl DeltaLight {
    /// Incident light at `point` (world space), without shadows. `None` outside the cone of a spot, and at the light's own
    /// position.
    #[inline(always)]
    pub fn sample_li(&self, point: DVec3) -> Option<DeltaLiSample> {
        let (position, falloff) = match self.kind {
            DeltaLightKind::Directional { direction } => {
                let distance = f64::INFINITY;
                return Some(DeltaLiSample { direction: -direction, strength: self.intensity, distance });
            }
            DeltaLightKind::Point { position, falloff, .. } | DeltaLightKind::Spot { position, falloff, .. } => {
                (position, falloff)
            }
        };
        let distance = (position - point).length();
        let direction = (position - point) / distance;
        if !direction.is_finite() {
            return None;
        }
        let emitted = self.spot_falloff(-direction);
        let attenuated = match falloff {
            Falloff::None => emitted,
            Falloff::InverseSquare => emitted / (distance * distance),
        };
        (emitted > 0.0).then(|| DeltaLiSample { direction, strength: self.intensity * attenuated, distance })
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
    pub(crate) fn is_behind(&self, point: DVec3, normal: DVec3) -> bool {
        match self.kind {
            DeltaLightKind::Directional { .. } => false,
            DeltaLightKind::Point { position, .. } | DeltaLightKind::Spot { position, .. } => {
                let offset = position - point;
                // Far more than the rounding error of the cosine.
                normal.dot(offset) < -SIGN_MARGIN * normal.abs().dot(offset.abs())
            }
        }
    }

    /// Relative intensity, 0 to 1, in the direction `wo` (unit) in which light leaves.
    #[inline]
    pub(crate) fn spot_falloff(&self, wo: DVec3) -> f64 {
        match self.kind {
            DeltaLightKind::Spot { direction, cos_inner, cos_outer, .. } => {
                // The squared ramp of KHR_lights_punctual.
                let ramp = ((wo.dot(direction) - cos_outer) / (cos_inner - cos_outer)).clamp(0.0, 1.0);
                ramp * ramp
            }
            _ => 1.0,
        }
    }

    /// Shadow ray from a surface to this light, and the interval in which a hit occludes the light.
    #[inline(always)]
    pub fn shadow_ray(&self, from: &ShadowRays<'_>, sample: &DeltaLiSample, time: f64) -> (Ray, Interval) {
        match self.kind {
            DeltaLightKind::Directional { .. } => (from.towards(sample.direction, time), Interval::SPAWNED),
            DeltaLightKind::Point { position, shadow_near, .. } if shadow_near > 0.0 => {
                let ray = from.to(position, time);
                let max = 1.0 - shadow_near / ray.direction.length() - SHADOW_NEAR_MARGIN;
                (ray, Interval { max, ..Interval::SEGMENT })
            }
            DeltaLightKind::Point { position, .. } | DeltaLightKind::Spot { position, .. } => {
                (from.to(position, time), Interval::SEGMENT)
            }
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

    /// Power: the integral of the intensity over all directions. Directional light enters a scene within a ball of
    /// `scene_radius`.
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
mod tests {
    use super::*;
    use rt_geometry::SurfaceInteraction;

    fn light(kind: DeltaLightKind) -> DeltaLight {
        DeltaLight {
            name: String::new(),
            kind,
            intensity: Rgb::gray(8.0),
            units: LightUnits::Classical,
            casts_shadows: true,
        }
    }

    #[test]
    fn falloff_is_none_or_inverse_square() {
        let at = DVec3::new(0.0, 2.0, 0.0);
        let none = light(DeltaLightKind::Point { position: at, falloff: Falloff::None, shadow_near: 0.0 });
        let square = light(DeltaLightKind::Point { position: at, falloff: Falloff::InverseSquare, shadow_near: 0.0 });
        assert_eq!(none.sample_li(DVec3::ZERO).expect("lit").strength, Rgb::gray(8.0));
        let lit = square.sample_li(DVec3::ZERO).expect("lit");
        assert_eq!((lit.strength, lit.direction, lit.distance), (Rgb::gray(2.0), DVec3::Y, 2.0));
        assert_eq!(square.sample_li(at), None, "a point at the light itself");
    }

    #[test]
    fn a_spot_has_a_core_a_ramp_and_an_edge() {
        let spot = light(DeltaLightKind::Spot {
            position: DVec3::Y,
            direction: DVec3::NEG_Y,
            cos_inner: 0.9,
            cos_outer: 0.7,
            falloff: Falloff::None,
        });
        // A point below the spot whose direction has cosine c with the axis.
        let below = |c: f64| DVec3::new((1.0 - c * c).sqrt() / c, 0.0, 0.0);
        assert_eq!(spot.sample_li(below(0.95)).expect("core").strength, Rgb::gray(8.0));
        let ramp = spot.sample_li(below(0.8)).expect("ramp").strength.r;
        assert!((ramp - 8.0 * 0.25).abs() < 1e-12, "{ramp}");
        assert_eq!(spot.sample_li(below(0.69)), None);
    }

    #[test]
    fn lights_behind_a_surface_are_known_without_their_distance() {
        let at = |position: DVec3| light(DeltaLightKind::Point { position, falloff: Falloff::None, shadow_near: 0.0 });
        let (point, normal) = (DVec3::new(0.3, -1.7, 2.9), DVec3::new(0.48, -0.6, 0.64));
        let mut n_behind = 0;
        for i in 0..10_000u32 {
            let number = |k: u64| rt_math::random::unit(rt_math::random::hash(&[3, u64::from(i), k])) - 0.5;
            let aside = DVec3::new(number(0), number(1), number(2));
            // Some next to the plane of the surface, to the last bit.
            let aside = if i % 2 == 0 { aside } else { aside - normal * normal.dot(aside) };
            let light = at(point + aside * 8.0);
            let cosine = light.sample_li(point).map(|lit| normal.dot(lit.direction));
            if light.is_behind(point, normal) {
                assert!(cosine < Some(0.0), "{cosine:?}");
                n_behind += 1;
            } else {
                assert!(cosine > Some(-1e-11), "{cosine:?}");
            }
        }
        assert!(n_behind > 2000, "{n_behind}");
        assert!(!at(point).is_behind(point, normal));
    }

    #[test]
    fn a_sphere_around_a_light_does_not_shadow_it() {
        let kind = DeltaLightKind::Point { position: DVec3::Y * 4.0, falloff: Falloff::None, shadow_near: 1.0 };
        let surface = SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Y, [0.0; 2]);
        let light = light(kind);
        let (ray, span) =
            light.shadow_ray(&surface.shadow_rays(false), &light.sample_li(DVec3::ZERO).expect("lit"), 0.0);
        let end = ray.at(span.max).y;
        assert!(end < 3.0 && end > 3.0 - 1e-11, "{end}");
    }

    #[test]
    fn an_offset_shadow_ray_ends_outside_shadow_near() {
        let light = light(DeltaLightKind::Point { position: DVec3::Y * 4.0, falloff: Falloff::None, shadow_near: 1.0 });
        for lift in [0.5, -0.5] {
            let surface = SurfaceInteraction {
                shadow_point: DVec3::Y * lift,
                ..SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Y * lift.signum(), [0.0; 2])
            };
            let lit = light.sample_li(surface.point).expect("lit");
            let (ray, span) = light.shadow_ray(&surface.shadow_rays(false), &lit, 0.0);
            let end = ray.at(span.max).y;
            assert!(end < 3.0 && end > 3.0 - 1e-10, "{end}");
        }
    }

    /// Over directions uniform in the cosine with the axis, the mean intensity times 4π is the power.
    #[test]
    fn power_is_the_integral_of_the_intensity() {
        let (position, falloff) = (DVec3::new(1.0, 2.0, 3.0), Falloff::InverseSquare);
        let n = 20_000;
        for kind in [
            DeltaLightKind::Point { position, falloff, shadow_near: 0.0 },
            DeltaLightKind::Spot { position, direction: DVec3::Z, cos_inner: 0.9, cos_outer: 0.2, falloff },
        ] {
            let light = light(kind);
            let mut mean = Rgb::BLACK;
            for i in 0..n {
                let cos = 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0;
                let wo = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let incident = light.sample_irradiance(position + wo).map_or(Rgb::BLACK, |sample| sample.radiance);
                mean += incident * f64::from(n).recip();
            }
            assert!((4.0 * PI * mean.g / light.power(7.0).g - 1.0).abs() < 1e-4, "{kind:?}");
            assert!((light.bounds().expect("bounds").power() / light.power(7.0).luminance() - 1.0).abs() < 1e-12);
        }
        let sun = light(DeltaLightKind::Directional { direction: DVec3::NEG_Y });
        assert!((sun.power(3.0).g / (9.0 * PI * 8.0 * PI) - 1.0).abs() < 1e-12 && sun.bounds().is_none());
    }

    #[test]
    fn bounds_hold_all_points_that_a_light_reaches() {
        let (position, direction, falloff) = (DVec3::ZERO, DVec3::Z, Falloff::InverseSquare);
        for cos_outer in [0.5, 0.0, -0.6] {
            let light = light(DeltaLightKind::Spot { position, direction, cos_inner: 0.9, cos_outer, falloff });
            let bounds = light.bounds().expect("bounds");
            for i in 0..200 {
                let cos = f64::from(i) / 100.0 - 1.0 + 0.005;
                let point = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let is_reached = light.sample_li(point).is_some();
                assert!(!is_reached || bounds.importance(point, None) > 0.0, "{cos_outer}: {cos}");
            }
        }
    }
}
