//! Many lights, and lights of very different power.

use rt_image::{Development, ToneCurve};
use rt_math::{DVec3, Rgb};
use rt_render::{PlanOptions, RenderPlan, RunOptions};
use rt_scene_io::Integrator;
use rt_shading::{
    ColorTexture,
    light::{EmissionSides, LightSampling},
};

use super::{
    Case, Checks, Conditions, Fallible,
    area_light::{AreaLight, Receiver, check_image},
    cases,
    test_image::TestImage,
};

cases! {
    "many-lights", "50 lights of all kinds and sizes, each way to choose among them",
        "the sum of their closed forms", "5 σ", many;
    "S69", "lights of radiance 1e-30 and 1e30 in one scene",
        "½ Σ Γᵢ · n where either is seen; finite, and an image", "5 σ", extreme;
}

fn many(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let receiver = Receiver::ground(0.05);
    let many_lights: Vec<AreaLight> = (0..50)
        .map(|i| {
            let (x, y) = (f64::from(i % 7) - 3.0, f64::from(i / 7) - 3.0);
            let centre = DVec3::new(x, y, 0.3 + 0.1 * f64::from(i % 5));
            match i % 3 {
                0 => AreaLight::Sphere { centre, radius: 0.02 + 0.01 * f64::from(i % 4) },
                1 => AreaLight::Disk { centre, normal: DVec3::NEG_Z, radius: 0.1 },
                _ => AreaLight::Quad(centre, [DVec3::Y * 0.2, DVec3::X * 0.3]),
            }
        })
        .collect();
    let truth = many_lights.iter().map(|area_light| area_light.irradiance(&receiver)).sum();
    let (first, others) = (
        &many_lights[0],
        many_lights[1..].iter().map(|area_light| area_light.node("lamp")).collect::<Vec<_>>().join(", "),
    );
    for sampling in LightSampling::ALL {
        let mut image = first.scene(&receiver, 1e-9, &others)?;
        image.scene.settings.light_sampling = sampling;
        let effort = [conditions.count(64, 256), conditions.count(256, 1024)];
        check_image(checks, &format!("chosen by {}", sampling.name()), truth, &image, effort)?;
    }
    Ok(())
}

const STRONG: f64 = 1e30;
const WEAK: f64 = 1e-30;

/// Two squares that emit downwards, or the strong one upwards.
fn two(strong_is_seen: bool) -> Fallible<(TestImage, f64)> {
    let receiver = Receiver::ground(0.5);
    let weak = AreaLight::square(1.0, -0.6);
    let corner = DVec3::new(0.1, 0.1, 1.0);
    let strong = AreaLight::Quad(corner, if strong_is_seen { [DVec3::Y, DVec3::X] } else { [DVec3::X, DVec3::Y] });
    let mut image = weak.scene(&receiver, 1e-9, &strong.node("black"))?;
    for material in &mut image.scene.appearance.materials {
        let radiance = match material.name.as_str() {
            "lamp" => WEAK,
            "black" => STRONG,
            _ => continue,
        };
        material.emission = ColorTexture::Constant(Rgb::gray(radiance));
        material.emission_sides = EmissionSides::Front;
    }
    let seen = if strong_is_seen { STRONG * strong.irradiance(&receiver) } else { 0.0 };
    Ok((image, WEAK * weak.irradiance(&receiver) + seen))
}

fn extreme(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let effort = conditions.effort();
    for (strong_is_seen, samplings) in [
        (true, &LightSampling::ALL[..]),
        // By power alone the weak one is chosen once in 10⁶⁰ times.
        (false, &[LightSampling::Uniform, LightSampling::Tree]),
    ] {
        let (mut image, truth) = two(strong_is_seen)?;
        for sampling in samplings {
            image.scene.settings.light_sampling = *sampling;
            let what = format!("{}, chosen by {}", if strong_is_seen { "both" } else { "weak" }, sampling.name());
            check_image(checks, &what, truth, &image, effort)?;
        }
        developed(checks, &mut image, if strong_is_seen { 255 } else { 0 })?;
    }
    Ok(())
}

/// The film holds numbers, and the image is all bright or all dark.
fn developed(checks: &mut Checks, image: &mut TestImage, expected: u8) -> Fallible<()> {
    image.scene.settings.integrator = Integrator::Path;
    (image.scene.film.width, image.scene.film.height) = (4, 4);
    let plan = RenderPlan::compile(&image.scene, &PlanOptions::default())?;
    let rendering = plan.render(&RunOptions::default(), |_| {})?;
    checks.same(rendering.statistics.bad_samples, 0, "bad samples");
    let values = rendering.film.pixels().as_flattened();
    checks.check(values.iter().all(|value| value.is_finite() && *value > 0.0), || format!("{values:?}"));
    for tone in [ToneCurve::Clamp, ToneCurve::Reinhard, ToneCurve::Aces] {
        let bytes = Development { tone, ..Development::default() }.develop(&rendering.film).bytes;
        checks.check(bytes.iter().all(|byte| *byte == expected), || format!("{tone:?}: {bytes:?}"));
    }
    Ok(())
}
