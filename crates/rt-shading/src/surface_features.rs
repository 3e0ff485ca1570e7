//! Albedo and roughness of a surface, as denoisers and compositing programs expect them: one colour and one number.

use rt_math::Rgb;

use crate::{Material, MaterialEvalContext, MaterialModel, Phong, layered_surface::LayeredBase};

/// Roughness of a surface that scatters into all directions.
const DIFFUSE: f64 = 1.0;

impl Material {
    /// Base colour of the surface, 0 to 1 in each channel. It is the albedo of diffuse surfaces, the reflectance of mirrors
    /// and metals at normal incidence, or the transmittance of glass. Lobes of one material are added up to at most 1.
    pub fn albedo(&self, at: &MaterialEvalContext<'_>) -> Rgb {
        albedo(&self.model, at)
    }

    /// Roughness of the surface, 0 for mirrors to 1 for diffuse surfaces, as in glTF: the square root of the α of GGX. The
    /// exponent `n` of Phong lobes is converted by α² = 2/(n + 2) (Walter et al. 2007); such surfaces are diffuse if the
    /// diffuse coefficient is the largest.
    pub fn roughness(&self, at: &MaterialEvalContext<'_>) -> f64 {
        roughness(&self.model, at)
    }
}

fn albedo(model: &MaterialModel, at: &MaterialEvalContext<'_>) -> Rgb {
    match model {
        MaterialModel::Black => Rgb::BLACK,
        MaterialModel::Phong(Phong { diffuse, specular, mirror, transmission, .. }) => {
            let transmitted = transmission.as_ref().map_or(Rgb::BLACK, |way| at.reflectance(&way.coefficient));
            limited(at.reflectance(diffuse) + at.reflectance(specular) + at.reflectance(mirror) + transmitted)
        }
        MaterialModel::Glossy { diffuse, specular, .. } => limited(at.reflectance(diffuse) + at.reflectance(specular)),
        MaterialModel::Diffuse { albedo: color, .. }
        | MaterialModel::Mirror { reflectance: color }
        | MaterialModel::Dielectric { transmittance: color, .. }
        | MaterialModel::ThinGlass { transmittance: color, .. }
        | MaterialModel::MetallicRoughness { base_color: color, .. } => at.reflectance(color),
        MaterialModel::Conductor { ior, .. } => limited(ior.fresnel(1.0)),
        MaterialModel::Layered(layered) => match &layered.base {
            LayeredBase::MetallicRoughness { base_color, .. } => at.reflectance(base_color),
            LayeredBase::SpecularGlossiness { diffuse, specular, .. } => {
                limited(at.reflectance(diffuse) + at.reflectance(specular))
            }
        },
        MaterialModel::Mix(parts) => {
            limited(parts.iter().fold(Rgb::BLACK, |sum, (weight, part)| sum + albedo(part, at) * *weight))
        }
    }
}

fn roughness(model: &MaterialModel, at: &MaterialEvalContext<'_>) -> f64 {
    match model {
        MaterialModel::Black | MaterialModel::Diffuse { .. } => DIFFUSE,
        MaterialModel::Mirror { .. } | MaterialModel::ThinGlass { .. } => 0.0,
        MaterialModel::Phong(phong) => {
            let [diffuse, specular, mirror] =
                [phong.diffuse, phong.specular, phong.mirror].map(|color| at.reflectance(&color).max_component());
            if phong.transmission.is_some() || mirror > diffuse.max(specular) {
                0.0
            } else if specular > diffuse {
                of_exponent(phong.exponent)
            } else {
                DIFFUSE
            }
        }
        MaterialModel::Glossy { diffuse, specular, exponent } => {
            let [diffuse, specular] = [diffuse, specular].map(|color| at.reflectance(color).max_component());
            if specular > diffuse { of_exponent(*exponent) } else { DIFFUSE }
        }
        MaterialModel::Dielectric { roughness, .. }
        | MaterialModel::Conductor { roughness, .. }
        | MaterialModel::MetallicRoughness { roughness, .. } => *roughness,
        MaterialModel::Layered(layered) => match &layered.base {
            LayeredBase::MetallicRoughness { roughness, .. } => at.unit_value(roughness),
            LayeredBase::SpecularGlossiness { glossiness, .. } => 1.0 - at.unit_value(glossiness),
        },
        MaterialModel::Mix(parts) => {
            let total: f64 = parts.iter().map(|(weight, _)| weight).sum();
            let sum: f64 = parts.iter().map(|(weight, part)| weight * roughness(part, at)).sum();
            if total > 0.0 { sum / total } else { DIFFUSE }
        }
    }
}

fn limited(color: Rgb) -> Rgb {
    color.map(|c| c.min(1.0))
}

fn of_exponent(exponent: f64) -> f64 {
    (2.0 / (exponent + 2.0)).sqrt().sqrt()
}

#[cfg(test)]
mod tests {
    use rt_geometry::SurfaceInteraction;
    use rt_math::DVec3;

    use super::*;
    use crate::{ColorTexture, LayeredSurface};

    fn of(model: MaterialModel) -> (Rgb, f64) {
        let surface = SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Z, [0.0; 2]);
        let at = MaterialEvalContext { textures: &[], surface: &surface, ior: 1.0 };
        let material = Material::new(String::new(), model);
        (material.albedo(&at), material.roughness(&at))
    }

    #[test]
    fn models_give_their_own_colour_and_roughness() {
        let (gray, red) = (ColorTexture::Constant(Rgb::gray(0.5)), ColorTexture::Constant(Rgb::new(0.75, 0.0, 0.0)));
        assert_eq!(of(MaterialModel::Black), (Rgb::BLACK, 1.0));
        assert_eq!(of(MaterialModel::Diffuse { albedo: red, roughness: 0.25 }), (Rgb::new(0.75, 0.0, 0.0), 1.0));
        assert_eq!(of(MaterialModel::Mirror { reflectance: gray }), (Rgb::gray(0.5), 0.0));
        let metal = MaterialModel::MetallicRoughness { base_color: red, metallic: 1.0, roughness: 0.25 };
        assert_eq!(of(metal), (Rgb::new(0.75, 0.0, 0.0), 0.25));
        let layered = LayeredSurface::new(LayeredBase::MetallicRoughness {
            base_color: gray,
            metallic: crate::FloatTexture::Constant(0.0),
            roughness: crate::FloatTexture::Constant(0.5),
        });
        assert_eq!(of(MaterialModel::Layered(Box::new(layered))), (Rgb::gray(0.5), 0.5));
    }

    #[test]
    fn lobes_add_up_to_at_most_one_and_the_strongest_gives_the_roughness() {
        let (gray, red) = (ColorTexture::Constant(Rgb::gray(0.5)), ColorTexture::Constant(Rgb::new(0.75, 0.0, 0.0)));
        let glossy = |diffuse, specular| of(MaterialModel::Glossy { diffuse, specular, exponent: 30.0 });
        assert_eq!(glossy(gray, red), (Rgb::new(1.0, 0.5, 0.5), 0.5));
        assert_eq!(glossy(red, gray).1, 1.0);
        let mirror = Phong { mirror: red, ..Phong::lambertian(gray) };
        assert_eq!(of(MaterialModel::Phong(mirror)), (Rgb::new(1.0, 0.5, 0.5), 0.0));
        let mix = MaterialModel::Mix(vec![
            (0.25, MaterialModel::Diffuse { albedo: gray, roughness: 0.0 }),
            (0.75, MaterialModel::Mirror { reflectance: gray }),
        ]);
        assert_eq!(of(mix), (Rgb::gray(0.5), 0.25));
    }
}
