//! BSDFs of uniform materials, computed once.

use crate::{
    Appearance, Material, MaterialEvalContext,
    bsdf::{Bsdf, LaneSurface},
};
use rt_geometry::SurfaceInteraction;
use rt_math::DVec3;

/// BSDFs of [uniform](crate::Material::is_uniform) materials, computed once and not at every hit. The default is empty: all
/// BSDFs are computed at the hit.
#[derive(Clone, Debug, Default)]
pub struct BsdfCache {
    /// BSDF by material.
    bsdfs: Vec<Option<Box<CachedBsdf>>>,
    n_used: usize,
}

/// BSDF of a material, and the part of it without diffuse lobes.
#[derive(Clone, Debug)]
pub(crate) struct CachedBsdf {
    pub(crate) bsdf: Bsdf,
    /// Result of [`Bsdf::without_diffuse`].
    pub(crate) without_diffuse: Option<Bsdf>,
    /// Result of [`Bsdf::as_lane_surface`].
    pub(crate) in_lanes: Option<LaneSurface>,
}

impl CachedBsdf {
    fn new(bsdf: Bsdf) -> Self {
        Self { in_lanes: bsdf.as_lane_surface(), without_diffuse: bsdf.without_diffuse(), bsdf }
    }
}

/// BSDF of a [uniform](Material::is_uniform) material; `None` for all others.
pub(crate) fn uniform_bsdf(material: &Material) -> Option<Bsdf> {
    let anywhere = SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Z, [0.0; 2]);
    let point = MaterialEvalContext { textures: &[], surface: &anywhere, ior: 1.0 };
    material.is_uniform().then(|| material.bsdf(&point))
}

impl BsdfCache {
    /// BSDFs of the materials of an appearance that are `used`.
    pub fn new(appearance: &Appearance, used: impl Fn(usize) -> bool) -> Self {
        let materials = || appearance.materials.iter().enumerate().map(|(index, material)| (used(index), material));
        let bsdfs = materials()
            .map(|(is_used, material)| {
                let bsdf = if is_used { uniform_bsdf(material) } else { None };
                bsdf.map(|bsdf| Box::new(CachedBsdf::new(bsdf)))
            })
            .collect();
        Self { bsdfs, n_used: materials().filter(|(is_used, _)| *is_used).count() }
    }

    /// Numbers of cached materials and of used materials.
    pub fn count(&self) -> (usize, usize) {
        (self.bsdfs.iter().flatten().count(), self.n_used)
    }

    /// BSDF of a material; `None` if it must be computed at the hit.
    pub(crate) fn get(&self, material: u32) -> Option<&CachedBsdf> {
        self.bsdfs.get(material as usize)?.as_deref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        ColorTexture, FloatTexture, InteriorMedium, LayeredBase, LayeredSurface, MaterialModel, Phong, TextureId,
    };
    use rt_geometry::VertexAttributes;
    use rt_math::{Rgb, Vec3};

    #[test]
    fn only_uniform_materials_are_cached() {
        let grey = ColorTexture::Constant(Rgb::gray(0.5));
        let textured = ColorTexture::Textured(TextureId(0), Rgb::WHITE);
        let glass = MaterialModel::Dielectric { roughness: 0.0, transmittance: grey };
        let phong = |phong: Phong| Material::new(String::new(), phong);
        let physical = |model: MaterialModel| Material::new(String::new(), model);
        let base = LayeredBase::MetallicRoughness {
            base_color: grey,
            metallic: FloatTexture::Constant(0.2),
            roughness: FloatTexture::Constant(0.3),
        };
        let layered = |changed: fn(&mut LayeredSurface)| {
            let mut surface = LayeredSurface::new(base.clone());
            changed(&mut surface);
            physical(MaterialModel::Layered(Box::new(surface)))
        };
        let thin_glass = MaterialModel::ThinGlass { ior: 1.5, transmittance: grey };
        let alike = [
            phong(Phong { specular: grey, ..Phong::default() }),
            physical(MaterialModel::Diffuse { albedo: grey, roughness: 0.3 }),
            layered(|surface| surface.clearcoat = FloatTexture::Constant(0.5)),
            physical(thin_glass),
        ];
        let varying = [
            phong(Phong { diffuse: textured, ..Phong::default() }),
            Material { interior: Some(InteriorMedium::clear(1.5)), ..physical(glass) },
            physical(MaterialModel::Mix(vec![(1.0, MaterialModel::Diffuse { albedo: textured, roughness: 0.0 })])),
            layered(|surface| surface.anisotropy = FloatTexture::Constant(0.9)),
            layered(|surface| {
                surface.clearcoat_roughness = FloatTexture::textured(&[], TextureId(0), crate::Channel::Red, 1.0)
            }),
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
                let at_a_hit = material.bsdf(&MaterialEvalContext { textures: &[], surface: &surface, ior: 1.0 });
                assert_eq!((made.bsdf, made.without_diffuse), (at_a_hit, at_a_hit.without_diffuse()), "{index}");
            }
        }
        assert!(constant.get(100).is_none());
        assert_eq!(BsdfCache::new(&appearance, |material| material == 1).count(), (1, 1));
    }
}
