//! Clamping of indirect light: no effect without a bound, never more light with one.

use rt_camera::SamplerKind;
use rt_math::{DVec3, Rgb};
use rt_render::{Clamping, PlanOptions, RenderError, RenderPlan, Rendering, RunOptions};
use rt_scene_io::{Integrator, Scene};
use rt_shading::{ColorTexture, Material, MaterialModel};

use crate::support::{camera, compile, cuboid, node, scene, sphere};

fn material(model: MaterialModel, emission: f64) -> Material {
    let emission = ColorTexture::Constant(Rgb::new(emission, 0.8 * emission, 0.5 * emission));
    Material { emission, ..Material::new("surface".into(), model) }
}

/// A closed room with a small area light and a mirror: indirect light with rare bright paths.
fn closed_scene() -> Scene {
    let gray = |value| ColorTexture::Constant(Rgb::gray(value));
    let materials = vec![
        material(MaterialModel::Diffuse { albedo: gray(0.7), roughness: 0.0 }, 0.0),
        material(MaterialModel::Mirror { reflectance: gray(0.9) }, 0.0),
        material(MaterialModel::Black, 60.0),
    ];
    let nodes = vec![
        node(cuboid([-2.0, 0.0, -2.0], [2.0, 3.0, 4.0]), 0),
        node(sphere(0.8, 0.6, 0.0, 0.6), 1),
        node(sphere(-1.0, 2.8, 3.7, 0.15), 2),
    ];
    let mut scene = scene(camera([0.0, 1.0, 3.9], [0.0, 1.0, 0.0], DVec3::Y, 1.0), [24, 18], materials, nodes);
    (scene.settings.spp, scene.settings.pattern, scene.settings.depth) = (16, SamplerKind::Random, 6);
    scene
}

fn with(integrator: Integrator, clamp: Option<f64>) -> Scene {
    let mut scene = closed_scene();
    (scene.settings.integrator, scene.settings.clamp) = (integrator, clamp);
    scene
}

fn render(scene: &Scene, threads: usize) -> (Rendering, Option<Clamping>) {
    let plan = compile(scene);
    let rendering = plan.render(&RunOptions { threads, ..RunOptions::default() }, |_| {}).expect("renders");
    let clamping = plan.clamping(&rendering);
    (rendering, clamping)
}

const CLAMPED: [Integrator; 3] = [Integrator::Path, Integrator::Distributed, Integrator::Caustics];

#[test]
fn a_bound_that_nothing_exceeds_changes_no_bit() {
    for integrator in CLAMPED {
        let (off, none) = render(&with(integrator, None), 2);
        let (on, clamping) = render(&with(integrator, Some(1e30)), 2);
        assert_eq!(off.film.checksum(), on.film.checksum(), "{}", integrator.name());
        assert_eq!((none, clamping.map(|clamping| clamping.contributions)), (None, Some(0)));
    }
}

#[test]
fn clamped_images_are_never_brighter_and_less_noisy() {
    let (off, _) = render(&with(Integrator::Path, None), 2);
    let (on, clamping) = render(&with(Integrator::Path, Some(0.5)), 2);
    let clamping = clamping.expect("set");
    assert!(clamping.contributions > 100, "{clamping:?}");
    for (off, on) in off.film.pixels().as_flattened().iter().zip(on.film.pixels().as_flattened()) {
        assert!(*on <= off * (1.0 + 1e-6), "{on} is more than {off}");
    }
    let mean = |rendering: &Rendering| {
        let values = rendering.film.pixels().as_flattened();
        values.iter().map(|&value| f64::from(value)).sum::<f64>() / values.len() as f64
    };
    let lost = 1.0 - mean(&on) / mean(&off);
    assert!(lost > 0.001 && (clamping.lost_share / lost - 1.0).abs() < 1e-3, "{} and {lost}", clamping.lost_share);
    let rmse = |rendering: &Rendering| rendering.error.expect("several passes").rmse;
    assert!(rmse(&on) < 0.9 * rmse(&off), "{} and {}", rmse(&on), rmse(&off));
}

#[test]
fn direct_light_is_not_clamped() {
    // A tiny bound leaves direct light only.
    let (direct, none) = render(&with(Integrator::Direct, Some(1e-12)), 2);
    assert_eq!(none, None, "there is no indirect light");
    let (path, _) = render(&with(Integrator::Path, Some(1e-12)), 2);
    for (direct, path) in direct.film.pixels().as_flattened().iter().zip(path.film.pixels().as_flattened()) {
        assert!((direct - path).abs() <= 1e-6 * direct.max(1e-3), "{path} is not {direct}");
    }
}

#[test]
fn the_count_of_clamped_contributions_is_that_of_any_number_of_threads() {
    for integrator in CLAMPED {
        let scene = with(integrator, Some(0.2));
        let (one, of_one) = render(&scene, 1);
        let (three, of_three) = render(&scene, 3);
        assert_eq!((one.film.checksum(), of_one), (three.film.checksum(), of_three), "{}", integrator.name());
        assert_eq!(one.statistics.shading, three.statistics.shading);
    }
}

#[test]
fn bounds_that_are_no_radiance_are_refused() {
    for clamp in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let scene = with(Integrator::Path, Some(clamp));
        let refused = RenderPlan::compile(&scene, &PlanOptions::default());
        assert!(matches!(refused.map(|_| ()), Err(RenderError::Clamp(_))), "{clamp}");
    }
}
