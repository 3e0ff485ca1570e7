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
//! Materials with `Pr` or `Pm` are meant for physical integrators as well, which then see the metallic-roughness model of
//! glTF with base colour `Kd · map_Kd`, metalness `Pm` and roughness `Pr`; models 6 and 7 make glass of them.

use rt_math::Rgb;
use rt_shading::{Coefficient, Highlight, Phong, Physical, TextureId, Transmission};

/// The textures of a material, where they could be loaded.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Maps {
    pub(super) diffuse: Option<TextureId>,
    pub(super) specular: Option<TextureId>,
    pub(super) emission: Option<TextureId>,
}

/// Share of the diffuse coefficient that ambient light sees.
const AMBIENT_SHARE: f64 = 0.1;

/// Largest exponent of a highlight; it is narrower than a pixel by far.
const MAX_EXPONENT: f64 = 1e7;

/// The surface of an MTL material. All numbers of `mtl` must be finite and not negative.
pub(super) fn phong(mtl: &tobj::Material, maps: Maps) -> Phong {
    let model = mtl.illumination_model.unwrap_or(2);
    let opacity = opacity(mtl);
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
            Coefficient::ZERO
        },
        exponent: mtl.shininess.map_or(default.exponent, |ns| f64::from(ns).min(MAX_EXPONENT)),
        highlight: Highlight::Blinn,
        emission: coefficient(maps.emission, ke),
        mirror: match model {
            3..=6 | 8 | 9 => coefficient(maps.specular, ks),
            7 => Coefficient::Constant(Rgb::WHITE),
            _ => Coefficient::ZERO,
        },
        transmission: transmission(mtl, model, opacity),
    }
}

/// The physical surface, of a material that says how rough or metallic it is.
pub(super) fn physical(mtl: &tobj::Material, maps: Maps) -> Option<Physical> {
    let number = |name: &str| mtl.unknown_param.get(name).and_then(|text| text.parse::<f64>().ok());
    let (roughness, metallic) = (number("Pr"), number("Pm"));
    if roughness.is_none() && metallic.is_none() {
        return None;
    }
    // What the file leaves out is what programs with these parameters begin with.
    let (roughness, metallic) = (roughness.unwrap_or(0.5).min(1.0), metallic.unwrap_or(0.0).min(1.0));
    if matches!(mtl.illumination_model, Some(6 | 7)) {
        return Some(Physical::Dielectric { roughness, transmittance: Coefficient::Constant(filter_colour(mtl)) });
    }
    let base_color = coefficient(maps.diffuse, base_colour(mtl, maps));
    let surface = Physical::MetallicRoughness { base_color, metallic, roughness };
    Some(match opacity(mtl) {
        1.0 => surface,
        opacity => {
            let opening = Physical::Dielectric { roughness: 0.0, transmittance: Coefficient::Constant(Rgb::WHITE) };
            Physical::Mix(vec![(opacity, surface), (1.0 - opacity, opening)])
        }
    })
}

/// The colour that the texture is multiplied by, or that takes its place.
fn base_colour(mtl: &tobj::Material, maps: Maps) -> Rgb {
    match (mtl.diffuse.map(rgb), maps.diffuse) {
        (Some(kd), None) => kd,
        (Some(kd), Some(_)) if !kd.is_black() => kd,
        // Exporters that mean "the texture alone" write black, or nothing.
        (_, Some(_)) => Rgb::WHITE,
        (None, None) => match Phong::default().diffuse {
            Coefficient::Constant(rgb) | Coefficient::Textured(_, rgb) => rgb,
        },
    }
}

/// 1 for opaque materials. Where a file gives both `d` and `Tr`, they often disagree, and `d` is the older one.
fn opacity(mtl: &tobj::Material) -> f64 {
    let transparency = mtl.unknown_param.get("Tr").and_then(|tr| tr.parse::<f64>().ok());
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
    let coefficient = Coefficient::Constant(filter);
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

fn coefficient(texture: Option<TextureId>, colour: Rgb) -> Coefficient {
    match texture {
        Some(id) => Coefficient::Textured(id, colour),
        None => Coefficient::Constant(colour),
    }
}

fn rgb(colour: [f32; 3]) -> Rgb {
    Rgb::from(colour.map(f64::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mtl(text: &str) -> tobj::Material {
        let (materials, complaints) = super::super::mtl::parse(&format!("newmtl m\n{text}"));
        assert_eq!(complaints, []);
        materials.into_iter().next().expect("one material")
    }

    fn gray(value: f64) -> Coefficient {
        Coefficient::Constant(Rgb::gray(value))
    }

    #[test]
    fn plain_materials() {
        let phong = phong(&mtl("Kd 0.5\nKa 1\nKs 0.25\nNs 8\nKe 2\nillum 2"), Maps::default());
        assert_eq!((phong.diffuse, phong.ambient), (gray(0.5), gray(0.05)));
        assert_eq!((phong.specular, phong.exponent, phong.emission), (gray(0.25), 8.0, gray(2.0)));
        assert_eq!((phong.mirror, phong.transmission), (Coefficient::ZERO, None));
    }

    #[test]
    fn an_exponent_of_zero_means_no_highlight() {
        assert!(phong(&mtl("Ks 0.8\nNs 0\nillum 2"), Maps::default()).specular.is_zero());
    }

    #[test]
    fn the_illumination_model_decides_about_highlight_mirror_and_glass() {
        let with =
            |model: u8| phong(&mtl(&format!("Kd 0.5\nKs 0.25\nNi 1.5\nTf 1 0.5 0\nillum {model}")), Maps::default());
        assert_eq!((with(1).specular, with(1).mirror), (Coefficient::ZERO, Coefficient::ZERO));
        assert_eq!((with(3).specular, with(3).mirror, with(3).transmission), (gray(0.25), gray(0.25), None));
        let glass = with(7).transmission.expect("glass");
        assert_eq!(
            (glass.ior, glass.fresnel, glass.coefficient),
            (1.5, true, Coefficient::Constant(Rgb::new(1.0, 0.5, 0.0)))
        );
        assert_eq!(with(7).mirror, gray(1.0));
        assert!(!with(6).transmission.expect("glass").fresnel);
    }

    #[test]
    fn what_is_not_opaque_lets_the_rest_pass_straight() {
        for text in ["d 0.25\nKd 0.5", "Tr 0.75\nKd 0.5", "Tr 0.25\nd 0.25\nKd 0.5"] {
            let phong = phong(&mtl(text), Maps::default());
            assert_eq!(phong.diffuse, gray(0.125));
            let through = phong.transmission.expect("some light passes");
            assert_eq!((through.coefficient, through.ior, through.fresnel), (gray(0.75), 1.0, false));
        }
    }

    #[test]
    fn roughness_and_metalness_make_a_physical_surface() {
        let of = |text: &str| physical(&mtl(text), Maps::default());
        assert_eq!(of("Kd 0.5\nNs 100"), None);
        let metal = |metallic, roughness| Physical::MetallicRoughness { base_color: gray(0.5), metallic, roughness };
        assert_eq!(of("Kd 0.5\nPr 0.25\nPm 1"), Some(metal(1.0, 0.25)));
        assert_eq!(of("Kd 0.5\npm 7"), Some(metal(1.0, 0.5)));
        let glass =
            Physical::Dielectric { roughness: 0.0, transmittance: Coefficient::Constant(Rgb::new(1.0, 0.5, 0.0)) };
        assert_eq!(of("Pr 0\nillum 7\nTf 1 0.5 0"), Some(glass));
        let Some(Physical::Mix(parts)) = of("Kd 0.5\nPr 0\nd 0.75") else { panic!("a veil") };
        assert_eq!(parts.iter().map(|(share, _)| *share).collect::<Vec<_>>(), [0.75, 0.25]);
    }

    #[test]
    fn a_texture_over_black_is_the_texture_alone() {
        let id = TextureId(3);
        let maps = Maps { diffuse: Some(id), ..Maps::default() };
        assert_eq!(phong(&mtl("Kd 0"), maps).diffuse, Coefficient::Textured(id, Rgb::WHITE));
        assert_eq!(phong(&mtl("Ns 3"), maps).diffuse, Coefficient::Textured(id, Rgb::WHITE));
        assert_eq!(phong(&mtl("Kd 0.5"), maps).diffuse, Coefficient::Textured(id, Rgb::gray(0.5)));
    }
}
