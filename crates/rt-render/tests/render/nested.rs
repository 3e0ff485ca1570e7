//! Nested dielectrics, from scene to image.

use rt_camera::{CameraSettings, Projection};
use rt_image::Image;
use rt_math::{DVec3, Rgb, Transform, transcendental::exp};
use rt_render::{PlanOptions, RenderError, RenderPlan, RunOptions};
use rt_scene_io::{MaterialId, Scene};
use rt_shading::{ColorTexture, InteriorMedium, Material, Phong, Transmission};

use crate::support::{compile, cuboid, everything, film, film_with, node, render, sphere, spheres};

/// Asserts that images are bit-identical; reports the first difference only.
fn assert_same(a: &Image, b: &Image, what: &str) {
    let differing = a.pixels().iter().zip(b.pixels()).filter(|(a, b)| a != b).count();
    assert!(a == b, "{what}: {differing} pixels differ");
}

fn dielectric(ior: f64, absorption: f64, priority: i32) -> Material {
    let white = ColorTexture::Constant(Rgb::WHITE);
    let absorption = Rgb::new(absorption, 0.5 * absorption, 0.0);
    let transmission = Some(Transmission { coefficient: white, fresnel: true });
    let (ambient, diffuse) = (ColorTexture::ZERO, ColorTexture::ZERO);
    let phong = Phong { ambient, diffuse, mirror: white, transmission, ..Phong::default() };
    let interior = Some(InteriorMedium { ior, absorption, priority });
    Material { interior, ..Material::new("dielectric".into(), phong) }
}

/// A glass with water, ice and a bubble, all overlapping, among spheres.
pub(crate) fn drink() -> Scene {
    let mut scene = spheres();
    scene.name = "drink".into();
    scene.settings.depth = 12;
    let first = scene.appearance.materials.len() as u32;
    let dielectrics = [(1.5, 0.2, 0), (1.33, 0.4, 1), (1.31, 0.0, 2), (1.0, 0.0, 3)];
    scene
        .appearance
        .materials
        .extend(dielectrics.map(|(ior, absorption, priority)| dielectric(ior, absorption, priority)));
    scene.nodes.extend([
        node(cuboid([-1.5, -1.5, 1.8], [1.5, 1.5, 4.0]), first),
        node(cuboid([-1.2, -1.2, 2.0], [1.2, 0.8, 3.8]), first + 1),
        node(sphere(0.2, 0.7, 3.0, 0.5), first + 2),
        node(sphere(-0.5, -0.4, 3.0, 0.3), first + 3),
    ]);
    scene
}

#[test]
fn dielectrics_of_ior_one_do_not_change_the_image() {
    for (mut scene, transparent) in [(spheres(), false), (everything(), false), (spheres(), true)] {
        let options = PlanOptions { transparent, ..PlanOptions::default() };
        let without = film_with(&scene, options, 0);
        let air = scene.appearance.materials.len() as u32;
        // Glass has priority where both overlap.
        scene.appearance.materials.push(dielectric(1.0, 0.0, -1));
        // In front of, between and above the objects, between light and objects, and around the camera.
        scene.nodes.insert(0, node(sphere(0.3, 0.6, 2.5, 1.2), air));
        scene.nodes.push(node(sphere(3.0, 5.0, 4.0, 2.0), air));
        scene.nodes.push(node(sphere(1.0, 3.0, 9.0, 0.5), air));
        assert_same(&without, &film_with(&scene, options, 0), &scene.name);
    }
}

#[test]
fn nested_dielectrics_of_equal_ior_and_absorption_act_as_one() {
    let mut scene = spheres();
    let glass = scene.appearance.materials.len() as u32;
    let same = glass + 1;
    scene.appearance.materials.extend([dielectric(1.5, 0.3, 0), dielectric(1.5, 0.3, 0)]);
    scene.nodes.push(node(cuboid([-2.0, -1.0, 2.0], [2.0, 1.0, 4.0]), glass));
    let one = film(&scene);
    scene.nodes.extend([
        node(sphere(-0.4, 0.1, 3.0, 0.8), same),
        node(sphere(0.3, -0.2, 2.8, 0.7), glass),
        node(cuboid([-1.0, -0.5, 2.4], [1.5, 0.9, 3.1]), same),
    ]);
    let several = render(&scene, PlanOptions::default(), RunOptions::default());
    assert!(several.statistics.shading.null_interfaces > 1000);
    assert_same(&one, &several.film, &scene.name);
}

/// A smoke sphere of radius 2 that contains all origins of camera rays.
fn in_smoke(projection: Projection) -> Scene {
    let mut scene = spheres();
    scene.appearance.materials = vec![dielectric(1.0, 0.5, 0)];
    scene.cameras[0].settings = CameraSettings::new(Transform::translate(DVec3::new(0.0, 0.0, 0.5)), projection);
    scene.nodes = vec![node(sphere(0.0, 0.0, 0.5, 2.0), 0)];
    scene
}

#[test]
fn a_camera_in_smoke_sees_all_of_it_in_all_directions() {
    let scene = in_smoke(spheres().cameras[0].settings.projection);
    let expected = [0.1 * exp(-1.0), 0.2 * exp(-0.5), 0.3].map(|c| c as f32);
    let mut named = scene.clone();
    named.cameras[0].medium = Some(MaterialId(0));
    for scene in [&scene, &named] {
        for pixel in film(scene).pixels() {
            assert!(pixel.iter().zip(expected).all(|(seen, expected)| (seen - expected).abs() < 1e-7), "{pixel:?}");
        }
    }
}

/// Glass around the camera with a bubble in front of it: the medium of the camera affects both.
#[test]
fn camera_rays_start_in_the_surrounding_medium() {
    for projection in [spheres().cameras[0].settings.projection, Projection::Orthographic { height: 1.0 }] {
        let mut scene = in_smoke(projection);
        scene.appearance.materials = vec![dielectric(1.5, 0.2, 0), dielectric(1.0, 0.0, 1)];
        scene.nodes.push(node(sphere(0.1, 0.0, -0.5, 0.3), 1));
        let found = film(&scene);
        scene.cameras[0].medium = Some(MaterialId(0));
        assert_same(&found, &film(&scene), "found and named");
        scene.nodes.swap(0, 1);
        assert_same(&found, &film(&scene), "named, in another order");
        // Without the glass, the bubble is air in air.
        scene.cameras[0].medium = None;
        scene.nodes.truncate(1);
        assert!(film(&scene).pixels().iter().all(|pixel| (pixel[2] - 0.3).abs() < 1e-7));
        assert!(found.pixels().iter().any(|pixel| (pixel[0] - found.pixels()[0][0]).abs() > 1e-3));
    }
}

#[test]
fn each_orthographic_ray_starts_in_its_own_medium() {
    // The camera plane cuts a slab of smoke: rays of the left half start in it.
    let mut scene = in_smoke(Projection::Orthographic { height: 1.0 });
    scene.settings.pattern = rt_camera::SamplerKind::Centre;
    scene.settings.spp = 1;
    scene.nodes = vec![
        node(cuboid([-9.0, -9.0, -0.5], [0.0, 9.0, 1.0]), 0),
        node(cuboid([-9.0, -9.0, -2.5], [9.0, 9.0, -1.5]), 0),
    ];
    let film = film(&scene);
    for (i, pixel) in film.pixels().iter().enumerate() {
        let x = (i % 61) as i32 - 30;
        let way = if x < 0 { 2.0 } else { 1.0 };
        assert!(x == 0 || (f64::from(pixel[0]) - 0.1 * exp(-0.5 * way)).abs() < 1e-7, "pixel {i}: {pixel:?}");
    }
}

#[test]
fn a_medium_that_is_not_there_is_refused() {
    let mut scene = spheres();
    scene.cameras[0].medium = Some(MaterialId(9));
    let refusal = RenderPlan::compile(&scene, &PlanOptions::default()).expect_err("there is no such material");
    assert!(matches!(refusal, RenderError::Dangling { what: "material", index: 9, .. }), "{refusal}");
}

#[test]
fn explanations_say_what_nests() {
    let used = |scene: &Scene| {
        let plan = compile(scene);
        plan.explain().used.join("\n")
    };
    let mut scene = drink();
    let explained = used(&scene);
    assert!(render(&scene, PlanOptions::default(), RunOptions::default()).statistics.shading.null_interfaces > 0);
    assert!(explained.contains("priorities 0 to 3; the camera is outside of all"), "{explained}");
    scene.cameras[0].medium = Some(MaterialId(1));
    assert!(used(&scene).contains("the camera is inside of a dielectric"));
    assert!(!used(&spheres()).contains("nested dielectrics"));
}
