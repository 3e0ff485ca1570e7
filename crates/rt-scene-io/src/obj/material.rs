//! MTL materials as Phong models, or as physically based models if they have physically based parameters.
//!
//! ```text
//! diffuse      = d · Kd · map_Kd; 0 for models 6 and 7 unless Tf is 0
//! ambient      = 1/10 of it: exporters rarely write a meaningful Ka
//! specular     = Ks · map_Ks from illumination model 2 on, with the half vector of Blinn and exponent Ns
//! emission     = Ke · map_Ke
//! mirror       = Ks       for models 3, 4, 5, 8, 9 (reflection) and 6 (refraction); all for 7 (Fresnel)
//! transmission = (1 − Ks) · Tf  for model 6, refracted by Ni
//!              = Tf             for model 7, refracted by Ni; Fresnel's equations split the light
//!              = 1 − d          otherwise, without refraction
//! ```
//!
//! Colours are multiplied per channel, and differences are at least 0. The transmission of model 6 is constant: it uses Ks
//! without map_Ks.
//!
//! Materials with a physically based parameter have a second model: the metallic-roughness model of glTF, or a dielectric for
//! models 6 and 7. The file states both, so that the Phong model remains as `phong_override`.
//!
//! ```text
//! base colour = Kd · map_Kd        metalness  = Pm · map_Pm       roughness = Pr · map_Pr
//! clearcoat   = Pc · map_Pc, roughness Pcr                        sheen     = Ps · map_Ps
//! anisotropy  = aniso, rotated by anisor of a full turn
//! ```
//!
//! With a `map_d`, and in physically based models other than glass, opacity is alpha. A ray then hits the surface with the
//! probability `d · map_d`, and passes straight otherwise.

use std::f64::consts::TAU;

use rt_math::Rgb;
use rt_shading::{
    Alpha, AlphaMode, Channel, ColorTexture, FloatTexture, Highlight, InteriorMedium, LayeredBase, LayeredSurface,
    Material, MaterialModel, NormalMap, Phong, Texture, TextureId, Transmission,
};

use crate::limits;

/// The textures of a material, where they could be loaded.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MaterialMaps {
    pub(super) diffuse: Option<TextureId>,
    pub(super) specular: Option<TextureId>,
    pub(super) emission: Option<TextureId>,
    pub(super) metallic: Option<(TextureId, Channel)>,
    pub(super) roughness: Option<(TextureId, Channel)>,
    pub(super) clearcoat: Option<(TextureId, Channel)>,
    pub(super) sheen: Option<TextureId>,
    pub(super) alpha: Option<TextureId>,
    /// Normals, or heights that were made normals.
    pub(super) normal_map: Option<NormalMap>,
}

/// Default roughness of a file with physically based parameters, as in programs with these parameters.
const ROUGHNESS: f64 = 0.5;

/// Ambient coefficient divided by the diffuse one.
const AMBIENT_SHARE: f64 = 0.1;

/// Material with these maps of `textures`. All numbers of `mtl` must be finite and not negative.
pub(super) fn material(mtl: &tobj::Material, maps: MaterialMaps, textures: &[Texture]) -> Material {
    let phong = phong(mtl, maps);
    let interior = is_transmissive(mtl, maps, &phong).then(|| InteriorMedium::clear(ior(mtl)));
    let (model, phong_override) = match physically_based(mtl, maps, textures) {
        Some(model) => (model, Some(phong)),
        None => (phong.into(), None),
    };
    Material {
        phong_override,
        emission: emission(mtl, maps),
        interior,
        alpha: alpha(mtl, maps),
        normal_map: maps.normal_map,
        ..Material::new(mtl.name.clone(), model)
    }
}

fn phong(mtl: &tobj::Material, maps: MaterialMaps) -> Phong {
    let model = mtl.illumination_model.unwrap_or(2);
    let opacity = if is_blended(mtl, maps) { 1.0 } else { opacity(mtl) };
    let default = Phong::default();
    // A diffuse part next to that of glass would return more light than arrives.
    let is_clear = is_glass(mtl) && !filter_colour(mtl).is_black();
    let kd = if is_clear { Rgb::BLACK } else { base_colour(mtl, maps) };
    let ks = specular_colour(mtl);
    Phong {
        ambient: coefficient(maps.diffuse, kd * (AMBIENT_SHARE * opacity)),
        diffuse: coefficient(maps.diffuse, kd * opacity),
        // Exporters write Ns 0 for materials that never had a highlight; cos⁰ would whiten them all over.
        specular: if model >= 2 && mtl.shininess != Some(0.0) {
            coefficient(maps.specular, ks)
        } else {
            ColorTexture::ZERO
        },
        exponent: mtl.shininess.map_or(default.exponent, |ns| f64::from(ns).min(limits::HIGHLIGHT_EXPONENT)),
        highlight: Highlight::Blinn,
        mirror: match model {
            3..=6 | 8 | 9 => coefficient(maps.specular, ks),
            7 => ColorTexture::Constant(Rgb::WHITE),
            _ => ColorTexture::ZERO,
        },
        transmission: transmission(mtl, model, opacity),
    }
}

fn emission(mtl: &tobj::Material, maps: MaterialMaps) -> ColorTexture {
    let ke = match (mtl.emissive.map(rgb), maps.emission) {
        (None, Some(_)) => Rgb::WHITE,
        (ke, _) => ke.unwrap_or(Rgb::BLACK),
    };
    coefficient(maps.emission, ke)
}

/// Physically based model, if the material has parameters of one.
fn physically_based(mtl: &tobj::Material, maps: MaterialMaps, textures: &[Texture]) -> Option<MaterialModel> {
    if !is_physically_based(mtl, maps) {
        return None;
    }
    let number = |name: &str| number(mtl, name);
    // A factor of a map that is missing or zero means the map alone, as with colours.
    let scalar = |name: &str, map: Option<(TextureId, Channel)>, otherwise: f64| match (number(name), map) {
        (factor, Some((id, channel))) => {
            let factor = factor.filter(|factor| *factor > 0.0).unwrap_or(1.0).min(1.0);
            FloatTexture::textured(textures, id, channel, factor)
        }
        (factor, None) => FloatTexture::Constant(factor.unwrap_or(otherwise).min(1.0)),
    };
    if is_glass(mtl) {
        let roughness = number("Pr").unwrap_or(ROUGHNESS).min(1.0);
        return Some(MaterialModel::Dielectric {
            roughness,
            transmittance: ColorTexture::Constant(filter_colour(mtl)),
        });
    }
    let base_color = coefficient(maps.diffuse, base_colour(mtl, maps));
    let (metallic, roughness) = (scalar("Pm", maps.metallic, 0.0), scalar("Pr", maps.roughness, ROUGHNESS));
    let sheen = match (number("Ps"), maps.sheen) {
        (factor, Some(_)) => factor.filter(|factor| *factor > 0.0).unwrap_or(1.0),
        (factor, None) => factor.unwrap_or(0.0),
    };
    let layers = LayeredSurface {
        clearcoat: scalar("Pc", maps.clearcoat, 0.0),
        clearcoat_roughness: FloatTexture::Constant(number("Pcr").unwrap_or(0.0).min(1.0)),
        sheen_color: coefficient(maps.sheen, Rgb::gray(sheen.min(1.0))),
        sheen_roughness: FloatTexture::Constant(ROUGHNESS),
        anisotropy: FloatTexture::Constant(number("aniso").unwrap_or(0.0).min(1.0)),
        anisotropy_rotation: TAU * number("anisor").unwrap_or(0.0).min(1.0),
        ..LayeredSurface::new(LayeredBase::MetallicRoughness { base_color, metallic, roughness })
    };
    let is_bare = layers.clearcoat.is_zero() && layers.sheen_color.is_zero() && layers.anisotropy.is_zero();
    Some(match (metallic, roughness) {
        (FloatTexture::Constant(metallic), FloatTexture::Constant(roughness)) if is_bare => {
            MaterialModel::MetallicRoughness { base_color, metallic, roughness }
        }
        _ => MaterialModel::Layered(Box::new(layers)),
    })
}

/// True if the material has parameters of a physically based model.
fn is_physically_based(mtl: &tobj::Material, maps: MaterialMaps) -> bool {
    let number = |name: &str| number(mtl, name);
    let has_maps = maps.metallic.or(maps.roughness).or(maps.clearcoat).is_some() || maps.sheen.is_some();
    has_maps
        || number("Pr").or(number("Pm")).is_some()
        || ["Ps", "Pc", "aniso"].iter().any(|name| number(name).is_some_and(|number| number > 0.0))
}

fn alpha(mtl: &tobj::Material, maps: MaterialMaps) -> Alpha {
    // A factor of zero means the map alone, as for colours.
    let factor = match (opacity(mtl), maps.alpha) {
        (0.0, Some(_)) => 1.0,
        (opacity, _) => opacity,
    };
    let blend = Alpha { mode: AlphaMode::Blend, factor, texture: maps.alpha, culls_back_faces: false };
    if is_blended(mtl, maps) { blend } else { Alpha::OPAQUE }
}

/// True if opacity is alpha, rather than the opposite of transmission.
fn is_blended(mtl: &tobj::Material, maps: MaterialMaps) -> bool {
    maps.alpha.is_some() || (opacity(mtl) < 1.0 && !is_glass(mtl) && is_physically_based(mtl, maps))
}

/// True for the illumination models of glass.
pub(super) const fn is_glass(mtl: &tobj::Material) -> bool {
    matches!(mtl.illumination_model, Some(6 | 7))
}

/// True if light passes the Phong model or the dielectric. Glass whose filter passes no light encloses no medium.
fn is_transmissive(mtl: &tobj::Material, maps: MaterialMaps, phong: &Phong) -> bool {
    let is_dielectric = is_glass(mtl) && is_physically_based(mtl, maps);
    phong.transmission.is_some() || (is_dielectric && !filter_colour(mtl).is_black())
}

/// True if meshes of the material need tangents.
pub(super) fn needs_tangents(mtl: &tobj::Material) -> bool {
    let bumps = mtl.normal_texture.is_some() || mtl.unknown_param.contains_key("norm");
    bumps || number(mtl, "aniso").is_some_and(|aniso| aniso > 0.0)
}

/// A parameter that `tobj` leaves unparsed.
fn number(mtl: &tobj::Material, name: &str) -> Option<f64> {
    mtl.unknown_param.get(name)?.parse().ok()
}

/// Factor of the texture, or colour without one.
fn base_colour(mtl: &tobj::Material, maps: MaterialMaps) -> Rgb {
    match (mtl.diffuse.map(rgb), maps.diffuse) {
        (Some(kd), None) => kd,
        (Some(kd), Some(_)) if !kd.is_black() => kd,
        // Exporters write black, or no value, for "the texture alone".
        (_, Some(_)) => Rgb::WHITE,
        (None, None) => match Phong::default().diffuse {
            ColorTexture::Constant(rgb) | ColorTexture::Textured(_, rgb) => rgb,
        },
    }
}

/// 1 for opaque materials. Where a file gives both `d` and `Tr`, they often disagree, and `d` is the older one.
fn opacity(mtl: &tobj::Material) -> f64 {
    let transparency = number(mtl, "Tr");
    match (mtl.dissolve, transparency) {
        (Some(d), _) => f64::from(d).min(1.0),
        (None, Some(tr)) => 1.0 - tr.min(1.0),
        (None, None) => 1.0,
    }
}

fn transmission(mtl: &tobj::Material, model: u8, opacity: f64) -> Option<Transmission> {
    let transmitted = match model {
        // The factor of the MTL specification for light that is not mirrored.
        6 => remainder(specular_colour(mtl)) * filter_colour(mtl),
        7 => filter_colour(mtl),
        _ => Rgb::gray(1.0 - opacity),
    };
    let coefficient = ColorTexture::Constant(transmitted);
    (!transmitted.is_black()).then_some(Transmission { coefficient, fresnel: model == 7 })
}

/// Index of refraction behind the surface: `Ni` of glass, otherwise that of air.
fn ior(mtl: &tobj::Material) -> f64 {
    let ior = mtl.optical_density.filter(|_| is_glass(mtl)).map_or(1.0, f64::from);
    if ior > 0.0 { ior } else { 1.0 }
}

/// Ks, or the factor of its texture; 0 if unspecified.
fn specular_colour(mtl: &tobj::Material) -> Rgb {
    mtl.specular.map_or(Rgb::BLACK, rgb)
}

/// Tf, the transmitted share of each colour; 1 if unspecified.
fn filter_colour(mtl: &tobj::Material) -> Rgb {
    let Some(tf) = mtl.unknown_param.get("Tf") else { return Rgb::WHITE };
    let mut numbers = tf.split_whitespace().map(|word| word.parse().unwrap_or(1.0));
    let mut next = || numbers.next().unwrap_or(1.0);
    Rgb::new(next(), next(), next())
}

/// 1 − `share` per channel, at least 0.
fn remainder(share: Rgb) -> Rgb {
    share.map(|share| (1.0 - share).max(0.0))
}

fn coefficient(texture: Option<TextureId>, colour: Rgb) -> ColorTexture {
    match texture {
        Some(id) => ColorTexture::Textured(id, colour),
        None => ColorTexture::Constant(colour),
    }
}

fn rgb(colour: [f32; 3]) -> Rgb {
    Rgb::from(colour.map(f64::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mtl(text: &str) -> tobj::Material {
        let super::super::mtl::MtlFile { materials, warnings, .. } =
            super::super::mtl::parse(&format!("newmtl m\n{text}"));
        assert!(warnings.iter().all(|(_, message)| message.ends_with("is clamped to 1")), "{warnings:?}");
        materials.into_iter().next().expect("one material")
    }

    fn made(text: &str) -> Material {
        material(&mtl(text), MaterialMaps::default(), &[])
    }

    fn physical(text: &str) -> Option<MaterialModel> {
        physically_based(&mtl(text), MaterialMaps::default(), &[])
    }

    fn gray(value: f64) -> ColorTexture {
        ColorTexture::Constant(Rgb::gray(value))
    }

    #[test]
    fn plain_materials() {
        let material = made("Kd 0.5\nKa 1\nKs 0.25\nNs 8\nKe 2\nillum 2");
        assert_eq!((material.emission, material.interior), (gray(2.0), None));
        let phong = material.to_phong();
        assert_eq!((phong.diffuse, phong.ambient), (gray(0.5), gray(0.05)));
        assert_eq!((phong.specular, phong.exponent), (gray(0.25), 8.0));
        assert_eq!((phong.mirror, phong.transmission), (ColorTexture::ZERO, None));
    }

    #[test]
    fn an_exponent_of_zero_means_no_highlight() {
        assert!(phong(&mtl("Ks 0.8\nNs 0\nillum 2"), MaterialMaps::default()).specular.is_zero());
    }

    #[test]
    fn the_illumination_model_decides_about_highlight_mirror_and_glass() {
        let text = |model: u8| format!("Kd 0.5\nKs 0.25\nNi 1.5\nTf 1 0.5 0\nillum {model}");
        let with = |model: u8| phong(&mtl(&text(model)), MaterialMaps::default());
        assert_eq!((with(1).specular, with(1).mirror), (ColorTexture::ZERO, ColorTexture::ZERO));
        assert_eq!((with(3).specular, with(3).mirror, with(3).transmission), (gray(0.25), gray(0.25), None));
        let glass = with(7).transmission.expect("glass");
        assert_eq!((glass.fresnel, glass.coefficient), (true, ColorTexture::Constant(Rgb::new(1.0, 0.5, 0.0))));
        assert_eq!(made(&text(7)).interior, Some(InteriorMedium::clear(1.5)));
        assert_eq!(with(7).mirror, gray(1.0));
        assert!(!with(6).transmission.expect("glass").fresnel);
    }

    #[test]
    fn glass_of_model_6_refracts_what_it_does_not_mirror() {
        let refracted = |text: &str, maps| phong(&mtl(text), maps).transmission.map(|part| part.coefficient);
        let (none, mapped) =
            (MaterialMaps::default(), MaterialMaps { specular: Some(TextureId(3)), ..MaterialMaps::default() });
        let coloured = Rgb::new(0.75, 0.25, 0.0);
        for maps in [none, mapped] {
            assert_eq!(
                refracted("Ks 0.25 0.5 2\nTf 1 0.5 1\nillum 6", maps),
                Some(ColorTexture::Constant(coloured)),
                "{maps:?}"
            );
        }
        assert_eq!(refracted("Ks 0.25\nillum 7", none), Some(gray(1.0)), "split by Fresnel's equations");
        assert_eq!(refracted("illum 6", none), Some(gray(1.0)), "Ks is 0 if unspecified");
        assert_eq!(refracted("Ks 1\nillum 6", none), None);
    }

    #[test]
    fn glass_has_no_diffuse_part() {
        let (none, id) = (MaterialMaps::default(), TextureId(3));
        let mapped = MaterialMaps { diffuse: Some(id), ..none };
        let diffuse = |text: &str, maps| {
            let Phong { ambient, diffuse, .. } = phong(&mtl(text), maps);
            assert_eq!(ambient.is_zero(), diffuse.is_zero(), "{text}");
            diffuse
        };
        for model in [6, 7] {
            for filter in ["", "Tf 2\n", "Tf 1 0.5 0\n"] {
                let text = format!("Kd 0.8\n{filter}illum {model}");
                assert!(diffuse(&text, none).is_zero() && diffuse(&text, mapped).is_zero(), "{text}");
            }
            assert_eq!(diffuse(&format!("Kd 0.5\nTf 0\nillum {model}"), none), gray(0.5), "{model}");
        }
        assert_eq!(diffuse("Kd 0.5\nTf 1\nillum 4", none), gray(0.5), "other models ignore Tf");
    }

    #[test]
    fn media_are_enclosed_by_surfaces_that_transmit_under_some_integrator() {
        assert_eq!(made("Ks 1\nNi 1.5\nillum 6").interior, None, "a mirror");
        assert_eq!(made("Ks 1\nNi 1.5\nPr 0\nillum 6").interior, Some(InteriorMedium::clear(1.5)), "a dielectric");
        assert_eq!(made("Ks 1\nNi 1.5\nPr 0\nTf 0\nillum 6").interior, None, "a black filter");
    }

    #[test]
    fn what_is_not_opaque_lets_the_rest_pass_straight() {
        for text in ["d 0.25\nKd 0.5", "Tr 0.75\nKd 0.5", "Tr 0.25\nd 0.25\nKd 0.5"] {
            let (material, phong) = (made(text), phong(&mtl(text), MaterialMaps::default()));
            assert_eq!(phong.diffuse, gray(0.125));
            let through = phong.transmission.expect("some light passes");
            assert_eq!((through.coefficient, through.fresnel), (gray(0.75), false));
            assert_eq!(material.interior, Some(InteriorMedium::clear(1.0)));
        }
    }

    #[test]
    fn roughness_and_metalness_make_a_physical_surface() {
        assert_eq!(physical("Kd 0.5\nNs 100"), None);
        let metal =
            |metallic, roughness| MaterialModel::MetallicRoughness { base_color: gray(0.5), metallic, roughness };
        assert_eq!(physical("Kd 0.5\nPr 0.25\nPm 1"), Some(metal(1.0, 0.25)));
        assert_eq!(physical("Kd 0.5\npm 7"), Some(metal(1.0, 0.5)));
        let glass = MaterialModel::Dielectric {
            roughness: 0.0,
            transmittance: ColorTexture::Constant(Rgb::new(1.0, 0.5, 0.0)),
        };
        assert_eq!(physical("Pr 0\nillum 7\nTf 1 0.5 0"), Some(glass));
        let (veil, none) = (mtl("Kd 0.5\nPr 0\nd 0.75"), MaterialMaps::default());
        assert_eq!(physically_based(&veil, none, &[]), Some(metal(0.0, 0.0)));
        assert_eq!((alpha(&veil, none).mode, alpha(&veil, none).factor), (AlphaMode::Blend, 0.75));
        assert!(phong(&veil, none).transmission.is_none());
    }

    #[test]
    fn maps_and_layers_make_a_layered_surface() {
        let map = |id| Some((TextureId(id), Channel::Red));
        let maps = MaterialMaps { metallic: map(1), roughness: map(2), ..MaterialMaps::default() };
        let Some(MaterialModel::Layered(layers)) = physically_based(&mtl("Kd 0.5\nPr 0.25\nPm 0"), maps, &[]) else {
            panic!("layers")
        };
        let (metallic, roughness) = (
            FloatTexture::textured(&[], TextureId(1), Channel::Red, 1.0),
            FloatTexture::textured(&[], TextureId(2), Channel::Red, 0.25),
        );
        assert_eq!(layers.base, LayeredBase::MetallicRoughness { base_color: gray(0.5), metallic, roughness });
        assert!(layers.clearcoat.is_zero() && layers.sheen_color.is_zero());

        let text = "Kd 0.5\nPc 0.75\nPcr 0.1\nPs 0.5\naniso 0.25\nanisor 0.25";
        let Some(MaterialModel::Layered(layers)) = physical(text) else { panic!("layers") };
        assert_eq!(
            (layers.clearcoat, layers.clearcoat_roughness),
            (FloatTexture::Constant(0.75), FloatTexture::Constant(0.1))
        );
        assert_eq!((layers.sheen_color, layers.anisotropy), (gray(0.5), FloatTexture::Constant(0.25)));
        assert_eq!(layers.anisotropy_rotation, TAU / 4.0);
        assert_eq!(physical("Kd 0.5\nPs 0\nPc 0\naniso 0"), None, "written by default");
    }

    #[test]
    fn a_map_of_opacity_cuts_instead_of_a_veil() {
        let (mtl, maps) =
            (mtl("Kd 0.5\nd 0.5\nPr 1"), MaterialMaps { alpha: Some(TextureId(7)), ..MaterialMaps::default() });
        let cut = alpha(&mtl, maps);
        assert_eq!((cut.mode, cut.factor, cut.texture), (AlphaMode::Blend, 0.5, Some(TextureId(7))));
        assert!(phong(&mtl, maps).transmission.is_none() && phong(&mtl, maps).diffuse == gray(0.5));
        assert_eq!(alpha(&self::mtl("d 0"), maps).factor, 1.0);
        assert!(matches!(physically_based(&mtl, maps, &[]), Some(MaterialModel::MetallicRoughness { .. })));
        assert_eq!(alpha(&self::mtl("Kd 0.5\nd 0.5"), MaterialMaps::default()), Alpha::OPAQUE);
    }

    #[test]
    fn a_texture_over_black_is_the_texture_alone() {
        let id = TextureId(3);
        let maps = MaterialMaps { diffuse: Some(id), ..MaterialMaps::default() };
        assert_eq!(phong(&mtl("Kd 0"), maps).diffuse, ColorTexture::Textured(id, Rgb::WHITE));
        assert_eq!(phong(&mtl("Ns 3"), maps).diffuse, ColorTexture::Textured(id, Rgb::WHITE));
        assert_eq!(phong(&mtl("Kd 0.5"), maps).diffuse, ColorTexture::Textured(id, Rgb::gray(0.5)));
    }
}
