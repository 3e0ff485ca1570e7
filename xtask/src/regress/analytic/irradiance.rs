//! Irradiance at a point, from lights of each kind.

use std::f64::consts::PI;

use rt_math::{
    DVec3, Sampler,
    transcendental::{asin, atan, sincos},
};
use rt_scene_io::Integrator;
use rt_shading::light::Light;

use super::{
    Case, Checks, Conditions, Fallible, Tolerance,
    area_light::{ALBEDO, AreaLight, Receiver, hold_irradiance},
    cases, closed_form,
    estimate::{hold, mean_of},
    test_image::TestImage,
};

cases! {
    "point-light", "a point light of intensity 1 at a height of 1",
        "0.3535533906 at 45°; mean over a square π/6", "5 σ", point_light;
    "disk-light", "disks above, and aside", "(π/2)(1 − (h² + d² − R²) / √((h² + d² + R²)² − 4R²d²))", "5 σ", disks;
    "sphere-light", "spheres above, aside, and partly below the horizon",
        "π s² cos θ; Snyder 1996 at the horizon", "5 σ", spheres;
    "polygon-light", "squares and triangles", "½ Σ Γᵢ · n (Lambert 1760)", "5 σ", polygons;
    "solid-angle", "the mean of 1 / pdf of light samples",
        "a cone's 0.8417872145, a unit square's 0.8054316832", "5 σ", solid_angles;
    "S61", "a unit square 1e-3 to 1e6 away",
        "½ Σ Γᵢ · n; its solid angle 4 atan(a² / (h √(h² + 2a²)))", "5 σ; 1e-10 rel", near_and_far;
    "S62", "a sphere of light that almost touches the ground", "π s² cos θ", "5 σ", touching;
}

/// A square of the ground around this point, of this side, 1 below a point light over the origin.
pub(super) fn under_point_light(x: f64, y: f64, side: f64) -> Fallible<TestImage> {
    TestImage::of(&format!(
        "camera: (look_from: ({x:?}, {y:?}, 0.5), look_at: ({x:?}, {y:?}, 0), orthographic: {side:?}),
            lights: [point(position: (0, 0, 1), falloff: inverse_square)],
            materials: {{\"ground\": phong(diffuse: gray({ALBEDO}), ambient: gray(0))}},
            nodes: [(shape: plane(normal: (0, 0, 1)), material: \"ground\")],"
    ))
}

/// A diffuse surface of the classical kind is as bright as its coefficient says, by any integrator.
fn point_light(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for (what, image, truth) in [
        ("45° aside", under_point_light(1.0, 0.0, 1e-7)?, 0.125f64.sqrt()),
        ("over a square", under_point_light(0.5, 0.5, 1.0)?, closed_form::point_light_over_rectangle(1.0, 1.0, 1.0)),
    ] {
        let all = [Integrator::Whitted, Integrator::Direct, Integrator::Path, Integrator::Distributed];
        image.hold_by(&all, checks, what, truth, 1.0 / ALBEDO, conditions.effort())?;
    }
    Ok(())
}

fn disks(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for (what, height, aside) in
        [("1 above", 1.0, 0.0), ("2 above", 2.0, 0.0), ("1 above, 1 aside", 1.0, 1.0), ("2 above, 3 aside", 2.0, 3.0)]
    {
        let area_light = AreaLight::disk(1.0, height, aside);
        hold_irradiance(checks, conditions, what, &area_light, &Receiver::ground(0.5 * height))?;
    }
    Ok(())
}

/// A sphere whose sine of half the angle is `s`, at a distance of 1, `degrees` from straight up.
fn sphere_at(s: f64, degrees: f64) -> AreaLight {
    let (sin, cos) = sincos(degrees.to_radians());
    AreaLight::Sphere { centre: DVec3::new(sin, 0.0, cos), radius: s }
}

fn spheres(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for (what, s, degrees) in [
        ("s = 1/3, above", 1.0 / 3.0, 0.0),
        ("s = 1/3 at 60°", 1.0 / 3.0, 60.0),
        ("s = 1/3 at 90°", 1.0 / 3.0, 90.0),
        ("s = 1/2 at 80°", 0.5, 80.0),
        ("s = 1/2 at 100°", 0.5, 100.0),
    ] {
        hold_irradiance(checks, conditions, what, &sphere_at(s, degrees), &Receiver::ground(0.25))?;
    }
    Ok(())
}

fn polygons(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let triangle = AreaLight::Triangle([DVec3::Z, DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 0.0, 1.0)]);
    let tilted = Receiver { normal: DVec3::ONE.normalize(), ..Receiver::ground(0.25) };
    let ground = Receiver::ground(0.5);
    for (what, area_light, receiver) in [
        ("square above", AreaLight::square(1.0, 0.0), ground),
        ("square above a corner", AreaLight::square(1.0, 0.5), ground),
        ("triangle", triangle, ground),
        ("triangle, tilted", triangle, tilted),
    ] {
        hold_irradiance(checks, conditions, what, &area_light, &receiver)?;
    }
    Ok(())
}

fn solid_angles(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let seeds = conditions.count(64, 256);
    let cone = 2.0 * PI * (1.0 - 0.75f64.sqrt());
    for (what, area_light, truth) in
        [("cone of 30°", sphere_at(0.5, 0.0), cone), ("unit square", AreaLight::square(1.0, 0.0), 4.0 * asin(0.2))]
    {
        let light = area_light.light()?;
        hold(checks, what, truth, seeds, |pattern, seed| {
            let inverse = |u| light.sample_li(DVec3::ZERO, u).map_or(0.0, |sample| 1.0 / sample.pdf);
            Ok(mean_of(pattern, 64, seed, |sample| inverse(sample.next_2d())))
        })?;
    }
    Ok(())
}

fn near_and_far(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for height in [1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6] {
        let area_light = AreaLight::square(height, 0.0);
        let receiver = Receiver::ground(0.5 * height);
        hold_exact(checks, height, &area_light)?;
        hold_irradiance(checks, conditions, &format!("{height:e} away"), &area_light, &receiver)?;
    }
    Ok(())
}

/// Checks without samples: the closed form against that of rectangles above their corner (Howell C-4), and the solid
/// angle that the light is sampled by.
fn hold_exact(checks: &mut Checks, height: f64, area_light: &AreaLight) -> Fallible<()> {
    let a = 0.5 / height;
    let root = (1.0 + a * a).sqrt();
    let howell = 4.0 * a / root * atan(a / root);
    checks.near(
        area_light.irradiance(&Receiver::ground(0.0)),
        howell,
        Tolerance::Relative(1e-10),
        format_args!("irradiance, {height:e} away"),
    );
    if let Light::Quad(light) = area_light.light()? {
        let solid_angle = 4.0 * atan(a * a / (1.0 + 2.0 * a * a).sqrt());
        let what = format_args!("solid angle, {height:e} away");
        checks.near(light.solid_angle(DVec3::ZERO), solid_angle, Tolerance::Relative(1e-10), what);
    }
    Ok(())
}

fn touching(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for (what, radius, aside) in
        [("under it", 1.0, 0.0), ("1e-3 aside", 1.0, 1e-3), ("1 aside", 1.0, 1.0), ("under a small one", 1e-3, 0.0)]
    {
        const GAP: f64 = 1e-6;
        let area_light = AreaLight::Sphere { centre: DVec3::new(aside, 0.0, radius + GAP), radius };
        hold_irradiance(checks, conditions, what, &area_light, &Receiver::ground(0.5 * GAP))?;
    }
    Ok(())
}
