//! Lights without extent.

use rt_math::{DVec3, Rgb};

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
        /// Radius of the lamp around the light: surfaces nearer to the light than this don't shadow it. 0 for none.
        lamp_radius: f64,
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

/// A light without extent.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// For messages.
    pub name: String,
    /// Where it stands and where it shines.
    pub kind: LightKind,
    /// Strength: with inverse-square falloff the intensity at unit distance, otherwise the strength at any distance.
    pub intensity: Rgb,
    /// Whether objects cast shadows in this light.
    pub casts_shadows: bool,
}
