//! Many lights, and lights of very different power.

use rt_image::{Development, ToneCurve};
use rt_math::{DVec3, Rgb};
use rt_render::{PlanOptions, RenderPlan, RunOptions};
use rt_scene_io::Integrator;
use rt_shading::{
    ColorTexture,
    emitter::{LightSampling, Sides},
};

use super::{
    Case, Conditions, Fallible, Found, Tally, cases,
    lamp::{Lamp, Receiver, hold_picture},
    picture::Picture,
};

cases! {
    "many-lights", "50 lights of all kinds and sizes, each way to choose among them",
        "the sum of their closed forms", "5 σ", many;
    "S69", "lights of radiance 1e-30 and 1e30 in one scene",
        "½ Σ Γᵢ · n where either is seen; finite, and a picture", "5 σ", extreme;
}

fn many(conditions: &Conditions) -> Found {
    let receiver = Receiver::ground(0.05);
    let lamps: Vec<Lamp> = (0..50)
        .map(|i| {
            let (x, y) = (f64::from(i % 7) - 3.0, f64::from(i / 7) - 3.0);
            let centre = DVec3::new(x, y, 0.3 + 0.1 * f64::from(i % 5));
            match i % 3 {
                0 => Lamp::Sphere { centre, radius: 0.02 + 0.01 * f64::from(i % 4) },
                1 => Lamp::Disk { centre, normal: DVec3::NEG_Z, radius: 0.1 },
                _ => Lamp::Quad(centre, [DVec3::Y * 0.2, DVec3::X * 0.3]),
            }
        })
        .collect();
    let truth = lamps.iter().map(|lamp| lamp.irradiance(&receiver)).sum();
    let (first, others) = (&lamps[0], lamps[1..].iter().map(|lamp| lamp.node("lamp")).collect::<Vec<_>>().join(", "));
    let mut tally = Tally::default();
    for sampling in LightSampling::ALL {
        let mut picture = first.scene(&receiver, 1e-9, &others)?;
        picture.scene.settings.light_sampling = sampling;
        let effort = [conditions.count(64, 256), conditions.count(256, 1024)];
        hold_picture(&mut tally, &format!("chosen by {}", sampling.name()), truth, &picture, effort)?;
    }
    Ok(tally)
}

const STRONG: f64 = 1e30;
const WEAK: f64 = 1e-30;

/// Two squares that shine down, or the strong one up.
fn two(strong_is_seen: bool) -> Fallible<(Picture, f64)> {
    let receiver = Receiver::ground(0.5);
    let weak = Lamp::square(1.0, -0.6);
    let corner = DVec3::new(0.1, 0.1, 1.0);
    let strong = Lamp::Quad(corner, if strong_is_seen { [DVec3::Y, DVec3::X] } else { [DVec3::X, DVec3::Y] });
    let mut picture = weak.scene(&receiver, 1e-9, &strong.node("black"))?;
    for material in &mut picture.scene.appearance.materials {
        let radiance = match material.name.as_str() {
            "lamp" => WEAK,
            "black" => STRONG,
            _ => continue,
        };
        material.phong.emission = ColorTexture::Constant(Rgb::gray(radiance));
        material.shines = Sides::Front;
    }
    let seen = if strong_is_seen { STRONG * strong.irradiance(&receiver) } else { 0.0 };
    Ok((picture, WEAK * weak.irradiance(&receiver) + seen))
}

fn extreme(conditions: &Conditions) -> Found {
    let effort = [conditions.count(64, 256), conditions.count(64, 256)];
    let mut tally = Tally::default();
    for (strong_is_seen, samplings) in [
        (true, &LightSampling::ALL[..]),
        // By power alone the weak one is chosen once in 10⁶⁰ times.
        (false, &[LightSampling::Uniform, LightSampling::Tree]),
    ] {
        let (mut picture, truth) = two(strong_is_seen)?;
        for sampling in samplings {
            picture.scene.settings.light_sampling = *sampling;
            let what = format!("{}, chosen by {}", if strong_is_seen { "both" } else { "weak" }, sampling.name());
            hold_picture(&mut tally, &what, truth, &picture, effort)?;
        }
        developed(&mut tally, &mut picture, if strong_is_seen { 255 } else { 0 })?;
    }
    Ok(tally)
}

/// The film holds numbers, and the picture is all bright or all dark.
fn developed(tally: &mut Tally, picture: &mut Picture, expected: u8) -> Fallible<()> {
    picture.scene.settings.integrator = Integrator::Path;
    (picture.scene.film.width, picture.scene.film.height) = (4, 4);
    let plan = RenderPlan::compile(&picture.scene, &PlanOptions::default())?;
    let rendering = plan.render(&RunOptions::default(), |_| {})?;
    tally.same(rendering.statistics.bad_samples, 0, "bad samples");
    let values = rendering.film.pixels().as_flattened();
    tally.check(values.iter().all(|value| value.is_finite() && *value > 0.0), || format!("{values:?}"));
    for tone in [ToneCurve::Clamp, ToneCurve::Reinhard, ToneCurve::Aces] {
        let bytes = Development { tone, ..Development::default() }.develop(&rendering.film).bytes;
        tally.check(bytes.iter().all(|byte| *byte == expected), || format!("{tone:?}: {bytes:?}"));
    }
    Ok(())
}
