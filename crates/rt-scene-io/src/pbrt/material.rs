//! Materials as physically based models.
//!
//! ```text
//! diffuse         Lambert
//! coateddiffuse   metallic-roughness, metallic 0
//! conductor       metal by its index; with a textured reflectance metallic-roughness, metallic 1
//! dielectric      glass                 thindielectric   thin glass
//! mix             a weighted sum        interface        no surface
//! ```
//!
//! Microfacets of the format have α = √roughness, or α = roughness without `remaproughness`; here α = roughness².

use rt_math::Rgb;
use rt_shading::bsdf::ComplexIor;
use rt_shading::{ColorTexture, InteriorMedium, MaterialModel, Phong};

use super::parameters::{Parameters, Values, unknown};
use super::spectrum::{colour, glass, metal};
use super::texture::{PbrtTextures, TextureType};
use crate::Material;
use crate::error::LineError;

/// Kinds of materials that only other programs have.
const UNSUPPORTED: [&str; 5] = ["coatedconductor", "diffusetransmission", "hair", "measured", "subsurface"];

/// Kinds of materials that are read.
const SUPPORTED: [&str; 9] =
    ["diffuse", "coateddiffuse", "conductor", "dielectric", "thindielectric", "mix", "interface", "none", ""];

/// Material; `None` for an invisible interface between media.
pub(super) type OptionalMaterial = Option<Material>;

/// Reads a material of this kind. `find` gives the parts of a mix by their names.
pub(super) fn read(
    kind: &str,
    parameters: &Parameters,
    textures: &PbrtTextures,
    find: impl Fn(&str) -> Result<OptionalMaterial, LineError>,
    warnings: &mut Vec<String>,
) -> Result<OptionalMaterial, LineError> {
    let name = format!("line {}", parameters.line);
    let made = |model: MaterialModel| Material::new(name.clone(), model);
    let reader = MaterialParameters { parameters, textures };
    Ok(Some(match kind {
        "diffuse" => {
            let albedo =
                textures.coefficient(parameters, "reflectance", TextureType::Spectrum, Rgb::gray(0.5), warnings)?;
            made(MaterialModel::Diffuse { albedo, roughness: 0.0 })
        }
        "coateddiffuse" => {
            let base_color =
                textures.coefficient(parameters, "reflectance", TextureType::Spectrum, Rgb::gray(0.5), warnings)?;
            let roughness = reader.roughness(warnings)?;
            made(MaterialModel::MetallicRoughness { base_color, metallic: 0.0, roughness })
        }
        "conductor" => reader.conductor(name, warnings)?,
        "dielectric" => {
            let (ior, roughness) = (reader.ior(warnings)?, reader.roughness(warnings)?);
            let transmittance = ColorTexture::Constant(Rgb::WHITE);
            let interior = Some(InteriorMedium::clear(ior));
            Material { interior, ..made(MaterialModel::Dielectric { roughness, transmittance }) }
        }
        "thindielectric" => {
            let (ior, transmittance) = (reader.ior(warnings)?, ColorTexture::Constant(Rgb::WHITE));
            made(MaterialModel::ThinGlass { ior, transmittance })
        }
        "mix" => return reader.mix(find, warnings),
        "interface" | "none" | "" => return Ok(None),
        other if UNSUPPORTED.contains(&other) => {
            warnings.push(format!("the material \"{other}\" is not supported: grey is used"));
            let albedo = ColorTexture::Constant(Rgb::gray(0.5));
            made(MaterialModel::Diffuse { albedo, roughness: 0.0 })
        }
        other => return Err(unknown("material", other, parameters.line, SUPPORTED.into_iter().chain(UNSUPPORTED))),
    }))
}

/// Index of a metal with this reflectance at normal incidence, as the format defines it: n = 1 and k = 2 √r / √(1 − r).
fn ior_of_reflectance(reflectance: Rgb) -> ComplexIor {
    let k = |r: f64| {
        let r = r.clamp(0.0, 0.9999);
        2.0 * r.sqrt() / (1.0 - r).sqrt()
    };
    ComplexIor { n: Rgb::WHITE, k: reflectance.map(k) }
}

struct MaterialParameters<'r> {
    parameters: &'r Parameters,
    textures: &'r PbrtTextures,
}

impl MaterialParameters<'_> {
    /// Our roughness, by that of the file.
    fn roughness(&self, warnings: &mut Vec<String>) -> Result<f64, LineError> {
        let p = self.parameters;
        let both = self.textures.number(p, "roughness", 0.0, warnings)?;
        let along = self.textures.number(p, "uroughness", both, warnings)?;
        let across = self.textures.number(p, "vroughness", both, warnings)?;
        if along != across {
            warnings
                .push(format!("a surface of roughness {along} along u and {across} along v has their mean all around"));
        }
        let roughness = 0.5 * (along + across);
        let remap = p.get("remaproughness").is_none() || p.flag("remaproughness")?;
        let alpha = if remap { roughness.sqrt() } else { roughness };
        if alpha <= 1.0 {
            return Ok(alpha.sqrt());
        }
        warnings.push(format!("roughness {roughness} was clamped to 1"));
        Ok(1.0)
    }

    fn ior(&self, warnings: &mut Vec<String>) -> Result<f64, LineError> {
        let p = self.parameters;
        let Some(eta) = p.get("eta") else { return Ok(1.5) };
        match &eta.values {
            Values::Words(words) => Ok(words.first().and_then(|name| glass(name)).unwrap_or_else(|| {
                warnings.push(format!("the spectrum {words:?} of \"eta\" is not known: 1.5 is in its place"));
                1.5
            })),
            Values::Numbers(_) if eta.kind == "float" => p.positive("eta", 1.5),
            Values::Numbers(_) => {
                let (rgb, _) = colour(p, "eta")?.unwrap_or_default();
                warnings.push("an index of refraction that changes with the colour became that of green".to_owned());
                if rgb.g > 0.0 { Ok(rgb.g) } else { Err(eta.error(rgb.g, "must be above 0")) }
            }
        }
    }

    fn conductor(&self, name: String, warnings: &mut Vec<String>) -> Result<Material, LineError> {
        let (p, roughness) = (self.parameters, self.roughness(warnings)?);
        if p.get("reflectance").is_some() {
            let base_color =
                self.textures.coefficient(p, "reflectance", TextureType::Spectrum, Rgb::WHITE, warnings)?;
            let model = MaterialModel::MetallicRoughness { base_color, metallic: 1.0, roughness };
            let material = Material::new(name, model);
            // Ambient light is reflected by the diffuse part only.
            let phong = *material.to_phong();
            let phong_override = Some(Phong { ambient: Phong::lambertian(phong.diffuse).ambient, ..phong });
            let model = match base_color {
                ColorTexture::Constant(reflectance) => {
                    MaterialModel::Conductor { ior: ior_of_reflectance(reflectance), roughness }
                }
                ColorTexture::Textured(..) => material.model,
            };
            return Ok(Material { model, phong_override, ..material });
        }
        let mut half = |name: &str, of: fn(&ComplexIor) -> Rgb| match p.get(name) {
            None => Ok(of(&ComplexIor::COPPER)),
            Some(parameter) => match &parameter.values {
                Values::Words(words) => Ok(words.first().and_then(|name| metal(name)).map_or_else(
                    || {
                        warnings
                            .push(format!("the spectrum {words:?} of \"{name}\" is not known: copper is in its place"));
                        of(&ComplexIor::COPPER)
                    },
                    |known| of(&known),
                )),
                Values::Numbers(_) => Ok(colour(p, name)?.map_or(Rgb::WHITE, |(rgb, warning)| {
                    warnings.extend(warning);
                    rgb
                })),
            },
        };
        let ior = ComplexIor { n: half("eta", |ior| ior.n)?, k: half("k", |ior| ior.k)? };
        Ok(Material::new(name, MaterialModel::Conductor { ior, roughness }))
    }

    fn mix(
        &self,
        find: impl Fn(&str) -> Result<OptionalMaterial, LineError>,
        warnings: &mut Vec<String>,
    ) -> Result<OptionalMaterial, LineError> {
        let p = self.parameters;
        let amount = self.textures.number(p, "amount", 0.5, warnings)?;
        let names = match p.get("materials").map(|parameter| &parameter.values) {
            Some(Values::Words(names)) if names.len() == 2 => names,
            _ => return Err(LineError::new(p.line, "a mix", "has no \"string materials\" of two names: add them")),
        };
        if amount > 1.0 {
            return Err(LineError::new(p.line, amount, "as \"amount\" must lie between 0 and 1"));
        }
        let (first, second) = (find(&names[0])?, find(&names[1])?);
        let (Some(first), Some(second)) = (first, second) else {
            return Err(LineError::new(p.line, "a mix", "has an invisible part: give it a material"));
        };
        let mixes = |part: &Material| match &part.model {
            MaterialModel::Mix(_) | MaterialModel::Dielectric { .. } => None,
            model => Some(model.clone()),
        };
        let (Some(a), Some(b)) = (mixes(&first), mixes(&second)) else {
            warnings.push("a mix with glass or another mix is not supported: its first part alone is seen".to_owned());
            return Ok(Some(first));
        };
        if first.normal_map.or(second.normal_map).is_some() {
            warnings.push("the normal maps of the parts of a mix are left out".to_owned());
        }
        let parts = vec![(1.0 - amount, a), (amount, b)];
        // The Phong model is that of the larger part.
        let larger = if amount > 0.5 { second } else { first };
        let phong_override = Some(*larger.to_phong());
        let name = format!("line {}", p.line);
        Ok(Some(Material { phong_override, ..Material::new(name, MaterialModel::Mix(parts)) }))
    }
}
