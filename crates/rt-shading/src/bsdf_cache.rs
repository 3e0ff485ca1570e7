//! BSDFs of uniform materials, computed once.

use crate::{Appearance, PhysicalPoint, bsdf::Bsdf, path::transport::Transport};
use rt_geometry::SurfaceInteraction;
use rt_math::DVec3;

/// The BSDFs of the materials that [scatter alike everywhere](crate::Material::is_uniform): made once, and
/// not at every hit. By `default()` there are none, and all are made at the hit.
#[derive(Clone, Debug, Default)]
pub struct BsdfCache {
    /// By material.
    of: Vec<Option<Box<CachedBsdf>>>,
    n_used: usize,
}

/// BSDF of a material, and the part of it without diffuse lobes.
#[derive(Clone, Debug)]
pub(crate) struct CachedBsdf {
    pub(crate) bsdf: Bsdf,
    /// Result of [`Bsdf::without_diffuse`]; `None` also if unused.
    pub(crate) without_diffuse: Option<Bsdf>,
}

impl CachedBsdf {
    /// With all that is followed of it.
    pub(crate) fn new(bsdf: Bsdf, transport: Transport) -> Self {
        let without_diffuse = if transport == Transport::Specular { bsdf.without_diffuse() } else { None };
        Self { bsdf, without_diffuse }
    }
}

impl BsdfCache {
    /// Those of an appearance, of materials that are `used`.
    pub fn new(appearance: &Appearance, used: impl Fn(usize) -> bool) -> Self {
        let anywhere = SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Z, [0.0; 2]);
        let point = PhysicalPoint { textures: &appearance.textures, surface: &anywhere, ior: 1.0 };
        let materials = || appearance.materials.iter().enumerate().map(|(index, material)| (used(index), material));
        let of = materials().map(|(is_used, material)| {
            let is_made = is_used && material.is_uniform();
            is_made.then(|| Box::new(CachedBsdf::new(material.bsdf(&point), Transport::Specular)))
        });
        Self { of: of.collect(), n_used: materials().filter(|(is_used, _)| *is_used).count() }
    }

    /// The number of materials that have one, and of those that are used.
    pub fn count(&self) -> (usize, usize) {
        (self.of.iter().flatten().count(), self.n_used)
    }

    /// BSDF of a material; `None` if it must be computed at the hit.
    pub(crate) fn get(&self, material: u32) -> Option<&CachedBsdf> {
        self.of.get(material as usize)?.as_deref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        ColorTexture, FloatTexture, LayeredBase, LayeredSurface, Material, Phong, Physical, TextureId, Transmission,
    };
    use rt_geometry::VertexAttributes;
    use rt_math::{Rgb, Vec3};

    #[test]
    fn only_what_is_the_same_everywhere_is_made_once() {
        let grey = ColorTexture::Constant(Rgb::gray(0.5));
        let textured = ColorTexture::Textured(TextureId(0), Rgb::WHITE);
        let glass = Transmission { coefficient: grey, ior: 1.5, fresnel: true, absorption: Rgb::BLACK, priority: 0 };
        let phong = |phong| Material::new(String::new(), phong);
        let physical = |physical| Material { physical: Some(physical), ..phong(Phong::default()) };
        let base = LayeredBase::MetallicRoughness {
            base_color: grey,
            metallic: FloatTexture::Constant(0.2),
            roughness: FloatTexture::Constant(0.3),
        };
        let layered = |changed: fn(&mut LayeredSurface)| {
            let mut surface = LayeredSurface::new(base.clone());
            changed(&mut surface);
            physical(Physical::Layered(Box::new(surface)))
        };
        let pane = Physical::ThinGlass { ior: 1.5, transmittance: grey };
        let alike = [
            phong(Phong { specular: grey, ..Phong::default() }),
            physical(Physical::Diffuse { albedo: grey, roughness: 0.3 }),
            layered(|surface| surface.coat = FloatTexture::Constant(0.5)),
            Material { physical: Some(pane), ..phong(Phong { transmission: Some(glass), ..Phong::default() }) },
        ];
        let varying = [
            phong(Phong { diffuse: textured, ..Phong::default() }),
            phong(Phong { transmission: Some(glass), ..Phong::default() }),
            physical(Physical::Mix(vec![(1.0, Physical::Diffuse { albedo: textured, roughness: 0.0 })])),
            layered(|surface| surface.anisotropy = FloatTexture::Constant(0.9)),
            layered(|surface| surface.coat_roughness = FloatTexture::Textured(TextureId(0), crate::Channel::Red, 1.0)),
        ];
        let n_alike = alike.len();
        let materials: Vec<_> = alike.into_iter().chain(varying).collect();
        let appearance = Appearance { materials, ..Appearance::default() };
        let constant = BsdfCache::new(&appearance, |_| true);
        assert_eq!(constant.count(), (n_alike, appearance.materials.len()));
        let mut surface = SurfaceInteraction::flat(DVec3::ONE, DVec3::ZERO, DVec3::X, [0.3, 0.7]);
        surface.detail = VertexAttributes { tangent: Vec3::Y, color: [0.1, 0.2, 0.3], ..VertexAttributes::NONE };
        for (index, material) in appearance.materials.iter().enumerate() {
            let made = constant.get(index as u32);
            assert_eq!(made.is_some(), index < n_alike, "{index}");
            if let Some(made) = made {
                let at_a_hit = material.bsdf(&PhysicalPoint { textures: &[], surface: &surface, ior: 1.0 });
                assert_eq!((made.bsdf, made.without_diffuse), (at_a_hit, at_a_hit.without_diffuse()), "{index}");
            }
        }
        assert!(constant.get(100).is_none());
        assert_eq!(BsdfCache::new(&appearance, |material| material == 1).count(), (1, 1));
    }
}
