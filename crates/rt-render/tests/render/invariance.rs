//! Translation and scaling of a scene do not change its image: unrounded radiance agrees to 10⁻⁹ (stiff case S80). Where it is shaded
//! in `f32`, it agrees to 10⁻⁶.
//!
//! The translated numbers must be exact, or the scene itself changes. Near 10⁶, numbers are 10⁻¹⁰ apart, which is 10⁻⁷ of a
//! scene of size 10⁻³. Scales are therefore powers of two near 10⁻³ and 10³, and positions of cameras and lights have few
//! digits. No sample crosses a silhouette.

use rt_camera::Projection;
use rt_geometry::{Shape, Sphere};
use rt_math::{DVec3, Rgb};
use rt_render::{PlanOptions, Precision};
use rt_scene_io::{Content, Scene};
use rt_shading::{DeltaLightKind, Falloff};

use crate::support::{compile_with, everything, film, spheres};

/// Precisions, with the largest difference of images.
const TOLERANCES: [(Precision, f64); 2] = [(Precision::F64, 1e-9), (Precision::F32, 1e-6)];

/// The whole scene, scaled and then translated.
fn moved(scene: &Scene, scale: f64, offset: DVec3) -> Scene {
    rt_tests::moved(scene, scale, offset).expect("regular")
}

/// Pixels of the image: all of them, or every other one where they must not be rounded.
fn pixels(scene: &Scene, precision: Precision) -> Vec<Rgb> {
    if precision == Precision::F32 {
        return film(scene).pixels().iter().map(|pixel| Rgb::from(pixel.map(f64::from))).collect();
    }
    let plan = compile_with(scene, PlanOptions { precision, ..PlanOptions::default() });
    let (width, height) = (scene.film.width, scene.film.height);
    let half = (0..height).flat_map(|y| (y % 2..width).step_by(2).map(move |x| (x, y)));
    half.map(|(x, y)| plan.pixel(x, y).expect("a pixel of the image")).collect()
}

/// Maximum difference between two images in a channel of a pixel.
fn difference(a: &[Rgb], b: &[Rgb]) -> f64 {
    assert_eq!(a.len(), b.len());
    let components = |(a, b): (&Rgb, &Rgb)| (*a - *b).to_array();
    a.iter().zip(b).flat_map(components).fold(0.0, |worst: f64, c| worst.max(c.abs()))
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

/// Base scenes with each precision and its tolerance.
fn cases() -> impl Iterator<Item = (Scene, (Precision, f64))> {
    base_scenes().into_iter().flat_map(|scene| TOLERANCES.map(|tolerance| (scene.clone(), tolerance)))
}

#[test]
fn scaling_does_not_change_the_image() {
    for (scene, (precision, tolerance)) in cases() {
        let expected = pixels(&scene, precision);
        for scale in [1e-3, 0.01, 7.0, 1e3] {
            let worst = difference(&expected, &pixels(&moved(&scene, scale, DVec3::ZERO), precision));
            assert!(worst <= tolerance, "{} at scale {scale}, {precision:?}: {worst:e}", scene.name);
        }
    }
}

#[test]
fn translation_does_not_change_the_image() {
    let million = DVec3::new(1e6, -1e6, 1e6);
    for (scene, (precision, tolerance)) in cases() {
        let expected = pixels(&scene, precision);
        for (scale, unit) in
            [(1.0, 1.0), (1024.0, 1.0), (1024.0, 1024.0), (1.0 / 1024.0, 1.0), (1.0 / 1024.0, 1.0 / 1024.0)]
        {
            let offset = million * unit;
            let worst = difference(&expected, &pixels(&moved(&scene, scale, offset), precision));
            let name = &scene.name;
            assert!(worst <= tolerance, "{name} at scale {scale}, moved by {offset}, {precision:?}: {worst:e}");
        }
    }
}

#[test]
fn shapes_with_large_coordinates_of_their_own_look_the_same() {
    for (precision, tolerance) in TOLERANCES {
        let scene = spheres();
        let expected = pixels(&scene, precision);
        let offset = DVec3::new(1e6, -1e6, 1e6);
        let mut far = moved(&scene, 1.0, offset);
        far.nodes = scene.nodes.clone();
        for node in &mut far.nodes {
            if let Some(Content::Shape(Shape::Sphere(sphere))) = &mut node.content {
                *sphere = Sphere::new(sphere.centre() + offset, sphere.radius()).expect("a sphere");
            }
        }
        let worst = difference(&expected, &pixels(&far, precision));
        assert!(worst <= tolerance, "{precision:?}: {worst:e}");
    }
}
