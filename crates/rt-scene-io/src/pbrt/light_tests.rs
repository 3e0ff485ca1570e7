//! Tests of lights.

use rt_math::{DVec3, transcendental};
use rt_shading::{ColorTexture, DeltaLight, DeltaLightKind};

use super::tests::{good, shapes, world};
use crate::format::{Background, Color};

/// Such a light was a black surface with emission. pbrt-v4 has neither the light nor the surface.
#[test]
fn area_lights_of_interfaces_are_left_out() {
    let light = "AttributeBegin Material \"interface\" AreaLightSource \"diffuse\" Shape \"sphere\" AttributeEnd";
    let model = good(&world(light));
    assert_eq!((shapes(&model).len(), model.materials.len(), &model.background), (1, 1, &None));
    let message = "a shape without material is invisible: it is left out, and its area light is ignored, as in pbrt";
    assert_eq!(model.messages(), [message]);
}

/// The invisible lights of pbrt-v4 gave no light, without a warning.
#[test]
fn area_lights_of_alpha_0_are_warned_of() {
    let light = |alpha: &str| {
        let mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]";
        good(&world(&format!("AttributeBegin AreaLightSource \"diffuse\" {mesh} {alpha} AttributeEnd"))).warnings
    };
    let warnings = light("\"float alpha\" 0");
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert_eq!(warnings[0].message, "an area light of alpha 0 is not supported: it gives no light");
    assert_eq!((light("\"float alpha\" 0.5"), light("")), (Vec::new(), Vec::new()));
}

/// Their radiance and intensity were the mean of the spectrum.
#[test]
fn spectra_give_lights_a_colour_and_no_level() {
    let model = good(&world(
        "LightSource \"point\" \"spectrum I\" [200 100 900 100] \"float scale\" 2\n\
         LightSource \"infinite\" \"spectrum L\" [200 100 900 100]\n\
         AreaLightSource \"diffuse\" \"spectrum L\" [200 100 900 100]",
    ));
    let ColorTexture::Constant(radiance) = model.materials[0].emission else { panic!("a constant") };
    let of = [radiance, model.lights[0].intensity / 2.0];
    assert!(of.iter().all(|rgb| (rgb.luminance() - 1.0).abs() < 1e-12), "{of:?}");
    let sky = Color::from_rgb(radiance.to_array());
    assert_eq!(model.background, Some(Background::Constant(sky)));
    assert_eq!(model.warnings, []);
}

/// The spot of a file with these parameters.
fn spot(parameters: &str) -> (DeltaLight, Vec<String>) {
    let model = good(&world(&format!("LightSource \"spot\" {parameters}")));
    (model.lights[0].clone(), model.warnings.iter().map(|warning| warning.message.clone()).collect())
}

/// Flux of a spot at the origin along −z: the integral of its intensity over all directions.
fn flux(light: &DeltaLight) -> f64 {
    const STEPS: u32 = 100_000;
    let strength = |step: u32| {
        let cos = 1.0 - 2.0 * (f64::from(step) + 0.5) / f64::from(STEPS);
        let sample = light.sample_li(DVec3::new((1.0 - cos * cos).sqrt(), 0.0, -cos));
        sample.map_or(0.0, |sample| sample.strength.g)
    };
    (0..STEPS).map(strength).sum::<f64>() * 2.0 * std::f64::consts::TAU / f64::from(STEPS)
}

/// The factor was that of another ramp: a spot of 25° with an edge of 10° emitted 85 % of its power.
#[test]
fn spots_emit_their_power() {
    for cone in [
        "\"float coneangle\" 25 \"float conedeltaangle\" 10",
        "\"float coneangle\" 60 \"float conedeltaangle\" 60",
        "\"float coneangle\" 45 \"float conedeltaangle\" 0",
        "\"float coneangle\" 100",
    ] {
        let (light, _) = spot(&format!("\"float power\" 7 \"rgb I\" [2 2 2] {cone}"));
        assert!((flux(&light) / 14.0 - 1.0).abs() < 1e-3, "{cone}: {}", flux(&light));
    }
}

/// Such files were refused.
#[test]
fn spots_of_any_cone_are_read() {
    let cone = |parameters: &str| {
        let (light, warnings) = spot(parameters);
        let DeltaLightKind::Spot { cos_inner, cos_outer, .. } = light.kind else { panic!("a spot") };
        let degrees = [cos_inner, cos_outer].map(|cos| transcendental::acos(cos).to_degrees().round());
        (degrees, warnings)
    };
    // pbrt-v4 takes the cosine of -10 degrees.
    let (degrees, warnings) = cone("\"float coneangle\" 30 \"float conedeltaangle\" 40");
    assert_eq!(degrees, [10.0, 30.0]);
    assert_eq!(warnings, ["the falloff of a spot begins -10 degrees from its axis: 10 is used"]);
    assert_eq!(cone("\"float coneangle\" 30 \"float conedeltaangle\" 70").0, [0.0, 30.0]);
    assert_eq!(cone("\"float coneangle\" 3").0, [2.0, 3.0]);
    let (degrees, warnings) = cone("\"float coneangle\" 92");
    assert_eq!(degrees, [87.0, 90.0]);
    assert_eq!(warnings, ["a spot of 92 degrees from its axis is not supported: 90 is used"]);
    assert_eq!(cone("\"float coneangle\" 180").0, [90.0, 90.0]);
    assert_eq!(cone("\"float coneangle\" 90 \"float conedeltaangle\" 90"), ([0.0, 90.0], Vec::new()));
}
