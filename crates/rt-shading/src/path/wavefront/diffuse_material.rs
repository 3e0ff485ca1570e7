//! Materials that streams of paths support.

use crate::{
    ColorTexture, Material,
    bsdf::{DiffusePhong, LaneSurface},
    bsdf_cache::uniform_bsdf,
    light::EmissionSides,
};
use rt_math::Rgb;

/// A uniform diffuse material.
#[derive(Clone, Copy, Debug)]
pub(super) struct DiffuseMaterial {
    pub(super) albedo: Rgb,
    /// Emitted radiance of the front and of the back.
    pub(super) emission: [Rgb; 2],
}

impl DiffuseMaterial {
    /// `None` for a material of any other kind.
    pub(super) fn of(material: &Material) -> Option<Self> {
        let surface = uniform_bsdf(material)?.as_lane_surface()?;
        let LaneSurface::DiffusePhong(DiffusePhong { diffuse, highlight: None }) = surface else { return None };
        let ColorTexture::Constant(emission) = material.emission else { return None };
        let back = if material.emission_sides == EmissionSides::Front { Rgb::BLACK } else { emission };
        (diffuse.roughness == 0.0).then_some(Self { albedo: diffuse.albedo, emission: [emission, back] })
    }
}
