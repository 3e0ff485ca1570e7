//! Conversions of layered materials.

use super::*;
use crate::FloatTexture;

fn constant(value: f64) -> FloatTexture {
    FloatTexture::Constant(value)
}

fn layered(metallic: f64, roughness: f64) -> LayeredSurface {
    let base_color = ColorTexture::Constant(Rgb::new(0.8, 0.4, 0.2));
    let (metallic, roughness) = (constant(metallic), constant(roughness));
    LayeredSurface::new(LayeredBase::MetallicRoughness { base_color, metallic, roughness })
}

fn red(coefficient: ColorTexture) -> f64 {
    coefficient.factor().r
}

#[test]
fn plastics_keep_their_colour_and_gain_a_highlight() {
    let plastic = convert_layered(&layered(0.0, 0.5));
    assert_eq!((red(plastic.diffuse), red(plastic.mirror)), (0.8, 0.0));
    assert_eq!(plastic.exponent, 30.0);
    assert!((red(plastic.specular) - 0.5 * 0.04 * 38.0 / 8.0).abs() < 1e-12);
}

#[test]
fn the_light_of_metals_moves_from_diffuse_to_mirror_as_they_get_smooth() {
    let parts = |roughness| {
        let phong = convert_layered(&layered(1.0, roughness));
        (red(phong.diffuse), red(phong.mirror))
    };
    assert_eq!([parts(0.0), parts(0.25), parts(1.0)], [(0.0, 0.8), (0.4, 0.4), (0.8, 0.0)]);
    assert_eq!(red(convert_layered(&layered(1.0, 1.0)).specular), 0.0);
}

#[test]
fn a_surface_that_is_partly_metal_gains_no_light() {
    let base_color = ColorTexture::Constant(Rgb::new(0.8, 0.4, 0.2));
    for metallic in [0.0, 0.5, 0.9, 1.0] {
        for roughness in [0.0, 0.25, 0.5, 1.0] {
            let phong = convert(&MaterialModel::MetallicRoughness { base_color, metallic, roughness });
            let as_layered = convert_layered(&layered(metallic, roughness));
            let parts = [red(phong.diffuse), red(phong.mirror), red(phong.ambient)];
            let expected = [red(as_layered.diffuse), red(as_layered.mirror), red(as_layered.ambient)];
            for (part, expected) in parts.into_iter().zip(expected) {
                assert!((part - expected).abs() < 1e-15, "{metallic} {roughness}: {phong:?} {as_layered:?}");
            }
            assert!((parts[0] + parts[1] - 0.8).abs() < 1e-15, "{metallic} {roughness}: {phong:?}");
        }
    }
}

#[test]
fn thin_glass_transmits_what_it_does_not_reflect() {
    let transmittance = ColorTexture::Constant(Rgb::WHITE);
    // 2F / (1 + F) with F = ((ior − 1) / (ior + 1))².
    for (ior, reflectance) in [(1.0, 0.0), (1.5, 0.08 / 1.04), (3.0, 0.4)] {
        let phong = convert(&MaterialModel::ThinGlass { ior, transmittance });
        let transmission = phong.transmission.expect("glass");
        assert!((red(phong.mirror) - reflectance).abs() < 1e-15, "{ior}: {phong:?}");
        assert!((red(phong.mirror) + red(transmission.coefficient) - 1.0).abs() < 1e-15, "{ior}: {phong:?}");
    }
}

/// The light that white surfaces return, whichever part Fresnel's equations reflect.
#[test]
fn no_conversion_gains_light() {
    let white = ColorTexture::Constant(Rgb::WHITE);
    let base = |metallic, roughness| LayeredBase::MetallicRoughness { base_color: white, metallic, roughness };
    let mut models = vec![
        MaterialModel::Diffuse { albedo: white, roughness: 0.5 },
        MaterialModel::Mirror { reflectance: white },
        MaterialModel::ThinGlass { ior: 1.5, transmittance: white },
        MaterialModel::MetallicRoughness { base_color: white, metallic: 0.5, roughness: 0.25 },
    ];
    for transmission in [0.0, 0.25, 0.5, 1.0] {
        for (metallic, is_thin) in [(0.0, true), (0.5, true), (1.0, true), (0.0, false), (0.5, false), (1.0, false)] {
            let layered = LayeredSurface::new(base(constant(metallic), constant(0.25)));
            let glass = LayeredSurface { transmission: constant(transmission), is_thin, ..layered };
            models.push(MaterialModel::Layered(Box::new(glass)));
        }
    }
    let pairs: Vec<_> = models.iter().flat_map(|a| models.iter().map(move |b| (a.clone(), b.clone()))).collect();
    models.extend(pairs.into_iter().map(|(a, b)| MaterialModel::Mix(vec![(0.5, a), (0.5, b)])));
    for model in &models {
        let phong = convert(model);
        for reflected in [0.0, 0.04, 0.5, 1.0] {
            let (fresnel, transmitted) =
                phong.transmission.map_or((false, 0.0), |it| (it.fresnel, red(it.coefficient)));
            let [of_mirror, of_transmission] = if fresnel { [reflected, 1.0 - reflected] } else { [1.0; 2] };
            let returned = red(phong.diffuse) + red(phong.mirror) * of_mirror + transmitted * of_transmission;
            assert!(returned <= 1.0 + 1e-12, "{returned} of {model:?}");
        }
    }
}

#[test]
fn extreme_values_stay_finite() {
    for roughness in [0.0, 1e-9, 1.0] {
        let phong = convert_layered(&layered(0.5, roughness));
        assert!(phong.exponent >= 0.0 && phong.exponent <= 1e7);
        assert!((0.0..=1.0).contains(&red(phong.specular)), "{phong:?}");
    }
}

#[test]
fn transmission_becomes_a_dielectric_with_fresnels_equations() {
    let glass = LayeredSurface { transmission: constant(1.0), ior: 1.3, is_thin: false, ..layered(0.0, 0.0) };
    let material = Material::new(String::new(), MaterialModel::Layered(Box::new(glass)));
    let phong = material.to_phong();
    assert!(phong.diffuse.is_zero());
    assert!(phong.transmission.expect("a dielectric").fresnel && red(phong.mirror) == 1.0);
    assert_eq!((material.phong_interior(), material.interior), (Some(InteriorMedium::clear(1.3)), None));
}

/// F0 = ((2 − 1)/(2 + 1))², of half of the surface.
#[test]
fn thin_layered_glass_reflects() {
    let thin = LayeredSurface { transmission: constant(0.5), ior: 2.0, ..layered(0.0, 0.0) };
    let phong = convert_layered(&thin);
    let transmission = phong.transmission.expect("thin glass");
    assert!(!transmission.fresnel && (red(phong.mirror) - 0.5 / 9.0).abs() < 1e-15, "{phong:?}");
    assert!((red(transmission.coefficient) - 0.8 * 0.5 * 8.0 / 9.0).abs() < 1e-15, "{phong:?}");
}

#[test]
fn specular_glossiness_has_one_base_color() {
    let of = |diffuse: f64, mean_specular: Rgb, glossiness: f64| {
        let diffuse = ColorTexture::Constant(Rgb::gray(diffuse));
        let (specular, glossiness) = (ColorTexture::Constant(mean_specular), constant(glossiness));
        let base =
            LayeredBase::SpecularGlossiness { diffuse, specular, glossiness, base_color: diffuse, mean_specular };
        base_parameters(&base)
    };
    let (color, metallic, roughness) = of(0.5, Rgb::gray(0.04), 0.75);
    assert_eq!((color.factor(), metallic, roughness), (Rgb::gray(0.5), 0.0, 0.25));
    let gold = of(0.0, Rgb::new(1.0, 0.8, 0.3), 1.0);
    assert_eq!((gold.1, gold.0.factor()), (1.0, Rgb::new(1.0, 0.8, 0.3)));
}

#[test]
fn an_override_replaces_the_conversion() {
    let white = ColorTexture::Constant(Rgb::WHITE);
    let mut material = Material::new(String::new(), MaterialModel::Mirror { reflectance: white });
    assert_eq!(material.to_phong().mirror, white);
    material.phong_override = Some(Phong::default());
    assert_eq!(*material.to_phong(), Phong::default());
}

/// A weighted sum, of which each coefficient keeps its first texture.
#[test]
fn mixes_are_sums() {
    let gray = |value| ColorTexture::Constant(Rgb::gray(value));
    let diffuse = MaterialModel::Diffuse { albedo: gray(0.5), roughness: 0.0 };
    let mix = MaterialModel::Mix(vec![(0.5, diffuse), (0.25, MaterialModel::Mirror { reflectance: gray(1.0) })]);
    let phong = convert(&mix);
    assert_eq!((phong.diffuse, phong.mirror, phong.transmission), (gray(0.25), gray(0.25), None));
}
