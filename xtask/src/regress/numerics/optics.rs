//! Reflection and refraction.

use rt_geometry::{Cuboid, Plane, Shape, Sphere};
use rt_math::{
    DVec3, Ray, Rgb,
    transcendental::{asin, atan, cos, sin, sincos, tan},
};
use rt_shading::{
    Appearance, Background, ColorTexture, Highlight, InteriorMedium, Material, Phong, ShadingCounts, ShadingFeatures,
    Transmission, Whitted, optics,
};
use rt_tests::{Draw, ShapeSet};

use super::{super::shape_tracer::ShapeTracer, Case, Checks, Conditions, Fallible, Tolerance, cases};

cases! {
    "S49", "a sphere of glass as dense as air", "the image without it", "bits", null_glass;
    "S50", "overlapping dielectrics of equal density", "seen as one dielectric", "bits", one_dielectric;
    "S51", "the critical angle of glass ± 1e-12", "1 − R in [0, 2e-5), no NaN", "2e-5 abs", critical_angle;
    "S52", "Brewster's angle of glass", "nothing of parallel light is reflected", "1e-30 abs", brewster;
    "S53", "η = 1e3 and 1e-3, straight on", "F = 0.9960079880", "1e-10 abs", extreme_density;
    "S54", "through a plate at 45° and a ball at 30°",
        "shift 0.3291423082, deviation 21.0575587310°", "1e-10 abs", paths;
    "S55", "a plate with all its inner reflections", "R = 0.0769230769, T = 0.9230769231", "1e-10 abs", plate;
    "S56", "1000 bounces in a box of mirrors of 0.999", "0.3676954248", "1e-12 abs", mirror_box;
    "S57", "facing mirrors at 89.9999°, 1e4 deep", "the depth is reached, reported, and no more", "–", facing_mirrors;
}

const GLASS: f64 = 1.5;
const WHITE: ColorTexture = ColorTexture::Constant(Rgb::WHITE);
const BARE: Phong = Phong {
    ambient: ColorTexture::ZERO,
    diffuse: ColorTexture::ZERO,
    specular: ColorTexture::ZERO,
    exponent: 1.0,
    highlight: Highlight::Phong,
    mirror: ColorTexture::ZERO,
    transmission: None,
};

/// A clear dielectric that transmits all light, or Fresnel's part of it.
fn dielectric(ior: f64, fresnel: bool) -> Material {
    let transmission = Some(Transmission { coefficient: WHITE, fresnel });
    let phong = Phong { mirror: if fresnel { WHITE } else { ColorTexture::ZERO }, transmission, ..BARE };
    Material { interior: Some(InteriorMedium::clear(ior)), ..Material::new(String::new(), phong) }
}

fn emissive(radiance: f64, phong: Phong) -> Material {
    Material { emission: ColorTexture::Constant(Rgb::gray(radiance)), ..Material::new(String::new(), phong) }
}

fn mirror() -> Material {
    Material::new(String::new(), Phong { mirror: WHITE, ..BARE })
}

/// Radiance along a ray, and the rays that were traced for it.
struct Look {
    radiance: Rgb,
    rays: Vec<Ray>,
    counts: ShadingCounts,
}

fn look(shapes: &[(Shape, Material)], background: Background, depth: u32, ray: &Ray) -> Look {
    let materials = shapes.iter().map(|(_, material)| material.clone()).collect();
    let appearance = Appearance { materials, background, ..Appearance::default() };
    let set = ShapeSet::of_shapes(shapes.iter().map(|(shape, _)| shape.clone()));
    let mut world = ShapeTracer { set, ..ShapeTracer::default() };
    let mut whitted = Whitted::new(depth, 0.0, ShadingFeatures::of(&appearance, |_| true));
    let radiance = whitted.radiance(&mut world, &appearance, ray).radiance;
    Look { radiance, rays: world.rays, counts: whitted.counts() }
}

/// Unit vector downwards, at this angle from the vertical towards +x.
fn down(degrees: f64) -> DVec3 {
    let (sin, cos) = sincos(degrees.to_radians());
    DVec3::new(sin, -cos, 0.0)
}

/// A box 20 units wide between two heights.
fn slab(bottom: f64, top: f64) -> Result<Shape, rt_geometry::ShapeError> {
    Cuboid::new(DVec3::new(-10.0, bottom, -10.0), DVec3::new(10.0, top, 10.0)).map(Shape::Cuboid)
}

fn unit_sphere() -> Result<Shape, rt_geometry::ShapeError> {
    Sphere::new(DVec3::ZERO, 1.0).map(Shape::Sphere)
}

const SKY: Background = Background::Gradient { bottom: Rgb::gray(0.25), top: Rgb::gray(0.75) };

fn null_glass(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let (null, floor) = ((unit_sphere()?, dielectric(1.0, true)), (slab(-3.0, -1.2)?, emissive(0.625, BARE)));
    let mirror = (slab(3.0, 4.0)?, mirror());
    let with = [floor.clone(), mirror.clone(), null];
    let without = [floor, mirror];
    checks.draw_all(conditions.count(5_000, 200_000), 49, |draw, checks| {
        let origin = draw.direction() * 2.0;
        let ray = Ray::new(origin, draw.point() - origin);
        let [with, without] = [&with[..], &without].map(|shapes| look(shapes, SKY, 3, &ray).radiance.to_array());
        checks.same(with.map(f64::to_bits), without.map(f64::to_bits), format_args!("{ray:?}"));
    });
    Ok(())
}

fn one_dielectric(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let glass = || dielectric(GLASS, true);
    let (one, two) = ([(slab(-1.0, 1.0)?, glass())], [(slab(-1.0, 0.3)?, glass()), (slab(-0.2, 1.0)?, glass())]);
    checks.draw_all(conditions.count(2_000, 100_000), 50, |draw, checks| {
        let origin = DVec3::new(draw.between(-2.0, 2.0), 4.0, draw.between(-2.0, 2.0));
        let ray = Ray::new(origin, draw.point() * DVec3::new(1.0, 0.0, 1.0) - origin);
        let [one, two] = [&one[..], &two].map(|shapes| look(shapes, SKY, 6, &ray));
        checks.same(two.radiance, one.radiance, format_args!("{ray:?}"));
        checks.check(two.counts.null_interfaces > 0, || "no surface was passed".to_owned());
    });
    Ok(())
}

fn critical_angle(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let critical = asin(1.0 / GLASS);
    for step in -100..=100 {
        let angle = critical + f64::from(step) * 1e-14;
        let passes = 1.0 - optics::fresnel(cos(angle), GLASS);
        checks.limit(passes, 2e-5, "1 − R");
        checks.check(passes >= 0.0, || format!("1 − R = {passes}"));
        let direction = DVec3::new(sin(angle), -cos(angle), 0.0);
        let refracted = optics::refract(direction, DVec3::Y, GLASS);
        let sound = refracted.is_none_or(|d| (d.length() - 1.0).abs() < 1e-14 && d.y <= 0.0);
        checks.check(sound, || format!("{refracted:?}"));
    }
    Ok(())
}

fn brewster(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for ior in [GLASS, 1.333, 2.4, 1.0 / GLASS] {
        let [perpendicular, parallel] = optics::polarised_fresnel(cos(atan(ior)), 1.0 / ior);
        checks.limit(parallel, 1e-30, format_args!("parallel, n = {ior}"));
        let amplitude = (ior * ior - 1.0) / (ior * ior + 1.0);
        let off = perpendicular - amplitude * amplitude;
        checks.check(off.abs() < 1e-15, || format!("perpendicular, n = {ior}: off by {off:e}"));
    }
    Ok(())
}

fn extreme_density(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for eta in [1e3, 1e-3] {
        let expected = (999.0 / 1001.0) * (999.0 / 1001.0);
        checks.near(expected, 0.996_007_988_0, Tolerance::Absolute(1e-10), "the formula");
        checks.near(optics::fresnel(1.0, eta), expected, Tolerance::Absolute(1e-10), "F");
        let ray = Ray::new(DVec3::Y * 3.0, DVec3::NEG_Y);
        let above = Background::Gradient { bottom: Rgb::BLACK, top: Rgb::WHITE };
        let seen = look(&[(slab(-1e-9, 0.0)?, dielectric(eta, true))], above, 0, &ray);
        checks.check(seen.radiance.is_finite(), || format!("radiance {:?}", seen.radiance));
    }
    Ok(())
}

fn paths(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let tolerance = Tolerance::Absolute(1e-10);
    let ray = Ray::new(DVec3::new(-2.0, 3.0, 0.5), down(45.0));
    let Look { rays, .. } = look(&[(slab(0.0, 1.0)?, dielectric(GLASS, false))], SKY, 9, &ray);
    checks.same(rays.len(), 3, "rays through a plate");
    if let Some(last) = rays.last() {
        let shift = (last.origin - ray.origin).cross(ray.direction).length();
        checks.near(shift, 0.329_142_308_2, tolerance, "shift");
        checks.near((last.direction - ray.direction).length(), 0.0, tolerance, "direction");
    }
    // Half a radius from the centre: 30° of incidence.
    let ray = Ray::new(DVec3::new(0.5, 5.0, 0.0), DVec3::NEG_Y);
    let Look { rays, .. } = look(&[(unit_sphere()?, dielectric(GLASS, false))], SKY, 9, &ray);
    checks.same(rays.len(), 3, "rays through a ball");
    if let Some(last) = rays.last() {
        let deviation = asin(last.direction.cross(ray.direction).length()).to_degrees();
        checks.near(deviation, 21.057_558_731_0, tolerance, "deviation");
    }
    Ok(())
}

fn plate(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for (top, expected) in [(1.0, 0.076_923_076_9), (0.0, 0.923_076_923_1)] {
        let background = Background::Gradient { bottom: Rgb::gray(1.0 - top), top: Rgb::gray(top) };
        let ray = Ray::new(DVec3::Y * 3.0, DVec3::NEG_Y);
        let Look { radiance, .. } = look(&[(slab(0.0, 1.0)?, dielectric(GLASS, true))], background, 60, &ray);
        checks.near(radiance.r, expected, Tolerance::Absolute(1e-10), "part of the light");
    }
    Ok(())
}

/// Walls that glow with 0.001 and mirror 0.999: after n bounces 1 − 0.999ⁿ⁺¹ is seen.
fn mirror_box(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let walls = emissive(0.001, Phong { mirror: ColorTexture::Constant(Rgb::gray(0.999)), ..BARE });
    let mirrors = Cuboid::new(DVec3::new(-1.0, -2.0, -3.0), DVec3::new(1.5, 2.0, 2.5))?;
    for turn in 0..20 {
        let direction = Draw::new(turn).direction();
        let ray = Ray::new(DVec3::new(0.1, 0.2, 0.3), direction);
        let Look { radiance, counts, .. } = look(&[(Shape::Cuboid(mirrors), walls.clone())], SKY, 999, &ray);
        let left = 1.0 - radiance.r;
        checks.near(left, 0.367_695_424_770_964_06, Tolerance::Absolute(1e-12), direction);
        checks.same(counts.depth_limited, 1, "reports of the depth");
    }
    Ok(())
}

fn facing_mirrors(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const DEPTH: u32 = 10_000;
    let plane = |height: f64| Plane::new(DVec3::Y * height, DVec3::Y).map(|plane| (Shape::Plane(plane), mirror()));
    let ray = Ray::new(DVec3::Y * 0.5, down(1e-4));
    let Look { radiance, rays, counts } = look(&[plane(0.0)?, plane(1.0)?], SKY, DEPTH, &ray);
    checks.same((radiance, counts.depth_limited), (Rgb::BLACK, 1), "what is seen, and reports of the depth");
    checks.same(rays.len(), DEPTH as usize + 1, "rays");
    let travelled = rays.last().map_or(f64::NAN, |last| last.origin.x);
    let expected = (f64::from(DEPTH) - 0.5) * tan(1e-4f64.to_radians());
    checks.near(travelled, expected, Tolerance::Absolute(1e-9), "way along the mirrors");
    Ok(())
}
