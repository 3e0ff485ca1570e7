//! Physically based materials of the file: reading, and writing for `convert`.

use rt_math::Rgb;
use rt_shading::bsdf::{ComplexIor, MAX_LOBES};
use rt_shading::light::EmissionSides;
use rt_shading::{ColorTexture, InteriorMedium, MaterialModel, Phong};

use super::texture::Textures;
use super::value::{colour, not_negative, positive, within};
use crate::diagnostics::Diagnostics;
use crate::format::{self, Metal};
use crate::{LoadErrorKind, Material, limits};

/// Reads the physically based materials of the file.
pub(super) struct ModelReader<'r, 'a> {
    pub(super) textures: &'r mut Textures<'a>,
    pub(super) report: &'r mut Diagnostics,
}

/// A model and its emission.
struct EmissiveModel {
    model: MaterialModel,
    emission: ColorTexture,
    emission_sides: EmissionSides,
}

impl From<MaterialModel> for EmissiveModel {
    fn from(model: MaterialModel) -> Self {
        Self { model, emission: ColorTexture::ZERO, emission_sides: EmissionSides::Both }
    }
}

impl ModelReader<'_, '_> {
    /// Material at a path of the document. `None` if it has an error, which is reported.
    pub(super) fn material(&mut self, path: &str, name: &str, definition: &format::Material) -> Option<Material> {
        let interior = self.interior(path, definition);
        let EmissiveModel { model, emission, emission_sides } = self.model(path, definition)?;
        Some(Material { emission, emission_sides, interior: interior?, ..Material::new(name.to_owned(), model) })
    }

    fn model(&mut self, path: &str, definition: &format::Material) -> Option<EmissiveModel> {
        let dark = |model: MaterialModel| Some(model.into());
        match definition {
            // A `phong` material cannot be part of a mix.
            format::Material::Phong { .. } => {
                let rule = "cannot be part of a mix: use `diffuse`, `glossy`, `mirror` or another physical material";
                self.report.refuse(path, "a `phong` material", rule)
            }
            format::Material::Diffuse { albedo, roughness, emission } => {
                let albedo = self.reflectance(path, "albedo", albedo)?;
                let roughness = self.share(path, "roughness", *roughness)?;
                let emission = self.emission(path, emission.as_ref())?;
                let model = MaterialModel::Diffuse { albedo, roughness };
                Some(EmissiveModel { emission, ..model.into() })
            }
            format::Material::Glossy { diffuse, specular, exponent } => {
                let diffuse = self.reflectance(path, "diffuse", diffuse)?;
                let specular = self.reflectance(path, "specular", specular)?;
                let exponent = self
                    .report
                    .check(format_args!("{path}.exponent"), within(*exponent, 0.0, limits::HIGHLIGHT_EXPONENT))?;
                dark(MaterialModel::Glossy { diffuse, specular, exponent })
            }
            format::Material::Mirror { reflectance } => {
                let reflectance = self.reflectance(path, "reflectance", reflectance)?;
                dark(MaterialModel::Mirror { reflectance })
            }
            format::Material::Glass { roughness, transmittance, .. } => {
                let roughness = self.share(path, "roughness", *roughness)?;
                let transmittance = self.reflectance(path, "transmittance", transmittance)?;
                dark(MaterialModel::Dielectric { roughness, transmittance })
            }
            format::Material::Metal { metal, n, k, roughness } => {
                let roughness = self.share(path, "roughness", *roughness)?;
                let ior = self.metal(path, *metal, n.as_ref(), k.as_ref())?;
                dark(MaterialModel::Conductor { ior, roughness })
            }
            format::Material::MetallicRoughness { base_color, metallic, roughness, emission } => {
                let base_color = self.reflectance(path, "base_color", base_color)?;
                let metallic = self.share(path, "metallic", *metallic)?;
                let roughness = self.share(path, "roughness", *roughness)?;
                let emission = self.emission(path, emission.as_ref())?;
                let model = MaterialModel::MetallicRoughness { base_color, metallic, roughness };
                Some(EmissiveModel { emission, ..model.into() })
            }
            format::Material::ThinGlass { ior, transmittance } => {
                let ior = self.report.check(format_args!("{path}.ior"), positive(*ior))?;
                let transmittance = self.reflectance(path, "transmittance", transmittance)?;
                dark(MaterialModel::ThinGlass { ior, transmittance })
            }
            format::Material::Light { radiance, emission_sides } => {
                let emission = self.coefficient(path, "radiance", radiance)?;
                let emission_sides = (*emission_sides).into();
                Some(EmissiveModel { model: MaterialModel::Black, emission, emission_sides })
            }
            format::Material::Mix(parts) => self.mix(path, parts),
        }
    }

    /// Medium behind the surface; `None` if it has an error.
    fn interior(&mut self, path: &str, definition: &format::Material) -> Option<Option<InteriorMedium>> {
        let format::Material::Glass { ior, absorption, priority, .. } = definition else { return Some(None) };
        let ior = self.report.check(format_args!("{path}.ior"), positive(*ior));
        let absorption = match absorption {
            Some(value) => self.report.check(format_args!("{path}.absorption"), colour(value)),
            None => Some(Rgb::BLACK),
        };
        Some(Some(InteriorMedium { ior: ior?, absorption: absorption?, priority: *priority }))
    }

    fn metal(
        &mut self,
        path: &str,
        metal: Option<Metal>,
        n: Option<&format::Color>,
        k: Option<&format::Color>,
    ) -> Option<ComplexIor> {
        let ior = match (metal, n, k) {
            (Some(metal), None, None) => Ok(measured(metal)),
            (None, Some(n), Some(k)) => colour(n).and_then(|n| Ok(ComplexIor { n, k: colour(k)? })),
            _ => Err(LoadErrorKind::invalid("the metal", "needs either the name of a `metal`, or both `n` and `k`")),
        };
        self.report.check(path, ior)
    }

    /// Model of a mix. Emission is the weighted sum of the parts. It has at most one texture, and the same sides in all parts.
    fn mix(&mut self, path: &str, parts: &[(f64, format::Material)]) -> Option<EmissiveModel> {
        if parts.is_empty() || parts.len() > MAX_LOBES {
            let rule = format!("must have 1 to {MAX_LOBES}");
            return self.report.refuse(path, format_args!("{} materials", parts.len()), rule);
        }
        let mut sum = EmissiveModel::from(MaterialModel::Black);
        let mut mixed = Vec::with_capacity(parts.len());
        for (i, (weight, part)) in parts.iter().enumerate() {
            let at = format!("{path}[{i}]");
            let weight = self.report.check(&at, not_negative(*weight))?;
            if matches!(part, format::Material::Glass { .. } | format::Material::Mix(_)) {
                return self.report.refuse(&at, "glass or another mix", "cannot be part of a mix");
            }
            let part = self.model(&at, part)?;
            let emission = part.emission.scaled(weight);
            if sum.emission.is_zero() {
                (sum.emission, sum.emission_sides) = (emission, part.emission_sides);
            } else if !emission.is_zero() {
                let total = match (sum.emission, emission) {
                    (ColorTexture::Constant(a), ColorTexture::Constant(b)) => ColorTexture::Constant(a + b),
                    (ColorTexture::Textured(i, a), ColorTexture::Textured(j, b)) if i == j => {
                        ColorTexture::Textured(i, a + b)
                    }
                    _ => {
                        let rule =
                            "cannot be added to that of another part: only one part may emit if one has a texture";
                        return self.report.refuse(&at, "the emission", rule);
                    }
                };
                if sum.emission_sides != part.emission_sides {
                    let rule = "must be those of the other parts: a `light` among them needs `emission_sides: both`";
                    return self.report.refuse(&at, "the sides that emit", rule);
                }
                sum.emission = total;
            }
            mixed.push((weight, part.model));
        }
        let lobes: usize = mixed.iter().map(|(_, part)| part.lobes()).sum();
        if lobes > MAX_LOBES {
            let rule = format!("must be at most {MAX_LOBES}: a `glossy` material with a diffuse part has two");
            return self.report.refuse(path, format_args!("{lobes} lobes"), rule);
        }
        Some(EmissiveModel { model: MaterialModel::Mix(mixed), ..sum })
    }

    /// Reads a reflectance. A constant above 1 would create energy.
    fn reflectance(&mut self, path: &str, field: &str, value: &format::ColorTexture) -> Option<ColorTexture> {
        let part = self.coefficient(path, field, value)?;
        match part {
            ColorTexture::Constant(rgb) if rgb.max_component() > 1.0 => {
                let rule = "exceeds 1 and would create energy: each component must lie between 0 and 1";
                self.report.refuse(format_args!("{path}.{field}"), rgb.max_component(), rule)
            }
            part => Some(part),
        }
    }

    fn coefficient(&mut self, path: &str, field: &str, value: &format::ColorTexture) -> Option<ColorTexture> {
        self.report.check(format_args!("{path}.{field}"), self.textures.coefficient(value))
    }

    fn emission(&mut self, path: &str, value: Option<&format::ColorTexture>) -> Option<ColorTexture> {
        value.map_or(Some(ColorTexture::ZERO), |value| self.coefficient(path, "emission", value))
    }

    /// A number from 0 to 1.
    fn share(&mut self, path: &str, field: &str, value: f64) -> Option<f64> {
        self.report.check(format_args!("{path}.{field}"), within(value, 0.0, 1.0))
    }
}

const fn measured(metal: Metal) -> ComplexIor {
    match metal {
        Metal::Aluminium => ComplexIor::ALUMINIUM,
        Metal::Chromium => ComplexIor::CHROMIUM,
        Metal::Copper => ComplexIor::COPPER,
        Metal::Gold => ComplexIor::GOLD,
        Metal::Iron => ComplexIor::IRON,
        Metal::Silver => ComplexIor::SILVER,
        Metal::Titanium => ComplexIor::TITANIUM,
    }
}

/// A material as scene files describe it; `None` for a physically based one that they cannot describe.
pub(crate) fn written_material(material: &Material) -> Option<format::Material> {
    let Material { model, emission: emitted, emission_sides, interior, .. } = material;
    let constant = |coefficient: &ColorTexture| match coefficient {
        ColorTexture::Constant(rgb) if rgb.max_component() <= 1.0 => {
            Some(format::Color::from_rgb(rgb.to_array()).into())
        }
        _ => None,
    };
    if let MaterialModel::Phong(phong) = model {
        return Some(written_phong(phong, *emitted, *interior));
    }
    let emission = match emitted {
        ColorTexture::Constant(rgb) if rgb.is_black() => None,
        ColorTexture::Constant(rgb) => Some(format::Color::from_rgb(rgb.to_array()).into()),
        ColorTexture::Textured(..) => return None,
    };
    let is_dark = emission.is_none();
    let metallic_roughness = |base_color: &ColorTexture, metallic: f64, roughness: f64, emission| {
        Some(format::Material::MetallicRoughness { base_color: constant(base_color)?, metallic, roughness, emission })
    };
    let written = match model {
        MaterialModel::Black => format::Material::Light {
            radiance: emission.unwrap_or(format::ColorTexture::Gray(0.0)),
            emission_sides: (*emission_sides).into(),
        },
        _ if !(is_dark || *emission_sides == EmissionSides::Both) => return None,
        MaterialModel::Diffuse { albedo, roughness } => {
            format::Material::Diffuse { albedo: constant(albedo)?, roughness: *roughness, emission }
        }
        MaterialModel::MetallicRoughness { base_color, metallic, roughness } => {
            metallic_roughness(base_color, *metallic, *roughness, emission)?
        }
        MaterialModel::Layered(layered) => {
            let (base_color, metallic, roughness) = layered.as_metallic_roughness()?;
            metallic_roughness(base_color, metallic, roughness, emission)?
        }
        _ if !is_dark => return None,
        MaterialModel::Glossy { diffuse, specular, exponent } => {
            format::Material::Glossy { diffuse: constant(diffuse)?, specular: constant(specular)?, exponent: *exponent }
        }
        MaterialModel::Mirror { reflectance } => format::Material::Mirror { reflectance: constant(reflectance)? },
        MaterialModel::Dielectric { roughness, transmittance } => {
            // An override without Fresnel's equations is not described by `glass`.
            let phong = material.to_phong().transmission?;
            let inside = interior.filter(|_| phong.fresnel && phong.coefficient == *transmittance)?;
            let absorption =
                (!inside.absorption.is_black()).then(|| format::Color::from_rgb(inside.absorption.to_array()));
            format::Material::Glass {
                ior: inside.ior,
                roughness: *roughness,
                transmittance: constant(transmittance)?,
                absorption,
                priority: inside.priority,
            }
        }
        MaterialModel::Conductor { ior, roughness } => format::Material::Metal {
            metal: None,
            n: Some(format::Color::from_rgb(ior.n.to_array())),
            k: Some(format::Color::from_rgb(ior.k.to_array())),
            roughness: *roughness,
        },
        MaterialModel::ThinGlass { ior, transmittance } => {
            format::Material::ThinGlass { ior: *ior, transmittance: constant(transmittance)? }
        }
        MaterialModel::Phong(_) | MaterialModel::Mix(_) => return None,
    };
    Some(written)
}

/// Constant coefficients of a Phong material; textured ones stay with the model.
pub(crate) fn written_phong(
    phong: &Phong,
    emission: ColorTexture,
    interior: Option<InteriorMedium>,
) -> format::Material {
    let constant = |coefficient: ColorTexture| match coefficient {
        ColorTexture::Constant(rgb) => Some(format::Color::from_rgb(rgb.to_array()).into()),
        ColorTexture::Textured(..) => None,
    };
    format::Material::Phong {
        color: None,
        ambient: constant(phong.ambient),
        diffuse: constant(phong.diffuse),
        specular: constant(phong.specular),
        exponent: Some(phong.exponent),
        highlight: Some(phong.highlight.into()),
        emission: constant(emission),
        mirror: constant(phong.mirror),
        transmission: phong.transmission.and_then(|transmission| constant(transmission.coefficient)),
        ior: interior.map(|inside| inside.ior),
        fresnel: phong.transmission.map(|transmission| transmission.fresnel),
        absorption: interior.map(|inside| format::Color::from_rgb(inside.absorption.to_array())),
        priority: interior.map(|inside| inside.priority),
        emission_sides: None,
    }
}
