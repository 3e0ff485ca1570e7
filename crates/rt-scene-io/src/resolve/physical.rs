//! Physical materials of the file, each with a Phong surface that resembles it.

use rt_math::Rgb;
use rt_shading::bsdf::{ComplexIor, MAX_LOBES};
use rt_shading::light::EmissionSides as Sides;
use rt_shading::{ColorTexture, Phong, Physical};

use super::texture::Textures;
use super::value::{colour, not_negative, positive, within};
use crate::diagnostics::Diagnostics;
use crate::format::{self, Metal};
use crate::phong_fallback::{self, BLACK, diffuse, scaled};
use crate::{LoadErrorKind, Material, limits};

/// Reads the physical materials of the file.
pub(super) struct PhysicalReader<'r, 'a> {
    pub(super) textures: &'r mut Textures<'a>,
    pub(super) report: &'r mut Diagnostics,
}

/// A surface on both forms.
struct SurfacePair {
    phong: Phong,
    physical: Physical,
    shines: Sides,
}

impl PhysicalReader<'_, '_> {
    /// The material at a path of the document, under a name; `None` if something in it is wrong, which is reported.
    pub(super) fn material(&mut self, path: &str, name: &str, definition: &format::Material) -> Option<Material> {
        let SurfacePair { phong, physical, shines } = self.surface(path, definition)?;
        Some(Material { physical: Some(physical), shines, ..Material::new(name.to_owned(), phong) })
    }

    fn surface(&mut self, path: &str, definition: &format::Material) -> Option<SurfacePair> {
        let both = |phong, physical| SurfacePair { phong, physical, shines: Sides::Both };
        match definition {
            // A `phong` material cannot be part of a mix.
            format::Material::Phong { .. } => {
                let rule = "cannot be part of a mix: use `diffuse`, `glossy`, `mirror` or another physical material";
                self.report.check::<()>(path, Err(LoadErrorKind::invalid("a `phong` material", rule)));
                None
            }
            format::Material::Diffuse { albedo, roughness, emission } => {
                let albedo = self.reflectance(path, "albedo", albedo)?;
                let roughness = self.share(path, "roughness", *roughness)?;
                let emission = self.emission(path, emission.as_ref())?;
                let phong = Phong { emission, ..diffuse(albedo) };
                Some(both(phong, Physical::Diffuse { albedo, roughness }))
            }
            format::Material::Glossy { diffuse: base, specular, exponent } => {
                let base = self.reflectance(path, "diffuse", base)?;
                let specular = self.reflectance(path, "specular", specular)?;
                let exponent = self
                    .report
                    .check(format_args!("{path}.exponent"), within(*exponent, 0.0, limits::HIGHLIGHT_EXPONENT))?;
                let phong = Phong { specular, exponent, ..diffuse(base) };
                Some(both(phong, Physical::Glossy { diffuse: base, specular, exponent }))
            }
            format::Material::Mirror { reflectance } => {
                let reflectance = self.reflectance(path, "reflectance", reflectance)?;
                Some(both(Phong { mirror: reflectance, ..BLACK }, Physical::Mirror { reflectance }))
            }
            format::Material::Glass { .. } => self.glass(path, definition),
            format::Material::Metal { metal, n, k, roughness } => {
                let roughness = self.share(path, "roughness", *roughness)?;
                let ior = self.metal(path, *metal, n.as_ref(), k.as_ref())?;
                let phong = phong_fallback::metal(ColorTexture::Constant(ior.fresnel(1.0)), roughness);
                Some(both(phong, Physical::Conductor { ior, roughness }))
            }
            format::Material::MetallicRoughness { base_color, metallic, roughness, emission } => {
                let base_color = self.reflectance(path, "base_color", base_color)?;
                let metallic = self.share(path, "metallic", *metallic)?;
                let roughness = self.share(path, "roughness", *roughness)?;
                let emission = self.emission(path, emission.as_ref())?;
                let metal = phong_fallback::metal(base_color, roughness);
                let base = Phong { mirror: scaled(metal.mirror, metallic), ..diffuse(base_color) };
                let phong =
                    Phong { emission, diffuse: if metallic < 1.0 { base.diffuse } else { metal.diffuse }, ..base };
                Some(both(phong, Physical::MetallicRoughness { base_color, metallic, roughness }))
            }
            format::Material::ThinGlass { ior, transmittance } => {
                let ior = self.report.check(format_args!("{path}.ior"), positive(*ior))?;
                let transmittance = self.reflectance(path, "transmittance", transmittance)?;
                Some(both(phong_fallback::thin_dielectric(transmittance), Physical::ThinGlass { ior, transmittance }))
            }
            format::Material::Light { radiance, emission_sides } => {
                let emission = self.coefficient(path, "radiance", radiance)?;
                Some(SurfacePair {
                    phong: Phong { emission, ..BLACK },
                    physical: Physical::Black,
                    shines: (*emission_sides).into(),
                })
            }
            format::Material::Mix(parts) => self.mix(path, parts),
        }
    }

    fn glass(&mut self, path: &str, definition: &format::Material) -> Option<SurfacePair> {
        let format::Material::Glass { ior, roughness, transmittance, absorption, priority } = definition else {
            return None;
        };
        let ior = self.report.check(format_args!("{path}.ior"), positive(*ior))?;
        let roughness = self.share(path, "roughness", *roughness)?;
        let transmittance = self.reflectance(path, "transmittance", transmittance)?;
        let absorption = match absorption {
            Some(value) => self.report.check(format_args!("{path}.absorption"), colour(value))?,
            None => Rgb::BLACK,
        };
        let phong = phong_fallback::dielectric(ior, transmittance, absorption, *priority);
        let physical = Physical::Dielectric { roughness, transmittance };
        Some(SurfacePair { phong, physical, shines: Sides::Both })
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

    fn mix(&mut self, path: &str, parts: &[(f64, format::Material)]) -> Option<SurfacePair> {
        if parts.is_empty() || parts.len() > MAX_LOBES {
            let rule = format!("must have 1 to {MAX_LOBES}");
            self.report.check::<()>(path, Err(LoadErrorKind::invalid(format_args!("{} materials", parts.len()), rule)));
            return None;
        }
        let mut sum = SurfacePair { phong: BLACK, physical: Physical::Black, shines: Sides::Both };
        let mut mixed = Vec::with_capacity(parts.len());
        for (i, (weight, part)) in parts.iter().enumerate() {
            let at = format!("{path}[{i}]");
            let weight = self.report.check(&at, not_negative(*weight))?;
            if matches!(part, format::Material::Glass { .. } | format::Material::Mix(_)) {
                let rule = "cannot be part of a mix";
                self.report.check::<()>(&at, Err(LoadErrorKind::invalid("glass or another mix", rule)));
                return None;
            }
            let surface = self.surface(&at, part)?;
            sum.add(weight, &surface);
            mixed.push((weight, surface.physical));
        }
        Some(SurfacePair { physical: Physical::Mix(mixed), ..sum })
    }

    /// Reads a reflectance. A constant above 1 would create energy.
    fn reflectance(&mut self, path: &str, field: &str, value: &format::ColorTexture) -> Option<ColorTexture> {
        let part = self.coefficient(path, field, value)?;
        let checked = match part {
            ColorTexture::Constant(rgb) if rgb.max_component() > 1.0 => {
                let rule = "is more than all of the light: each part must lie between 0 and 1";
                Err(LoadErrorKind::invalid(rgb.max_component(), rule))
            }
            part => Ok(part),
        };
        self.report.check(format_args!("{path}.{field}"), checked)
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

impl SurfacePair {
    /// Adds the Phong surface of `other`, times a weight. The first texture of each coefficient counts.
    fn add(&mut self, weight: f64, other: &Self) {
        let Phong { ambient, diffuse, specular, emission, mirror, .. } = &mut self.phong;
        let of_other = &other.phong;
        let pairs = [
            (ambient, of_other.ambient),
            (diffuse, of_other.diffuse),
            (specular, of_other.specular),
            (emission, of_other.emission),
            (mirror, of_other.mirror),
        ];
        for (sum, more) in pairs {
            *sum = match (*sum, scaled(more, weight)) {
                (ColorTexture::Constant(a), ColorTexture::Constant(b)) => ColorTexture::Constant(a + b),
                (textured @ ColorTexture::Textured(..), _) | (_, textured) => textured,
            };
        }
        if !of_other.specular.is_zero() {
            self.phong.exponent = of_other.exponent;
        }
        if !of_other.emission.is_zero() {
            self.shines = other.shines;
        }
        self.phong.transmission = self.phong.transmission.or(of_other.transmission);
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
