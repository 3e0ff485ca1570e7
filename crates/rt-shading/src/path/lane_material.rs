//! Materials that are shaded in lanes.

use super::{settings::Lighting, transport::Transport};
use crate::{
    ColorTexture, Material, MaterialModel, ShadingFeatures,
    bsdf::{DiffusePhong, GlassSurface, LaneSurface, OrenNayar},
    bsdf_cache::uniform_bsdf,
    light::{EmissionSides, Light},
    wavefront::{delta_lights::light_fits_f32, is_in_range},
};
use rt_geometry::SurfaceInteraction;
use rt_math::{DVec3, Rgb};

/// A uniform material that is shaded in lanes everywhere: opaque, or the surface of a solid.
#[derive(Clone, Copy, Debug)]
pub(super) struct LaneMaterial {
    pub(super) surface: LaneSurface,
    /// Emitted radiance of the front and of the back.
    pub(super) emission: [Rgb; 2],
    /// Coefficient of ambient light.
    pub(super) ambient: Rgb,
}

/// Materials of a scene by index; `None` for those that are not shaded in lanes everywhere. The BSDF of a hit on one of these may still
/// have a version for lanes.
#[derive(Clone, Debug)]
pub(super) struct LaneMaterials {
    materials: Vec<Option<LaneMaterial>>,
    /// False if all hits are shaded one by one: a light does not fit `f32`, or diffuse lobes are sampled and paths end
    /// behind them.
    pub(super) has_lanes: bool,
    /// True if a surface may change the [`WavePathState`](super::path_stream::WavePathState) of paths.
    pub(super) track_states: bool,
    /// True if shadow rays pass the surfaces of media that absorb ([`Appearance::has_shadow_media`](crate::Appearance::has_shadow_media)).
    pub(super) has_shadow_media: bool,
    /// Kind of all materials, if it is the same.
    pub(super) kind: Option<VertexKind>,
}

/// Group of hits by the code that shades them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd)]
pub(super) enum VertexKind {
    /// The ray has missed everything, or its hit is shaded by itself.
    #[default]
    Done,
    /// The path ends after emission.
    EmissionOnly,
    /// Lambert's law.
    Diffuse,
    /// A rough diffuse lobe.
    RoughDiffuse,
    /// A diffuse lobe and a Phong lobe, perhaps with a mirror.
    Glossy,
    /// The metallic-roughness model.
    MetallicRoughness,
    /// The layered model.
    Layered,
    /// A rough metal.
    Conductor,
    /// A smooth metal or a mirror.
    Mirror,
    /// A smooth interface of a dielectric.
    Glass,
    /// A rough interface of a dielectric.
    RoughGlass,
}

impl VertexKind {
    pub(super) fn of(surface: &LaneSurface) -> Self {
        match surface {
            LaneSurface::DiffusePhong(DiffusePhong { highlight: Some(_), .. }) | LaneSurface::MirrorMix(_) => {
                Self::Glossy
            }
            LaneSurface::DiffusePhong(DiffusePhong { diffuse: OrenNayar { roughness, .. }, .. }) => {
                if *roughness > 0.0 { Self::RoughDiffuse } else { Self::Diffuse }
            }
            LaneSurface::MetallicRoughness(_) => Self::MetallicRoughness,
            LaneSurface::Layered(_) => Self::Layered,
            LaneSurface::Conductor(conductor) if !conductor.is_smooth() => Self::Conductor,
            LaneSurface::Conductor(_) | LaneSurface::Mirror(_) => Self::Mirror,
            LaneSurface::Glass(glass) if glass.is_smooth() => Self::Glass,
            LaneSurface::Glass(_) => Self::RoughGlass,
        }
    }

    /// True if a number chooses the lobe that is sampled.
    pub(super) const fn chooses_lobe(self) -> bool {
        matches!(self, Self::Glossy | Self::MetallicRoughness | Self::Layered | Self::Glass | Self::RoughGlass)
    }

    /// True if all lobes are delta distributions: light is not sampled.
    pub(super) const fn is_delta(self) -> bool {
        matches!(self, Self::Mirror | Self::Glass)
    }

    /// True if diffuse reflection is all there is.
    pub(super) const fn is_diffuse(self) -> bool {
        matches!(self, Self::Diffuse | Self::RoughDiffuse)
    }
}

impl LaneMaterials {
    /// Materials of a scene. None is shaded in lanes where diffuse lobes are sampled and paths end behind them.
    pub(super) fn new(lighting: Lighting<'_>, transport: Transport, features: &ShadingFeatures) -> Self {
        let has_shadow_media = lighting.appearance.has_shadow_media(features);
        let has_lanes = transport != Transport::SpecularWithEmitters && lighting.lights.lights().iter().all(fits_f32);
        // The media of shadow rays from glass are found one by one.
        let stays = |it: &LaneMaterial| !(has_shadow_media && it.is_glass());
        let of = |material| if has_lanes { LaneMaterial::of(material).filter(stays) } else { None };
        let materials: Vec<_> = lighting.appearance.materials.iter().map(of).collect();
        let keeps_states = |material: &Option<LaneMaterial>| {
            material.is_some_and(|material| matches!(material.surface, LaneSurface::DiffusePhong(_)))
        };
        let kind_of =
            |material: &Option<LaneMaterial>| material.as_ref().map(|material| VertexKind::of(&material.surface));
        let kind = materials.first().and_then(kind_of);
        let kind = kind.filter(|_| materials.iter().all(|material| kind_of(material) == kind));
        let track_states = !materials.iter().all(keeps_states);
        Self { materials, has_lanes, track_states, has_shadow_media, kind }
    }

    /// Material of an index; `None` if it is not shaded in lanes everywhere.
    #[inline(always)]
    pub(super) fn get(&self, index: u32) -> Option<&LaneMaterial> {
        self.materials.get(index as usize)?.as_ref()
    }
}

/// True if the radiance of both sides of an emitter is in range ([`is_in_range`]), for delta lights as
/// [`light_fits_f32`] says. Environments are not tested.
fn fits_f32(light: &Light) -> bool {
    match light {
        Light::Delta(light) => light_fits_f32(light),
        Light::Environment(_) => true,
        _ => [DVec3::Z, DVec3::NEG_Z].iter().all(|direction| is_in_range(light.le(*direction, DVec3::Z))),
    }
}

impl LaneMaterial {
    /// True for the surface of a solid dielectric.
    pub(super) const fn is_glass(&self) -> bool {
        matches!(self.surface, LaneSurface::Glass(_))
    }

    fn of(material: &Material) -> Option<Self> {
        let ColorTexture::Constant(emission) = material.emission else { return None };
        if let Some(glass) = glass(material).filter(|_| emission.is_black()) {
            let (surface, ambient) = (LaneSurface::Glass(glass), ambient(material));
            return Some(Self { surface, emission: [Rgb::BLACK; 2], ambient });
        }
        let is_opaque = material.interior.is_none() && !material.model.is_transmissive();
        if !is_opaque || material.has_coated_emission() || !is_in_range(emission) {
            return None;
        }
        let surface = uniform_bsdf(material)?.as_lane_surface()?;
        let back = if material.emission_sides == EmissionSides::Front { Rgb::BLACK } else { emission };
        Some(Self { surface, emission: [emission, back], ambient: ambient(material) })
    }
}

/// Coefficient of ambient light of a material without textures.
fn ambient(material: &Material) -> Rgb {
    let anywhere = SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Z, [0.0; 2]);
    material.ambient(&material.to_phong(), &[], &anywhere)
}

/// Surface of a solid dielectric without textures, if it can be shaded in lanes.
fn glass(material: &Material) -> Option<GlassSurface> {
    let interior = material.interior.as_ref()?;
    let MaterialModel::Dielectric { roughness, transmittance: ColorTexture::Constant(transmittance) } = material.model
    else {
        return None;
    };
    GlassSurface::new(transmittance, roughness, interior.ior).filter(|_| !material.needs_detail())
}
