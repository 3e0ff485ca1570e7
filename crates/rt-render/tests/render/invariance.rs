//! Translation and scaling of a scene do not change its image. Where it is shaded in `f32`, unrounded radiance agrees to 10⁻⁶; the
//! numerics case S80 compares that in `f64`.
//!
//! The translated numbers must be exact, or the scene itself changes. Near 10⁶, numbers are 10⁻¹⁰ apart, which is 10⁻⁷ of a
//! scene of size 10⁻³. Scales are therefore powers of two near 10⁻³ and 10³, and positions of cameras and lights have few
//! digits. No sample crosses a silhouette.

use rt_camera::Projection;
use rt_geometry::{Shape, Sphere};
use rt_image::Image;
use rt_math::{DVec3, Rgb};
use rt_render::{PlanOptions, Precision};
use rt_scene_io::{Content, Scene};
use rt_shading::{DeltaLightKind, Falloff};

use crate::support::{compile_with, everything, film, spheres};

/// Largest difference of images.
const TOLERANCE: f32 = 1e-6;

const MILLION: DVec3 = DVec3::new(1e6, -1e6, 1e6);

/// The whole scene, scaled and then translated.
fn moved(scene: &Scene, scale: f64, offset: DVec3) -> Scene {
    rt_tests::moved(scene, scale, offset).expect("regular")
}

fn assert_same(expected: &Image, scene: &Scene, what: &str) {
    let film = film(scene);
    let pairs = expected.pixels().iter().flatten().zip(film.pixels().iter().flatten());
    let worst = pairs.fold(0.0, |worst: f32, (a, b)| worst.max((a - b).abs()));
    assert!(worst <= TOLERANCE, "{} {what}: {worst:e}", scene.name);
}

/// Scene with all features except lights with falloff.
fn base_scene() -> Scene {
    let mut scene = everything();
    for light in &mut scene.appearance.lights {
        if let DeltaLightKind::Spot { falloff, .. } = &mut light.kind {
            *falloff = Falloff::None;
        }
        light.intensity = Rgb::gray(0.4);
    }
    scene
}

fn base_scenes() -> [Scene; 3] {
    let mut parallel = base_scene();
    parallel.name = "parallel".into();
    parallel.cameras[0].settings.projection = Projection::Orthographic { height: 6.0 };
    [spheres(), base_scene(), parallel]
}

#[test]
fn scaling_and_translation_do_not_change_the_image() {
    const SCALES: [(f64, f64); 9] = [
        (1e-3, 0.0),
        (0.01, 0.0),
        (7.0, 0.0),
        (1e3, 0.0),
        (1.0, 1.0),
        (1024.0, 1.0),
        (1024.0, 1024.0),
        (1.0 / 1024.0, 1.0),
        (1.0 / 1024.0, 1.0 / 1024.0),
    ];
    for scene in base_scenes() {
        let expected = film(&scene);
        for (scale, unit) in SCALES {
            let offset = MILLION * unit;
            assert_same(&expected, &moved(&scene, scale, offset), &format!("at scale {scale}, moved by {offset}"));
        }
    }
}

#[test]
fn shapes_with_large_coordinates_of_their_own_look_the_same() {
    let scene = spheres();
    let mut far = moved(&scene, 1.0, MILLION);
    far.nodes = scene.nodes.clone();
    for node in &mut far.nodes {
        if let Some(Content::Shape(Shape::Sphere(sphere))) = &mut node.content {
            *sphere = Sphere::new(sphere.centre() + MILLION, sphere.radius()).expect("a sphere");
        }
    }
    assert_same(&film(&scene), &far, "far away");
    // Every other pixel in `f64`, not rounded.
    let options = PlanOptions { precision: Precision::F64, ..PlanOptions::default() };
    let (plan, plan_of_far) = (compile_with(&scene, options), compile_with(&far, options));
    for (x, y) in (0..43).flat_map(|y| (y % 2..61).step_by(2).map(move |x| (x, y))) {
        let [a, b] = [&plan, &plan_of_far].map(|plan| plan.pixel(x, y).expect("a pixel of the image"));
        assert!((a - b).map(f64::abs).max_component() <= 1e-9, "{x}, {y}: {a:?}, {b:?}");
    }
}
