//! Independent passes: error estimates and stop rules.

use std::time::Duration;

use rt_camera::{CameraSettings, Projection, SamplerKind};
use rt_geometry::{Shape, Triangle};
use rt_math::{DVec3, Transform};
use rt_render::{
    Criterion, ErrorEstimate, PlanOptions, RenderError, Rendering, RunOptions, SampleRange, StopRule, Stopped,
    TargetError,
};
use rt_scene_io::{Content, Integrator, RenderSettings, Scene};
use rt_shading::{Material, Phong};

use crate::support::{compile, everything, node, render, scene, spheres};

/// A half-plane below `y = start + slope · x` over an image from 0 to 1, seen as gray ½ before black in the red channel.
fn half_plane(side: u32, start: f64, slope: f64) -> Scene {
    let at = |x: f64| DVec3::new(x - 0.5, start + slope * x - 0.5, 0.0);
    let triangle = Triangle::new([at(-9.0), DVec3::new(0.0, -99.0, 0.0), at(10.0)]).expect("a triangle");
    let camera = CameraSettings::new(Transform::translate(DVec3::Z), Projection::Orthographic { height: 1.0 });
    let materials = vec![Material::new("any".into(), Phong::default())];
    let mut scene = scene(camera, [side; 2], materials, vec![node(Content::Shape(Shape::Triangle(triangle)), 0)]);
    scene.settings.integrator = Integrator::Normals;
    scene
}

/// Exact pixel values of that image, row by row: half of the area of the pixel below the line.
fn truth(side: u32, start: f64, slope: f64) -> Vec<f64> {
    let n = f64::from(side);
    let area_below = |height: f64| if height > 1.0 { height - 0.5 } else { 0.5 * height.max(0.0) * height.max(0.0) };
    let pixel = |index: u32| {
        let (column, row) = (f64::from(index % side), n - 1.0 - f64::from(index / side));
        let height = |column: f64| start * n + slope * column - row;
        0.5 * (area_below(height(column + 1.0)) - area_below(height(column))) / slope
    };
    (0..side * side).map(pixel).collect()
}

fn fixed(scene: &Scene, run: RunOptions<'_>) -> Rendering {
    render(scene, PlanOptions::default(), run)
}

fn until(scene: &Scene, rule: StopRule, run: RunOptions<'_>) -> Rendering {
    compile(scene).render_until(&run, &rule, |_| {}).expect("renders")
}

fn to_error(relative: f64, two_stage: bool, max_spp: u32) -> StopRule {
    let target = TargetError { two_stage, ..TargetError::of_pixels(relative) };
    StopRule { target: Some(target), max_spp, time: None }
}

fn to_image_error(relative: f64, max_spp: u32) -> StopRule {
    StopRule { target: Some(TargetError::of_image(relative)), max_spp, time: None }
}

#[test]
fn a_pass_over_the_image_is_a_render_of_its_samples() {
    for mut scene in [spheres(), everything()] {
        scene.settings.spp = 1;
        let plain = fixed(&scene, RunOptions::default());
        let pass = until(&scene, StopRule { max_spp: 1, ..StopRule::default() }, RunOptions::default());
        assert_eq!(plain.film.checksum(), pass.film.checksum());
        assert_eq!((plain.error, pass.error, pass.stopped), (None, None, Stopped::Samples));
    }
}

#[test]
fn passes_one_after_the_other_are_those_of_a_tile() {
    let mut scene = half_plane(20, 0.3, 0.2);
    (scene.settings.spp, scene.settings.passes) = (2, Some(2));
    let run = RunOptions { maps: true, ..RunOptions::default() };
    let (tile_by_tile, progressive) =
        (fixed(&scene, run), until(&scene, StopRule { max_spp: 2, ..StopRule::default() }, run));
    assert_eq!(tile_by_tile.film.checksum(), progressive.film.checksum());
    assert_eq!(tile_by_tile.standard_error, progressive.standard_error);
    let rmse = |rendering: &Rendering| rendering.error.expect("two passes").rmse;
    assert!((rmse(&tile_by_tile) / rmse(&progressive) - 1.0).abs() < 1e-12);
}

#[test]
fn passes_are_independent_of_each_other() {
    let image = |spp, passes| {
        let mut scene = half_plane(12, 0.3, 0.2);
        (scene.settings.spp, scene.settings.passes) = (spp, Some(passes));
        fixed(&scene, RunOptions::default()).film
    };
    // Equal passes would give the image of one.
    assert_ne!(image(8, 2), image(4, 1));
    assert_eq!(image(4, 1), image(4, 1));
}

/// True error of an image, and its estimate.
fn errors(rendering: &Rendering, truth: &[f64]) -> (f64, ErrorEstimate) {
    let squares = rendering.film.pixels().iter().zip(truth).map(|(pixel, truth)| {
        let error = f64::from(pixel[0]) - truth;
        error * error
    });
    // Red and green are ½, blue is 1: their squared errors are as 1 : 1 : 4.
    let mean = 2.0 * squares.sum::<f64>() / truth.len() as f64;
    (mean.sqrt(), rendering.error.expect("several passes"))
}

#[test]
fn the_true_error_lies_within_its_interval() {
    let truth = truth(12, 0.3, 0.2);
    let (mut covered, mut squares, mut estimates, seeds) = (0, 0.0, 0.0, 200);
    let patterns =
        [SamplerKind::Random, SamplerKind::Jittered, SamplerKind::Sobol, SamplerKind::Halton, SamplerKind::BlueNoise];
    for pattern in patterns {
        for seed in 0..seeds {
            let mut scene = half_plane(12, 0.3, 0.2);
            scene.settings = RenderSettings { pattern, seed, spp: 16, passes: Some(4), ..scene.settings };
            let (error, estimate) = errors(&fixed(&scene, RunOptions { threads: 1, ..RunOptions::default() }), &truth);
            covered += u32::from((estimate.interval[0]..=estimate.interval[1]).contains(&error));
            squares += error * error;
            estimates += estimate.rmse * estimate.rmse;
        }
    }
    // At least 950 of 1000 expected; 932 has a probability of 1 % for 950.
    assert!(covered >= 932, "{covered} of 1000");
    let ratio: f64 = estimates / squares;
    assert!((0.9..1.1).contains(&ratio), "mean square estimated {ratio} times too large");
}

#[test]
fn fixed_patterns_have_no_error_estimate() {
    let mut scene = half_plane(4, 0.3, 0.2);
    (scene.settings.pattern, scene.settings.passes) = (SamplerKind::Grid, Some(2));
    assert_eq!(fixed(&scene, RunOptions::default()).error, None);
    let plan = compile(&scene);
    let refused = plan.render_until(&RunOptions::default(), &to_error(0.1, false, 64), |_| {});
    assert!(matches!(refused, Err(RenderError::SamePasses("grid"))), "{refused:?}");
}

#[test]
fn new_samples_are_without_bias() {
    let (mut sum, mut squares, seeds) = (0.0, 0.0, 300);
    for seed in 0..seeds {
        let mut scene = half_plane(1, 0.0, 0.176_326_980_708_464_98);
        (scene.settings.pattern, scene.settings.seed) = (SamplerKind::Random, seed);
        let rule = to_error(0.3, true, 1 << 14);
        let rendering = until(&scene, rule, RunOptions { threads: 1, ..RunOptions::default() });
        let mean = 2.0 * f64::from(rendering.film.pixels()[0][0]);
        assert_eq!(rendering.statistics.samples, 2 * u64::from(rendering.samples_per_pixel.max));
        sum += mean;
        squares += mean * mean;
    }
    let n = seeds as f64;
    let mean: f64 = sum / n;
    let standard_error = ((squares / n - mean * mean) / (n - 1.0)).sqrt();
    let z = (mean - 0.088_163_490_354_2) / standard_error;
    assert!(z.abs() < 4.0, "z = {z}");
}

#[test]
fn only_pixels_near_an_edge_stay_active() {
    let run = RunOptions { maps: true, ..RunOptions::default() };
    let rendering = until(&half_plane(32, 0.3, 0.2), to_error(0.02, false, 512), run);
    let SampleRange { min, max, .. } = rendering.samples_per_pixel;
    assert_eq!((min, max, rendering.stopped), (64, 512, Stopped::Samples));
    assert!(rendering.unconverged.is_some_and(|pixels| (1..60).contains(&pixels)), "{:?}", rendering.unconverged);
    let counts = rendering.sample_counts.expect("kept");
    let on_edge = |truth: f64| truth > 0.005 && truth < 0.495;
    for (count, truth) in counts.pixels().iter().zip(truth(32, 0.3, 0.2)) {
        assert!(!on_edge(truth) || count[0] > 64.0, "{count:?} samples at an edge");
    }
    let total: f64 = counts.pixels().iter().map(|count| f64::from(count[0])).sum();
    assert_eq!(total, rendering.statistics.samples as f64);
    assert!(rendering.samples_per_pixel.mean < 200.0, "{:?}", rendering.samples_per_pixel);
}

#[test]
fn time_ends_a_render_between_passes() {
    // On a busy machine, one pass may take the first of these times.
    let limits = [300, 3000, 30_000].map(Duration::from_millis).into_iter();
    let render = |limit| {
        let rule = StopRule { time: Some(limit), ..StopRule::default() };
        until(&half_plane(64, 0.3, 0.2), rule, RunOptions::default())
    };
    let rendering = limits.map(render).find(|rendering| rendering.samples_per_pixel.max > 1).expect("several passes");
    assert_eq!(rendering.stopped, Stopped::Time);
    let SampleRange { min, max, .. } = rendering.samples_per_pixel;
    assert!(min == max && rendering.error.is_some(), "{:?}", rendering.samples_per_pixel);
    // One pass is taken even without any time, and the image is complete.
    let none = StopRule { time: Some(Duration::ZERO), ..StopRule::default() };
    let rendering = until(&half_plane(64, 0.3, 0.2), none, RunOptions::default());
    assert_eq!((rendering.stopped, rendering.statistics.samples), (Stopped::Time, 64 * 64));
}

#[test]
fn the_default_target_is_that_of_the_image() {
    let scene = half_plane(40, 0.3, 0.2);
    let rendering = until(&scene, to_image_error(0.02, 4096), RunOptions::default());
    let SampleRange { min, max, .. } = rendering.samples_per_pixel;
    assert_eq!((rendering.stopped, rendering.unconverged, min), (Stopped::Target, None, max));
    let error = rendering.error.expect("several passes");
    // The last pass adds at most half of the samples, and patterns converge faster than random samples.
    assert!((0.009..=0.02).contains(&error.relative_rmse()), "{error:?}");
    let [low, high] = error.relative_interval();
    assert!(low < error.relative_rmse() && error.relative_rmse() < high);
    let every_pixel = until(&scene, to_error(0.02, false, 4096), RunOptions::default());
    assert!(every_pixel.statistics.samples > 4 * rendering.statistics.samples, "{:?}", every_pixel.statistics.samples);
}

#[test]
fn an_image_that_does_not_reach_its_error_ends_at_its_samples() {
    let rendering = until(&half_plane(40, 0.3, 0.2), to_image_error(1e-6, 64), RunOptions::default());
    assert_eq!((rendering.stopped, rendering.samples_per_pixel.max), (Stopped::Samples, 64));
    assert!(rendering.error.is_some_and(|error| error.relative_rmse() > 1e-6));
}

#[test]
fn small_images_discard_the_samples_of_the_first_stage() {
    let rendering = until(&half_plane(8, 0.3, 0.2), to_image_error(0.05, 4096), RunOptions::default());
    let pixels = u64::from(rendering.samples_per_pixel.max) * 64;
    assert_eq!((rendering.statistics.samples, rendering.stopped), (2 * pixels, Stopped::Target));
}

#[test]
fn a_share_of_the_pixels_may_miss_the_error() {
    let of = |share| {
        let target = TargetError { criterion: Criterion::Pixels { share }, ..TargetError::of_pixels(0.02) };
        let rule = StopRule { target: Some(target), max_spp: 512, time: None };
        until(&half_plane(32, 0.3, 0.2), rule, RunOptions::default())
    };
    // The edge cuts 32 pixels or a few more: 4 % of 1024.
    let most = of(0.95);
    assert_eq!((most.stopped, most.samples_per_pixel.max), (Stopped::Target, 64));
    assert!(most.unconverged.is_some_and(|pixels| (1..=51).contains(&pixels)), "{:?}", most.unconverged);
    assert_eq!(of(1.0).stopped, Stopped::Samples);
}
