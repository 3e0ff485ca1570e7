//! Light that surfaces exchange: form factors, as means over a receiver.

use std::f64::consts::{FRAC_PI_4, PI};

use rt_math::{DVec3, Sampler};

use super::{
    Case, Checks, Conditions, Fallible,
    area_light::{AreaLight, Receiver, check_image, irradiance_from},
    cases, closed_form,
    estimate::{hold, mean_of},
    test_image::{DARK, TestImage},
};

cases! {
    "parallel-squares", "a unit square lit by another, .1 to 10 away",
        "π F: F = 0.8269945224, 0.1998248957, 0.0685895888, 0.0031620568", "5 σ", parallel_squares;
    "perpendicular-squares", "a unit square lit by another along an edge",
        "π F: F = 0.2000437761", "5 σ", perpendicular_squares;
    "coaxial-disks", "a unit disk lit by another on its axis",
        "π F: F = 0.3819660113, 0.1715728753", "5 σ", coaxial_disks;
}

/// Unit square on the ground around the origin, and a light: samples of both, and images.
fn hold_square(
    checks: &mut Checks,
    conditions: &Conditions,
    what: &str,
    area_light: &AreaLight,
    factor: f64,
) -> Fallible<()> {
    let (seeds, spp) = (conditions.count(64, 256), conditions.count(256, 1024));
    let light = area_light.light()?;
    hold(checks, format_args!("{what}, samples of both"), PI * factor, seeds, |pattern, seed| {
        Ok(mean_of(pattern, spp as u32, seed, |sample| {
            let [x, y] = sample.next_2d();
            let receiver = Receiver { point: DVec3::new(x - 0.5, y - 0.5, 0.0), ..Receiver::ground(0.0) };
            irradiance_from(&light, &receiver, sample.next_2d())
        }))
    })?;
    let image = area_light.scene(&Receiver::ground(LIFT), 1.0, "")?;
    check_image(checks, what, PI * factor, &image, [seeds, spp])
}

/// The camera plane is below all lights, and above the ground where they touch it.
const LIFT: f64 = 0.05;

fn parallel_squares(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for distance in [0.1, 1.0, 2.0, 10.0] {
        let what = format!("{distance} apart");
        let area_light = AreaLight::square(distance, 0.0);
        hold_square(checks, conditions, &what, &area_light, closed_form::parallel_squares(distance))?;
    }
    Ok(())
}

fn perpendicular_squares(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    // It faces +x.
    let area_light = AreaLight::Quad(DVec3::new(-0.5, -0.5, 0.0), [DVec3::Y, DVec3::Z]);
    hold_square(checks, conditions, "along an edge", &area_light, closed_form::perpendicular_squares())?;
    Ok(())
}

/// The images show the square around the receiver, of which it fills π/4.
fn coaxial_disks(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let (seeds, spp) = (conditions.count(64, 256), conditions.count(256, 1024));
    for distance in [1.0, 2.0] {
        let area_light = AreaLight::disk(1.0, distance, 0.0);
        let image = TestImage::of(&format!(
            "camera: (look_from: (0, 0, {LIFT}), look_at: (0, 0, 0), orthographic: 2),
                settings: (max_depth: 3),
                {DARK},
                materials: {{\"ground\": diffuse(albedo: gray(0.5)), \"lamp\": light(radiance: gray(1))}},
                nodes: [
                    (shape: disk(radius: 1), transform: [rotate_x(90)], material: \"ground\"),
                    {},
                ],",
            area_light.node("lamp"),
        ))?;
        let truth = FRAC_PI_4 * PI * closed_form::coaxial_disks(distance);
        check_image(checks, &format!("{distance} apart, π/4"), truth, &image, [seeds, spp])?;
    }
    Ok(())
}
