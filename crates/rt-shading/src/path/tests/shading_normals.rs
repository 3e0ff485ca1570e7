//! Shading normals that face away from the viewer: the geometric normal determines sides under every integrator.

use super::*;
use crate::{Highlight, SurfaceHit};
use core::f64::consts::TAU;

const ALL_SETTINGS: [PathSettings; 4] = [
    paths(0),
    paths(3),
    DISTRIBUTED,
    PathSettings { max_depth: 3, rr_start_depth: 2, transport: Transport::NonCaustic, clamp: Clamp::NONE },
];

/// A plane whose front is above. It is not at height 0, where numbers are so dense that shadow rays start on the plane itself.
fn wall() -> Shape {
    Shape::Plane(Plane::new(DVec3::Y * 0.3, DVec3::Y).expect("a plane"))
}

/// A ray to one point of the wall, against the unit direction `wo`.
fn towards_wall(wo: DVec3) -> Ray {
    Ray::new(DVec3::Y * 0.3 + wo * 2.0, -wo)
}

/// The shapes of a scene, of which the first has a shading normal that is not its own.
fn tilted(scene: &Scene, normal: DVec3) -> ShapeList {
    let normal_of = move |hit: &SurfaceHit| if hit.object == 0 { normal } else { hit.interaction.shading_normal };
    ShapeList { shapes: scene.world.shapes.clone(), shading_normal: Some(Box::new(normal_of)), ..ShapeList::default() }
}

/// Mean and standard error of the green channel at a point of a wall, seen from the unit direction `wo`.
fn estimate(scene: &Scene, normal: DVec3, wo: DVec3, settings: PathSettings, count: u32) -> (f64, f64) {
    let lights = scene.light_set();
    let lighting = Lighting { appearance: &scene.appearance, lights: &lights, bsdfs: &BsdfCache::default() };
    let rays = vec![towards_wall(wo); count as usize];
    let (seen, _) = trace(&mut tilted(scene, normal), lighting, settings, &[InteriorList::default()], &rays);
    mean_and_error(&seen)
}

fn whitted(scene: &Scene, normal: DVec3, wo: DVec3) -> f64 {
    let mut world = tilted(scene, normal);
    whitted_of(&scene.appearance, 3).radiance(&mut world, &scene.appearance, &towards_wall(wo)).radiance.g
}

/// A unit vector above the wall at the cosine `y`.
fn above(y: f64, azimuth: f64) -> DVec3 {
    let (sin, cos) = rt_math::transcendental::sincos(azimuth);
    let across = (1.0 - y * y).sqrt();
    DVec3::new(across * cos, y, across * sin)
}

/// Unit directions to the viewer, and shading normals that face away from each; both are above the wall.
fn away_facing_views(count: usize) -> impl Iterator<Item = (DVec3, DVec3)> {
    (0..).filter_map(pair_facing_away).take(count)
}

fn pair_facing_away(index: u64) -> Option<(DVec3, DVec3)> {
    let number = |dimension| random::unit(random::hash(&[31, index, dimension]));
    let wo = above(0.02 + 0.6 * number(0), TAU * number(1));
    let normal = above(0.02 + 0.6 * number(2), TAU * number(3));
    (normal.dot(wo) < -0.01).then_some((wo, normal))
}

fn sun(towards: DVec3, casts_shadows: bool) -> DeltaLight {
    let kind = DeltaLightKind::Directional { direction: -towards };
    DeltaLight { casts_shadows, ..DeltaLight::new(kind, Rgb::WHITE) }
}

fn opaque_materials() -> Vec<Material> {
    let white = gray(1.0);
    let classical = Phong {
        ambient: ColorTexture::ZERO,
        diffuse: gray(0.5),
        specular: gray(0.5),
        exponent: 3.0,
        highlight: Highlight::Phong,
        mirror: gray(0.2),
        ..Phong::default()
    };
    let metal = crate::bsdf::ComplexIor::GOLD;
    vec![
        emissive(diffuse(1.0), 0.0),
        emissive(MaterialModel::Diffuse { albedo: white, roughness: 0.5 }, 0.0),
        emissive(MaterialModel::Glossy { diffuse: gray(0.5), specular: gray(0.5), exponent: 2.0 }, 0.0),
        emissive(MaterialModel::Conductor { ior: metal, roughness: 0.7 }, 0.0),
        emissive(MaterialModel::MetallicRoughness { base_color: white, metallic: 0.0, roughness: 0.4 }, 0.0),
        Material::new(String::new(), classical),
    ]
}

/// The wall gave 0.202 where it was white and diffuse: rounding put the viewer on its back, where the light is.
#[test]
fn an_opaque_wall_with_shading_normals_that_is_lit_from_behind_is_black() {
    for material in opaque_materials() {
        let emission = Emission::new(Rgb::WHITE, EmissionSides::Both).expect("an emission");
        let disk = DiskLight::new(DVec3::Y * -2.0, DVec3::Y, 1.5, 0.0, emission).expect("a light");
        let glowing = Sphere::new(DVec3::Y * -5.0, 2.5).expect("a sphere");
        let mut scene = Scene::new(vec![material, emissive(diffuse(0.0), 1.0)], vec![Light::Disk(disk)])
            .with(wall(), 0, None)
            .with(Shape::Sphere(glowing), 1, None);
        scene.appearance.lights = vec![sun(DVec3::new(0.6, -0.8, 0.0), true), sun(DVec3::new(0.0, -0.6, 0.8), false)];
        for (wo, normal) in away_facing_views(50) {
            for settings in ALL_SETTINGS {
                let (mean, _) = estimate(&scene, normal, wo, settings, 32);
                assert_eq!(mean, 0.0, "{settings:?}, viewer {wo}, normal {normal}");
            }
        }
        scene.appearance.lights.truncate(1);
        for (wo, normal) in away_facing_views(50) {
            assert_eq!(whitted(&scene, normal, wo), 0.0, "viewer {wo}, normal {normal}");
        }
    }
}

/// The quad gave 0.201 under path tracing where Whitted's integrator gives 0.492.
#[test]
fn a_lit_quad_with_shading_normals_is_as_bright_under_every_integrator() {
    let classical = Phong { ambient: ColorTexture::ZERO, diffuse: gray(1.0), ..Phong::default() };
    let mut scene = Scene::new(vec![Material::new(String::new(), classical)], vec![]).with(wall(), 0, None);
    scene.appearance.lights = vec![sun(DVec3::new(0.48, 0.8, 0.36), true)];
    let mut lit = 0;
    for (wo, normal) in away_facing_views(200) {
        let expected = whitted(&scene, normal, wo);
        lit += usize::from(expected > 0.1);
        for settings in ALL_SETTINGS {
            let (mean, _) = estimate(&scene, normal, wo, settings, 2);
            assert!((mean - expected).abs() < 1e-12, "{settings:?}, viewer {wo}, normal {normal}: {mean} {expected}");
        }
    }
    assert!(lit > 50, "{lit}");
}

/// Mirrors and smooth glass were black there.
#[test]
fn mirrors_and_glass_with_shading_normals_send_light_on_as_whitteds_do() {
    let glass = Transmission { coefficient: gray(1.0), fresnel: true };
    let mirror =
        Phong { ambient: ColorTexture::ZERO, diffuse: ColorTexture::ZERO, mirror: gray(0.9), ..Phong::default() };
    for phong in [mirror, Phong { transmission: Some(glass), ..mirror }] {
        let interior = phong.transmission.map(|_| InteriorMedium::clear(1.5));
        let material = Material { interior, ..Material::new(String::new(), phong) };
        let mut scene = Scene::new(vec![material], vec![]).with(wall(), 0, None);
        scene.appearance.background = Background::Gradient { bottom: Rgb::gray(0.25), top: Rgb::WHITE };
        for (wo, normal) in away_facing_views(100) {
            for wo in [wo, -wo] {
                let expected = whitted(&scene, normal, wo);
                let (mean, error) = estimate(&scene, normal, wo, paths(3), 200);
                assert!(
                    expected > 0.2 && (mean - expected).abs() < 5.0 * error + 1e-6,
                    "{wo} {normal}: {mean} {expected}"
                );
            }
        }
    }
}

/// Under constant light, a white diffuse surface reflects the light above both the turned normal and its own. With the
/// angle β between them, that is (1 + cos β) / 2 of it.
#[test]
fn white_diffuse_surfaces_with_shading_normals_show_what_a_numeric_integral_says() {
    let mut scene = Scene::new(vec![emissive(diffuse(1.0), 0.0)], vec![]).with(wall(), 0, None);
    scene.appearance.background = Background::Constant(Rgb::WHITE);
    for (wo, normal) in away_facing_views(20) {
        let turned = (normal - wo * normal.dot(wo)).normalize();
        let (mut integral, side) = (0.0, 400);
        for index in 0..side * side {
            // Uniform over the upper hemisphere.
            let y = (f64::from(index % side) + 0.5) / f64::from(side);
            let wi = above(y, TAU * (f64::from(index / side) + 0.5) / f64::from(side));
            integral += turned.dot(wi).max(0.0) * 2.0 / f64::from(side * side);
        }
        assert!((integral - 0.5 * (1.0 + turned.y)).abs() < 1e-4, "{integral}");
        for settings in [paths(0), paths(4)] {
            let (mean, error) = estimate(&scene, normal, wo, settings, 4000);
            assert!((mean - integral).abs() < 5.0 * error + 1e-4, "viewer {wo}, normal {normal}: {mean} {integral}");
        }
    }
}
