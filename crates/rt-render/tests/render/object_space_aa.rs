//! Adaptive sampling in object space: it misses no edge, and its pixels are those of fixed sampling.

use rt_camera::{CameraSettings, FilmSettings, Filter, Lens, Projection, SamplerKind};
use rt_geometry::{Rectangle, Shape};
use rt_math::{
    DVec3, Rgb, Transform,
    random::{hash, unit},
    transcendental::hypot,
};
use rt_render::{Crop, PlanOptions, RenderError, RenderPlan, Rendering, RunOptions, SampleRange, StopRule};
use rt_scene_io::{Accel, AdaptiveSampling, Content, Integrator, RenderSettings, Scene, SceneNode};
use rt_shading::{Appearance, Background, ColorTexture, DeltaLight, DeltaLightKind, Falloff, Material, Phong};

use crate::support::{self, compile, cuboid, everything, full, glowing, node, node_at, plane, scene, sphere, spheres};

const MIN_SPP: u32 = 4;
const ALL: u32 = 16;

fn adaptive(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.settings.adaptive = Some(AdaptiveSampling::ObjectSpace { min_spp: Some(MIN_SPP) });
    scene
}

fn render_with(scene: &Scene, options: PlanOptions, threads: usize) -> Rendering {
    support::render(scene, options, RunOptions { threads, maps: true, ..RunOptions::default() })
}

fn render(scene: &Scene) -> Rendering {
    render_with(scene, PlanOptions::default(), 2)
}

fn counts(rendering: &Rendering) -> Vec<u32> {
    rendering.sample_counts.as_ref().expect("maps").pixels().iter().map(|count| count[0] as u32).collect()
}

/// Coordinates of the pixels that took all samples; the others took the minimum.
fn complex(rendering: &Rendering) -> Vec<[usize; 2]> {
    let width = rendering.film.width() as usize;
    let counts = counts(rendering);
    assert!(counts.iter().all(|count| [MIN_SPP, ALL].contains(count)));
    (0..counts.len()).filter(|&at| counts[at] == ALL).map(|at| [at % width, at / width]).collect()
}

fn colour(value: Rgb) -> ColorTexture {
    ColorTexture::Constant(value)
}

fn matte() -> Material {
    Material::new("matte".into(), Phong { ambient: colour(Rgb::WHITE), ..Phong::default() })
}

fn sun(direction: DVec3) -> DeltaLight {
    let kind = DeltaLightKind::Directional { direction: direction.normalize() };
    DeltaLight::new(kind, Rgb::WHITE)
}

/// A pixel is one unit wide and high; the point (x, y) is in column x and row 40 − y, counted down. The camera looks along
/// −z.
fn front_view(nodes: Vec<SceneNode>, materials: Vec<Material>, lights: Vec<DeltaLight>) -> Scene {
    let place = Transform::translate(DVec3::new(20.0, 20.0, 100.0));
    let camera = CameraSettings::new(place, Projection::Orthographic { height: 40.0 });
    let mut scene = scene(camera, [40, 40], materials, nodes);
    scene.settings.spp = ALL;
    scene.appearance.lights = lights;
    scene.appearance.ambient = Rgb::gray(0.1);
    scene.appearance.background = Background::Constant(Rgb::gray(0.3));
    scene
}

fn wall() -> SceneNode {
    node(plane(DVec3::ZERO, DVec3::Z), 0)
}

#[test]
fn the_smallest_objects_are_found() {
    // A twentieth of a pixel wide, in pixel (13, 40 − 1 − 7).
    let speck = || node(sphere(13.61, 7.58, 5.0, 0.025), 1);
    let materials = || vec![matte(), glowing(Rgb::WHITE)];
    let before_nothing = front_view(vec![speck()], materials(), vec![]);
    let before_a_wall = front_view(vec![wall(), speck()], materials(), vec![sun(DVec3::NEG_Z)]);
    for scene in [before_nothing, before_a_wall] {
        let rendering = render(&adaptive(&scene));
        assert_eq!(complex(&rendering), [[13, 32]]);
        assert_eq!((rendering.statistics.simple_pixels, rendering.statistics.samples), (1599, 1599 * 4 + 16));
        let mean = (1599.0 * 4.0 + 16.0) / 1600.0;
        assert_eq!(rendering.samples_per_pixel, SampleRange { min: MIN_SPP, mean, max: ALL });
    }
}

#[test]
fn shadow_edges_take_all_samples_and_umbrae_the_minimum() {
    // The sun is behind the camera, and so is the sphere that casts the shadow.
    let sphere_node = node(sphere(20.0, 20.0, 300.0, 7.3), 1);
    let scene = front_view(vec![wall(), sphere_node], vec![matte(), glowing(Rgb::WHITE)], vec![sun(DVec3::NEG_Z)]);
    let is_cut = |[column, row]: [usize; 2]| {
        let corners = [0.0, 1.0].map(|x| [0.0, 1.0].map(|y| hypot(column as f64 + x - 20.0, row as f64 + y - 20.0)));
        let inside = corners.as_flattened().iter().filter(|distance| **distance < 7.3).count();
        (1..4).contains(&inside)
    };
    let complex = complex(&render(&adaptive(&scene)));
    let cut: Vec<_> =
        (0..40).flat_map(|row| (0..40).map(move |column| [column, row])).filter(|at| is_cut(*at)).collect();
    assert!(cut.iter().all(|at| complex.contains(at)));
    assert!(complex.len() < 2 * cut.len(), "{} pixels for {} on the edge", complex.len(), cut.len());
    assert!(!complex.contains(&[20, 20]) && !complex.contains(&[2, 2]));
}

#[test]
fn occluded_objects_do_not_add_samples_and_visible_ones_do() {
    let rectangle = Rectangle::new(10.0, 10.0).expect("a rectangle");
    let upright = Transform::translate(DVec3::new(20.0, 20.0, 10.0))
        .compose(&Transform::rotate(DVec3::X, core::f64::consts::FRAC_PI_2).expect("an axis"));
    let shield = node_at(Content::Shape(Shape::Rectangle(rectangle)), 2, upright);
    let block = node(cuboid([18.3, 18.3, 2.0], [21.7, 21.7, 9.0]), 1);
    let materials = vec![matte(), glowing(Rgb::WHITE), glowing(Rgb::gray(0.5))];
    let of = |nodes: Vec<SceneNode>| complex(&render(&adaptive(&front_view(nodes, materials.clone(), vec![]))));
    // The edges of the shield lie between pixels; pyramids extend slightly beyond their pixels.
    let frame = of(vec![wall(), shield.clone()]);
    assert_eq!(frame.len(), 44 + 36);
    assert_eq!(of(vec![wall(), shield.clone(), block.clone()]), frame);
    let before = SceneNode { parent_from_local: Transform::translate(DVec3::Z * 20.0), ..block };
    assert_eq!(of(vec![wall(), shield, before]).len(), frame.len() + 12);
}

/// Any number of balls and boxes over a floor, in colours of their own. Under the sun the floor has two colours, and under a
/// light far away nearly so.
fn clutter(seed: u64, light: DeltaLight) -> Scene {
    let draw = |index: u64, what: u64| unit(hash(&[seed, index, what]));
    let place = |index| DVec3::new(8.0 * draw(index, 0) - 4.0, 2.0 * draw(index, 1), 8.0 * draw(index, 2) - 6.0);
    let mut nodes = vec![node(plane(DVec3::new(0.0, -0.5, 0.0), DVec3::Y), 0)];
    nodes.extend((0..12).map(|index| {
        let size = 0.02 + 0.8 * draw(index, 3) * draw(index, 4);
        let content = if index % 3 == 0 {
            let half = DVec3::new(size, size * draw(index, 5), size);
            cuboid(place(index) - half, place(index) + half)
        } else {
            let DVec3 { x, y, z } = place(index);
            sphere(x, y, z, size)
        };
        node(content, index as u32 + 1)
    }));
    let mut materials = vec![matte()];
    materials.extend((0..12).map(|index| glowing(Rgb::new(draw(index, 6), draw(index, 7), draw(index, 8)))));
    let base = spheres();
    Scene {
        film: FilmSettings { width: 90, height: 60, ..FilmSettings::default() },
        settings: RenderSettings { spp: ALL, ..RenderSettings::default() },
        appearance: Appearance { materials, lights: vec![light], ambient: Rgb::gray(0.2), ..base.appearance },
        nodes,
        ..base
    }
}

#[test]
fn no_simple_pixel_has_an_edge_in_it() {
    let light_far_away = DeltaLight {
        kind: DeltaLightKind::Point { position: DVec3::new(3e4, 8e4, 2e4), falloff: Falloff::None, shadow_near: 0.0 },
        ..sun(DVec3::NEG_Y)
    };
    let mut simple_pixels = 0;
    for seed in 0..12 {
        let light = if seed % 2 == 0 { sun(DVec3::new(-0.3, -0.8, -0.2)) } else { light_far_away.clone() };
        let scene = clutter(seed, light);
        // One sample of 128 beyond an edge would make it 4·10⁻³.
        let most = if seed % 2 == 0 { 1e-6 } else { 1e-3 };
        let counts = counts(&render(&adaptive(&scene)));
        // Eight independent passes agree only in pixels without an edge.
        let mut many = scene.clone();
        (many.settings.spp, many.settings.passes) = (128, Some(8));
        let errors = render(&many).standard_error.expect("maps");
        for (at, error) in errors.pixels().iter().enumerate().filter(|(at, _)| counts[*at] == MIN_SPP) {
            let place = (at % 90, at / 90);
            assert!(error.iter().all(|error| *error < most), "seed {seed}, pixel {place:?}: {error:?}");
            simple_pixels += 1;
        }
    }
    assert!(simple_pixels > 12 * 90 * 60 / 4, "{simple_pixels}");
}

fn same_bits(a: [f32; 3], b: [f32; 3]) -> bool {
    a.map(f32::to_bits) == b.map(f32::to_bits)
}

#[test]
fn each_pixel_is_that_of_a_render_with_as_many_samples() {
    let sunny = clutter(3, sun(DVec3::new(-0.3, -0.8, -0.2)));
    for (mut scene, pattern) in
        [(everything(), SamplerKind::Sobol), (spheres(), SamplerKind::Jittered), (sunny, SamplerKind::BlueNoise)]
    {
        for passes in [None, Some(2)] {
            scene.settings.pattern = pattern;
            scene.settings.passes = passes;
            let of = |spp: u32| {
                let mut scene = scene.clone();
                scene.settings.spp = spp;
                render(&scene).film
            };
            let (few, all) = (of(MIN_SPP), of(ALL));
            scene.settings.spp = ALL;
            let rendering = render(&adaptive(&scene));
            for (at, count) in counts(&rendering).into_iter().enumerate() {
                let expected = if count <= all_or(MIN_SPP, pattern, passes) { &few } else { &all };
                assert!(same_bits(rendering.film.pixels()[at], expected.pixels()[at]), "{} {at}", scene.name);
            }
            assert!(rendering.samples_per_pixel.min < rendering.samples_per_pixel.max, "{}", scene.name);
        }
    }
}

/// Number of samples that a pattern takes for a requested number, in passes.
fn all_or(spp: u32, pattern: SamplerKind, passes: Option<u32>) -> u32 {
    let passes = passes.unwrap_or(1);
    passes * pattern.round_up(spp.div_ceil(passes))
}

#[test]
fn sample_counts_are_independent_of_threads_accelerators_and_crops() {
    let mut round = spheres();
    round.settings.spp = ALL;
    round.film.filter = Filter::Tent;
    let mut all = everything();
    all.settings.spp = ALL;
    // Brute force, the second accelerator, would take long for all features.
    let scenes = [adaptive(&all), adaptive(&round), adaptive(&clutter(5, sun(DVec3::NEG_ONE)))];
    for (turn, scene) in scenes.into_iter().enumerate() {
        let expected = render(&scene);
        let check = |rendering: &Rendering, what: &str| {
            assert_eq!(counts(rendering), counts(&expected), "{} {what}", scene.name);
            assert_eq!(rendering.film.checksum(), expected.film.checksum(), "{} {what}", scene.name);
        };
        check(&render_with(&scene, PlanOptions::default(), 1), "on one thread");
        check(&render_with(&scene, full(), 2), "with nothing left out");
        // Each accelerator meets one of the scenes.
        for &accel in Accel::ALL.iter().skip(turn).step_by(3) {
            let mut other = scene.clone();
            other.settings.accel = accel;
            check(&render(&other), accel.name());
        }
        let crop = Crop { x: 13, y: 9, width: 21, height: 18 };
        let shard = render_with(&scene, PlanOptions { crop: Some(crop), ..PlanOptions::default() }, 2);
        let width = expected.film.width() as usize;
        let plan = compile(&scene);
        for (at, (count, pixel)) in counts(&shard).into_iter().zip(shard.film.pixels()).enumerate() {
            let [x, y] = [13 + at % 21, 9 + at / 21];
            assert_eq!(count, counts(&expected)[y * width + x]);
            assert!(same_bits(*pixel, expected.film.pixels()[y * width + x]), "{} {x} {y}", scene.name);
            let alone = plan.pixel(x as u32, y as u32).expect("a pixel").to_array().map(|c| c as f32);
            assert!(same_bits(*pixel, alone), "{} {x} {y}", scene.name);
        }
    }
}

#[test]
fn specular_surfaces_take_all_samples() {
    let mirror = Material::new("mirror".into(), Phong { mirror: colour(Rgb::gray(0.5)), ..Phong::default() });
    let scene = front_view(vec![wall()], vec![mirror], vec![]);
    assert_eq!(complex(&render(&adaptive(&scene))).len(), 1600);
}

#[test]
fn a_highlight_takes_all_samples_where_it_is_narrow() {
    let shiny = |exponent| {
        let phong = Phong { specular: colour(Rgb::WHITE), exponent, ..Phong::default() };
        let sphere_node = node(sphere(20.0, 20.0, 0.0, 15.0), 0);
        let scene = front_view(vec![sphere_node], vec![Material::new("shiny".into(), phong)], vec![sun(DVec3::NEG_Z)]);
        complex(&render(&adaptive(&scene)))
    };
    let (wide, narrow) = (shiny(1.0), shiny(400.0));
    assert!(!wide.contains(&[20, 20]) && narrow.contains(&[20, 20]));
    assert!(!narrow.contains(&[12, 20]), "away from the highlight");
}

#[test]
fn only_whitted_with_fixed_samples_is_adaptive_in_object_space() {
    let mut scene = adaptive(&spheres());
    let plan = compile(&scene);
    assert_eq!((plan.min_samples_per_pixel(), plan.samples_per_pixel()), (Some(4), 4));
    let until = plan.render_until(&RunOptions::default(), &StopRule::default(), |_| {});
    assert!(matches!(until, Err(RenderError::AdaptiveUntil)));
    for integrator in [Integrator::Path, Integrator::Direct, Integrator::Normals, Integrator::Cost] {
        scene.settings.integrator = integrator;
        let refused = RenderPlan::compile(&scene, &PlanOptions::default()).err();
        assert!(matches!(refused, Some(RenderError::Adaptive(name)) if name == integrator.name()));
    }
    scene.settings.integrator = Integrator::Whitted;
    scene.cameras[0].settings.lens = Some(Lens { radius: 0.1, focus: 5.0, blades: None, rotation: 0.0 });
    assert!(matches!(RenderPlan::compile(&scene, &PlanOptions::default()).err(), Some(RenderError::AdaptiveLens)));
}
