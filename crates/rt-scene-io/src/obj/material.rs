//! MTL materials as Phong surfaces, and as physical ones where they have the parameters of those.
//!
//! ```text
//! diffuse      = d · Kd · map_Kd
//! ambient      = 1/10 of it: most exporters write a Ka that no one has ever looked at
//! specular     = Ks · map_Ks from illumination model 2 on, with the half vector of Blinn and exponent Ns
//! emission     = Ke · map_Ke
//! mirror       = Ks       for models 3, 4, 5, 8, 9 (reflection) and 6 (refraction); all for 7 (Fresnel)
//! transmission = Tf       for models 6 and 7, bent by Ni; 7 shares the light by Fresnel's equations
//!              = 1 − d    otherwise, without bending
//! ```
//!
//! Materials with one of the physical parameters are meant for physical integrators as well, which then see the
//! metallic-roughness model of glTF; models 6 and 7 make glass of it.
//!
//! ```text
//! base colour = Kd · map_Kd        metalness  = Pm · map_Pm       roughness = Pr · map_Pr
//! coat        = Pc · map_Pc, roughness Pcr                        fibres    = Ps · map_Ps
//! anisotropy  = aniso, turned by anisor of a whole turn
//! ```
//!
//! Where there is a `map_d`, and on physical surfaces other than glass, what is not opaque is cut out: a ray meets the surface
//! with the probability `d · map_d`, and passes it straight otherwise.

use std::f64::consts::TAU;

use rt_math::Rgb;
use rt_shading::{
    Alpha, Channel, ColorTexture, Coverage, FloatTexture, Highlight, LayeredBase, LayeredSurface, Phong, Physical,
    Relief, TextureId, Transmission,
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
    pub(super) coat: Option<(TextureId, Channel)>,
    pub(super) sheen: Option<TextureId>,
    /// How much of the surface is there.
    pub(super) cover: Option<TextureId>,
    /// Normals, or heights that were made normals.
    pub(super) relief: Option<Relief>,
}

/// Roughness where a file with physical parameters leaves it out: what programs with these parameters begin with.
const ROUGHNESS: f64 = 0.5;

/// Share of the diffuse coefficient that ambient light sees.
const AMBIENT_SHARE: f64 = 0.1;

/// The surface of an MTL material. All numbers of `mtl` must be finite and not negative.
pub(super) fn phong(mtl: &tobj::Material, maps: MaterialMaps) -> Phong {
    let model = mtl.illumination_model.unwrap_or(2);
    let opacity = if is_cut(mtl, maps) { 1.0 } else { opacity(mtl) };
    let default = Phong::default();
    let kd = base_colour(mtl, maps);
    let ks = mtl.specular.map_or(Rgb::BLACK, rgb);
    let ke = match (mtl.emissive.map(rgb), maps.emission) {
        (None, Some(_)) => Rgb::WHITE,
        (ke, _) => ke.unwrap_or(Rgb::BLACK),
    };

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
        emission: coefficient(maps.emission, ke),
        mirror: match model {
            3..=6 | 8 | 9 => coefficient(maps.specular, ks),
            7 => ColorTexture::Constant(Rgb::WHITE),
            _ => ColorTexture::ZERO,
        },
        transmission: transmission(mtl, model, opacity),
    }
}

/// The physical surface, of a material that has physical parameters.
pub(super) fn physical(mtl: &tobj::Material, maps: MaterialMaps) -> Option<Physical> {
    let number = |name: &str| number(mtl, name);
    let has_maps = maps.metallic.or(maps.roughness).or(maps.coat).is_some() || maps.sheen.is_some();
    let is_physical = has_maps
        || number("Pr").or(number("Pm")).is_some()
        || ["Ps", "Pc", "aniso"].iter().any(|name| number(name).is_some_and(|number| number > 0.0));
    if !is_physical {
        return None;
    }
    // A factor of a map that is missing or zero means the map alone, as with colours.
    let scalar = |name: &str, map: Option<(TextureId, Channel)>, otherwise: f64| match (number(name), map) {
        (factor, Some((id, channel))) => {
            FloatTexture::Textured(id, channel, factor.filter(|factor| *factor > 0.0).unwrap_or(1.0).min(1.0))
        }
        (factor, None) => FloatTexture::Constant(factor.unwrap_or(otherwise).min(1.0)),
    };
    if is_glass(mtl) {
        let roughness = number("Pr").unwrap_or(ROUGHNESS).min(1.0);
        return Some(Physical::Dielectric { roughness, transmittance: ColorTexture::Constant(filter_colour(mtl)) });
    }
    let base_color = coefficient(maps.diffuse, base_colour(mtl, maps));
    let (metallic, roughness) = (scalar("Pm", maps.metallic, 0.0), scalar("Pr", maps.roughness, ROUGHNESS));
    let fibres = match (number("Ps"), maps.sheen) {
        (factor, Some(_)) => factor.filter(|factor| *factor > 0.0).unwrap_or(1.0),
        (factor, None) => factor.unwrap_or(0.0),
    };
    let layers = LayeredSurface {
        coat: scalar("Pc", maps.coat, 0.0),
        coat_roughness: FloatTexture::Constant(number("Pcr").unwrap_or(0.0).min(1.0)),
        sheen_color: coefficient(maps.sheen, Rgb::gray(fibres.min(1.0))),
        sheen_roughness: FloatTexture::Constant(ROUGHNESS),
        anisotropy: FloatTexture::Constant(number("aniso").unwrap_or(0.0).min(1.0)),
        anisotropy_rotation: TAU * number("anisor").unwrap_or(0.0).min(1.0),
        ..LayeredSurface::new(LayeredBase::MetallicRoughness { base_color, metallic, roughness })
    };
    let is_bare = layers.coat.is_zero() && layers.sheen_color.is_zero() && layers.anisotropy.is_zero();
    Some(match (metallic, roughness) {
        (FloatTexture::Constant(metallic), FloatTexture::Constant(roughness)) if is_bare => {
            Physical::MetallicRoughness { base_color, metallic, roughness }
        }
        _ => Physical::Layered(Box::new(layers)),
    })
}

/// What rays pass as if it were not there.
pub(super) fn coverage(mtl: &tobj::Material, maps: MaterialMaps) -> Coverage {
    // As with colours, a factor of zero means the map alone.
    let factor = match (opacity(mtl), maps.cover) {
        (0.0, Some(_)) => 1.0,
        (opacity, _) => opacity,
    };
    let cut = Coverage { alpha: Alpha::Blend, factor, texture: maps.cover, has_front_only: false };
    if is_cut(mtl, maps) { cut } else { Coverage::ALL }
}

/// True if rays pass what is not opaque, rather than that the surface lets light through.
fn is_cut(mtl: &tobj::Material, maps: MaterialMaps) -> bool {
    maps.cover.is_some() || (opacity(mtl) < 1.0 && !is_glass(mtl) && physical(mtl, maps).is_some())
}

/// True for the illumination models of glass.
pub(super) const fn is_glass(mtl: &tobj::Material) -> bool {
    matches!(mtl.illumination_model, Some(6 | 7))
}

/// True if the surface has a direction along which it is laid: its meshes need tangents.
pub(super) fn needs_tangents(mtl: &tobj::Material) -> bool {
    let bumps = mtl.normal_texture.is_some() || mtl.unknown_param.contains_key("norm");
    bumps || number(mtl, "aniso").is_some_and(|aniso| aniso > 0.0)
}

/// A parameter that `tobj` does not know.
fn number(mtl: &tobj::Material, name: &str) -> Option<f64> {
    mtl.unknown_param.get(name)?.parse().ok()
}

/// The colour that the texture is multiplied by, or that takes its place.
fn base_colour(mtl: &tobj::Material, maps: MaterialMaps) -> Rgb {
    match (mtl.diffuse.map(rgb), maps.diffuse) {
        (Some(kd), None) => kd,
        (Some(kd), Some(_)) if !kd.is_black() => kd,
        // Exporters that mean "the texture alone" write black, or nothing.
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
    let (filter, ior) = match model {
        6 | 7 => {
            let ior = mtl.optical_density.map_or(1.0, f64::from);
            (filter_colour(mtl), if ior > 0.0 { ior } else { 1.0 })
        }
        _ => (Rgb::gray(1.0 - opacity), 1.0),
    };
    let coefficient = ColorTexture::Constant(filter);
    let (fresnel, absorption, priority) = (model == 7, Rgb::BLACK, 0);
    (!filter.is_black()).then_some(Transmission { coefficient, ior, fresnel, absorption, priority })
}

/// Tf, the share of each colour that passes; all of it if the file does not say.
fn filter_colour(mtl: &tobj::Material) -> Rgb {
    let Some(tf) = mtl.unknown_param.get("Tf") else { return Rgb::WHITE };
    let mut numbers = tf.split_whitespace().map(|word| word.parse().unwrap_or(1.0));
    let mut next = || numbers.next().unwrap_or(1.0);
    Rgb::new(next(), next(), next())
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
        assert_eq!(warnings, []);
        materials.into_iter().next().expect("one material")
    }

    fn gray(value: f64) -> ColorTexture {
        ColorTexture::Constant(Rgb::gray(value))
    }

    #[test]
    fn plain_materials() {
        let phong = phong(&mtl("Kd 0.5\nKa 1\nKs 0.25\nNs 8\nKe 2\nillum 2"), MaterialMaps::default());
        assert_eq!((phong.diffuse, phong.ambient), (gray(0.5), gray(0.05)));
        assert_eq!((phong.specular, phong.exponent, phong.emission), (gray(0.25), 8.0, gray(2.0)));
        assert_eq!((phong.mirror, phong.transmission), (ColorTexture::ZERO, None));
    }

    #[test]
    fn an_exponent_of_zero_means_no_highlight() {
        assert!(phong(&mtl("Ks 0.8\nNs 0\nillum 2"), MaterialMaps::default()).specular.is_zero());
    }

    #[test]
    fn the_illumination_model_decides_about_highlight_mirror_and_glass() {
        let with = |model: u8| {
            phong(&mtl(&format!("Kd 0.5\nKs 0.25\nNi 1.5\nTf 1 0.5 0\nillum {model}")), MaterialMaps::default())
        };
        assert_eq!((with(1).specular, with(1).mirror), (ColorTexture::ZERO, ColorTexture::ZERO));
        assert_eq!((with(3).specular, with(3).mirror, with(3).transmission), (gray(0.25), gray(0.25), None));
        let glass = with(7).transmission.expect("glass");
        assert_eq!(
            (glass.ior, glass.fresnel, glass.coefficient),
            (1.5, true, ColorTexture::Constant(Rgb::new(1.0, 0.5, 0.0)))
        );
        assert_eq!(with(7).mirror, gray(1.0));
        assert!(!with(6).transmission.expect("glass").fresnel);
    }

    #[test]
    fn what_is_not_opaque_lets_the_rest_pass_straight() {
        for text in ["d 0.25\nKd 0.5", "Tr 0.75\nKd 0.5", "Tr 0.25\nd 0.25\nKd 0.5"] {
            let phong = phong(&mtl(text), MaterialMaps::default());
            assert_eq!(phong.diffuse, gray(0.125));
            let through = phong.transmission.expect("some light passes");
            assert_eq!((through.coefficient, through.ior, through.fresnel), (gray(0.75), 1.0, false));
        }
    }

    #[test]
    fn roughness_and_metalness_make_a_physical_surface() {
        let of = |text: &str| physical(&mtl(text), MaterialMaps::default());
        assert_eq!(of("Kd 0.5\nNs 100"), None);
        let metal = |metallic, roughness| Physical::MetallicRoughness { base_color: gray(0.5), metallic, roughness };
        assert_eq!(of("Kd 0.5\nPr 0.25\nPm 1"), Some(metal(1.0, 0.25)));
        assert_eq!(of("Kd 0.5\npm 7"), Some(metal(1.0, 0.5)));
        let glass =
            Physical::Dielectric { roughness: 0.0, transmittance: ColorTexture::Constant(Rgb::new(1.0, 0.5, 0.0)) };
        assert_eq!(of("Pr 0\nillum 7\nTf 1 0.5 0"), Some(glass));
        let (veil, none) = (mtl("Kd 0.5\nPr 0\nd 0.75"), MaterialMaps::default());
        assert_eq!(physical(&veil, none), Some(metal(0.0, 0.0)));
        assert_eq!((coverage(&veil, none).alpha, coverage(&veil, none).factor), (Alpha::Blend, 0.75));
        assert!(phong(&veil, none).transmission.is_none());
    }

    #[test]
    fn maps_and_layers_make_a_layered_surface() {
        let map = |id| Some((TextureId(id), Channel::Red));
        let maps = MaterialMaps { metallic: map(1), roughness: map(2), ..MaterialMaps::default() };
        let Some(Physical::Layered(layers)) = physical(&mtl("Kd 0.5\nPr 0.25\nPm 0"), maps) else { panic!("layers") };
        let (metallic, roughness) = (
            FloatTexture::Textured(TextureId(1), Channel::Red, 1.0),
            FloatTexture::Textured(TextureId(2), Channel::Red, 0.25),
        );
        assert_eq!(layers.base, LayeredBase::MetallicRoughness { base_color: gray(0.5), metallic, roughness });
        assert!(layers.coat.is_zero() && layers.sheen_color.is_zero());

        let text = "Kd 0.5\nPc 0.75\nPcr 0.1\nPs 0.5\naniso 0.25\nanisor 0.25";
        let Some(Physical::Layered(layers)) = physical(&mtl(text), MaterialMaps::default()) else { panic!("layers") };
        assert_eq!((layers.coat, layers.coat_roughness), (FloatTexture::Constant(0.75), FloatTexture::Constant(0.1)));
        assert_eq!((layers.sheen_color, layers.anisotropy), (gray(0.5), FloatTexture::Constant(0.25)));
        assert_eq!(layers.anisotropy_rotation, TAU / 4.0);
        assert_eq!(physical(&mtl("Kd 0.5\nPs 0\nPc 0\naniso 0"), MaterialMaps::default()), None, "written by default");
    }

    #[test]
    fn a_map_of_opacity_cuts_instead_of_a_veil() {
        let (mtl, maps) =
            (mtl("Kd 0.5\nd 0.5\nPr 1"), MaterialMaps { cover: Some(TextureId(7)), ..MaterialMaps::default() });
        let cut = coverage(&mtl, maps);
        assert_eq!((cut.alpha, cut.factor, cut.texture), (Alpha::Blend, 0.5, Some(TextureId(7))));
        assert!(phong(&mtl, maps).transmission.is_none() && phong(&mtl, maps).diffuse == gray(0.5));
        assert_eq!(coverage(&self::mtl("d 0"), maps).factor, 1.0);
        assert!(matches!(physical(&mtl, maps), Some(Physical::MetallicRoughness { .. })));
        assert_eq!(coverage(&self::mtl("Kd 0.5\nd 0.5"), MaterialMaps::default()), Coverage::ALL);
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
