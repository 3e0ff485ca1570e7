//! Lights without extent.

use core::f64::consts::{FRAC_1_PI, PI};

use rt_geometry::ShadowRays;
use rt_math::{DVec3, Interval, Ray, Rgb};

/// A lamp of radius r is usually a sphere of radius r, and its surface must fall inside in spite of rounding: the way
/// to the light ends this part of the distance earlier.
const LAMP_MARGIN: f64 = 1.0 / (1u64 << 40) as f64;

/// A sum of three products has the sign of the rounded one if it is greater than this part of the sum of their sizes.
const CERTAIN: f64 = 1.0 / (1u64 << 40) as f64;

/// How light weakens with the distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Falloff {
    /// Not at all: the classical ray tracer's light.
    None,
    /// With the square of the distance, as real light does.
    InverseSquare,
}

/// Where a light stands and where it shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// In all directions from a point.
    Point {
        /// World space.
        position: DVec3,
        /// Falloff.
        falloff: Falloff,
        /// Surfaces at this distance from the light or nearer cast no shadow in it; 0 for none. No established term.
        shadow_near: f64,
    },
    /// Parallel rays from infinitely far away.
    Directional {
        /// Unit vector in which the light travels, world space.
        direction: DVec3,
    },
    /// From a point, within a cone.
    Spot {
        /// World space.
        position: DVec3,
        /// Unit vector along the axis, in which the light travels, world space.
        direction: DVec3,
        /// Cosine of the angle from the axis up to which the light has full strength.
        cos_inner: f64,
        /// Cosine of the angle from the axis beyond which there is no light; less than `cos_inner`.
        cos_outer: f64,
        /// Falloff.
        falloff: Falloff,
    },
}

/// Meaning of the intensity of a light without extent.
///
/// A white Lambertian surface, lit straight by a strength of 1, has this radiance under every integrator:
///
/// | units | radiance | strength |
/// |---|---|---|
/// | [`Classical`](Self::Classical) | 1 | reflected by a coefficient kd, without 1/π |
/// | [`Physical`](Self::Physical) | 1/π | irradiance, from radiant intensity or luminous intensity |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LightUnits {
    /// Shares of white, as in classical ray tracers.
    #[default]
    Classical,
    /// Intensity (W/sr, cd) of point lights and spots, irradiance (W/m², lx) of directional lights, in the units of the
    /// radiance of emissive surfaces and environments.
    Physical,
}

/// A light without extent.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// For messages.
    pub name: String,
    /// Where it stands and where it shines.
    pub kind: LightKind,
    /// Strength: with inverse-square falloff the intensity at unit distance, otherwise the strength at any distance.
    pub intensity: Rgb,
    /// Meaning of the intensity.
    pub units: LightUnits,
    /// Whether objects cast shadows in this light.
    pub casts_shadows: bool,
}

/// What a light does at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Illumination {
    /// Unit vector towards the light.
    pub direction: DVec3,
    /// Strength of the light here in its own units, before shadows and the cosine.
    pub strength: Rgb,
    /// Distance to the light; infinite for directional light.
    pub distance: f64,
}

impl LightUnits {
    /// Factor from a strength to the irradiance that a BSDF reflects.
    pub const fn irradiance_factor(self) -> f64 {
        match self {
            Self::Classical => PI,
            Self::Physical => 1.0,
        }
    }

    /// Factor from a strength to what the coefficients of a classical surface reflect.
    pub const fn classical_factor(self) -> f64 {
        match self {
            Self::Classical => 1.0,
            Self::Physical => FRAC_1_PI,
        }
    }
}

impl Light {
    /// The unshadowed light at `point` (world space). `None` where the light does not reach: outside the cone of a
    /// spot, or at the very place of the light.
    #[inline(always)]
    pub fn illuminate(&self, point: DVec3) -> Option<Illumination> {
        let (position, falloff) = match self.kind {
            LightKind::Directional { direction } => {
                let distance = f64::INFINITY;
                return Some(Illumination { direction: -direction, strength: self.intensity, distance });
            }
            LightKind::Point { position, falloff, .. } | LightKind::Spot { position, falloff, .. } => {
                (position, falloff)
            }
        };
        let distance = (position - point).length();
        let direction = (position - point) / distance;
        if !direction.is_finite() {
            return None;
        }
        let beam = self.beam(-direction);
        let weakened = match falloff {
            Falloff::None => beam,
            Falloff::InverseSquare => beam / (distance * distance),
        };
        (beam > 0.0).then(|| Illumination { direction, strength: self.intensity * weakened, distance })
    }

    /// True if the light certainly stands behind a surface with this normal: the cosine that [`illuminate`](Self::illuminate)
    /// leads to would not be positive. It takes no distance to know.
    #[inline(always)]
    pub(crate) fn is_behind(&self, point: DVec3, normal: DVec3) -> bool {
        match self.kind {
            LightKind::Directional { .. } => false,
            LightKind::Point { position, .. } | LightKind::Spot { position, .. } => {
                let way = position - point;
                // Far more than rounding may do to the cosine.
                normal.dot(way) < -CERTAIN * normal.abs().dot(way.abs())
            }
        }
    }

    /// Strength, 0 to 1, of the light that leaves along `away` (unit).
    #[inline]
    pub(crate) fn beam(&self, away: DVec3) -> f64 {
        match self.kind {
            LightKind::Spot { direction, cos_inner, cos_outer, .. } => {
                // The squared ramp of KHR_lights_punctual.
                let ramp = ((away.dot(direction) - cos_outer) / (cos_inner - cos_outer)).clamp(0.0, 1.0);
                ramp * ramp
            }
            _ => 1.0,
        }
    }

    /// The ray to ask for blockers between a surface and this light, and the part of it that counts.
    #[inline(always)]
    pub fn shadow_ray(&self, from: &ShadowRays<'_>, light: &Illumination, time: f64) -> (Ray, Interval) {
        match self.kind {
            LightKind::Directional { .. } => (from.towards(light.direction, time), Interval::SPAWNED),
            LightKind::Point { position, shadow_near, .. } if shadow_near > 0.0 => {
                let ray = from.to(position, time);
                let free = 1.0 - shadow_near / ray.direction.length() - LAMP_MARGIN;
                (ray, Interval { max: free, ..Interval::SEGMENT })
            }
            LightKind::Point { position, .. } | LightKind::Spot { position, .. } => {
                (from.to(position, time), Interval::SEGMENT)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_geometry::SurfaceInteraction;

    fn light(kind: LightKind) -> Light {
        Light {
            name: String::new(),
            kind,
            intensity: Rgb::gray(8.0),
            units: LightUnits::Classical,
            casts_shadows: true,
        }
    }

    #[test]
    fn falloff_is_as_asked() {
        let at = DVec3::new(0.0, 2.0, 0.0);
        let none = light(LightKind::Point { position: at, falloff: Falloff::None, shadow_near: 0.0 });
        let square = light(LightKind::Point { position: at, falloff: Falloff::InverseSquare, shadow_near: 0.0 });
        assert_eq!(none.illuminate(DVec3::ZERO).expect("lit").strength, Rgb::gray(8.0));
        let lit = square.illuminate(DVec3::ZERO).expect("lit");
        assert_eq!((lit.strength, lit.direction, lit.distance), (Rgb::gray(2.0), DVec3::Y, 2.0));
        assert_eq!(square.illuminate(at), None, "a point at the light itself");
    }

    #[test]
    fn a_spot_has_a_core_a_ramp_and_an_edge() {
        let spot = light(LightKind::Spot {
            position: DVec3::Y,
            direction: DVec3::NEG_Y,
            cos_inner: 0.9,
            cos_outer: 0.7,
            falloff: Falloff::None,
        });
        // A point below the spot whose direction has cosine c with the axis.
        let below = |c: f64| DVec3::new((1.0 - c * c).sqrt() / c, 0.0, 0.0);
        assert_eq!(spot.illuminate(below(0.95)).expect("core").strength, Rgb::gray(8.0));
        let ramp = spot.illuminate(below(0.8)).expect("ramp").strength.r;
        assert!((ramp - 8.0 * 0.25).abs() < 1e-12, "{ramp}");
        assert_eq!(spot.illuminate(below(0.69)), None);
    }

    #[test]
    fn lights_behind_a_surface_are_known_without_their_distance() {
        let at = |position: DVec3| light(LightKind::Point { position, falloff: Falloff::None, shadow_near: 0.0 });
        let (point, normal) = (DVec3::new(0.3, -1.7, 2.9), DVec3::new(0.48, -0.6, 0.64));
        let mut n_behind = 0;
        for i in 0..10_000u32 {
            let number = |k: u64| rt_math::random::unit(rt_math::random::hash(&[3, u64::from(i), k])) - 0.5;
            let aside = DVec3::new(number(0), number(1), number(2));
            // Some next to the plane of the surface, to the last bit.
            let aside = if i % 2 == 0 { aside } else { aside - normal * normal.dot(aside) };
            let light = at(point + aside * 8.0);
            let cosine = light.illuminate(point).map(|lit| normal.dot(lit.direction));
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
    fn the_lamp_around_a_light_does_not_shadow_it() {
        let kind = LightKind::Point { position: DVec3::Y * 4.0, falloff: Falloff::None, shadow_near: 1.0 };
        let surface = SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Y, [0.0; 2]);
        let light = light(kind);
        let (ray, span) =
            light.shadow_ray(&surface.shadow_rays(false), &light.illuminate(DVec3::ZERO).expect("lit"), 0.0);
        let end = ray.at(span.max).y;
        assert!(end < 3.0 && end > 3.0 - 1e-11, "{end}");
    }

    #[test]
    fn a_lifted_shadow_ray_ends_in_front_of_the_lamp() {
        let lamp = light(LightKind::Point { position: DVec3::Y * 4.0, falloff: Falloff::None, shadow_near: 1.0 });
        for lift in [0.5, -0.5] {
            let surface = SurfaceInteraction {
                shadow_point: DVec3::Y * lift,
                ..SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Y * lift.signum(), [0.0; 2])
            };
            let lit = lamp.illuminate(surface.point).expect("lit");
            let (ray, span) = lamp.shadow_ray(&surface.shadow_rays(false), &lit, 0.0);
            let end = ray.at(span.max).y;
            assert!(end < 3.0 && end > 3.0 - 1e-10, "{end}");
        }
    }
}
