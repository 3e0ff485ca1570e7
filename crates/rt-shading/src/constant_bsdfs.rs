//! What materials do to light, where that is the same at every point.

use crate::{Appearance, Material, PhysicalPoint, bsdf::Bsdf, path::Follows};
use rt_geometry::SurfaceInteraction;
use rt_math::DVec3;

/// The BSDFs of the materials that have no textures: made once, and not at every hit.
///
/// A transparent body is not among them, as it depends on what is on both sides of its surface.
#[derive(Clone, Debug, Default)]
pub struct ConstantBsdfs {
    /// By material.
    of: Vec<Option<Scatterer>>,
}

/// A surface that scatters light.
#[derive(Clone, Debug)]
pub(crate) struct Scatterer {
    pub(crate) bsdf: Bsdf,
    /// As [`Bsdf::without_diffuse`] has it; `None` also where it is not asked for.
    pub(crate) without_diffuse: Option<Bsdf>,
}

impl Scatterer {
    /// A surface with all that is followed of it.
    pub(crate) fn new(bsdf: Bsdf, follows: Follows) -> Self {
        let without_diffuse = if follows == Follows::Reflections { bsdf.without_diffuse() } else { None };
        Self { bsdf, without_diffuse }
    }
}

impl ConstantBsdfs {
    /// Those of an appearance, for integrators that follow this light.
    pub fn new(appearance: &Appearance, follows: Follows) -> Self {
        let anywhere = SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Z, [0.0; 2]);
        let point = PhysicalPoint { textures: &appearance.textures, surface: &anywhere, ior: 1.0 };
        let is_constant = |material: &&Material| material.phong.transmission.is_none() && !material.needs_detail();
        let made = |material: &Material| Scatterer::new(material.bsdf(&point), follows);
        Self { of: appearance.materials.iter().map(|material| Some(material).filter(is_constant).map(made)).collect() }
    }

    /// The number of materials that have one.
    pub fn count(&self) -> usize {
        self.of.iter().flatten().count()
    }

    /// That of a material; `None` if it must be made at the hit.
    pub(crate) fn get(&self, material: u32) -> Option<&Scatterer> {
        self.of.get(material as usize)?.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Coefficient, Phong, Physical, TextureId, Transmission};
    use rt_math::Rgb;

    #[test]
    fn only_what_is_the_same_everywhere_is_made_once() {
        let grey = Coefficient::Constant(Rgb::gray(0.5));
        let textured = Coefficient::Textured(TextureId(0), Rgb::WHITE);
        let glass = Transmission { coefficient: grey, ior: 1.5, fresnel: true, absorption: Rgb::BLACK, priority: 0 };
        let phong = |phong| Material::new(String::new(), phong);
        let physical = |physical| Material { physical: Some(physical), ..phong(Phong::default()) };
        let materials = vec![
            phong(Phong { specular: grey, ..Phong::default() }),
            phong(Phong { diffuse: textured, ..Phong::default() }),
            phong(Phong { transmission: Some(glass), ..Phong::default() }),
            physical(Physical::Diffuse { albedo: grey, roughness: 0.3 }),
            physical(Physical::Mix(vec![(1.0, Physical::Diffuse { albedo: textured, roughness: 0.0 })])),
        ];
        let appearance = Appearance { materials, ..Appearance::default() };
        for follows in [Follows::Everything, Follows::Reflections] {
            let constant = ConstantBsdfs::new(&appearance, follows);
            assert_eq!(constant.count(), 2);
            for (index, material) in appearance.materials.iter().enumerate() {
                let surface = SurfaceInteraction::flat(DVec3::ONE, DVec3::ZERO, DVec3::X, [0.3, 0.7]);
                let at_a_hit = material.bsdf(&PhysicalPoint { textures: &[], surface: &surface, ior: 1.0 });
                if let Some(made) = constant.get(index as u32) {
                    assert!([0, 3].contains(&index));
                    assert_eq!(made.bsdf, at_a_hit);
                    let reflects = follows == Follows::Reflections;
                    assert_eq!(made.without_diffuse, at_a_hit.without_diffuse().filter(|_| reflects));
                }
            }
            assert!(constant.get(5).is_none());
        }
    }
}
