//! The path integrator renders the image of the reference integrator (`rt_shading::ReferencePathTracer`) in `f64`, in all scene files
//! and golden scenes.

use std::path::{Path, PathBuf};

use rt_render::{PlanOptions, Precision, RenderPlan, RunOptions};
use rt_scene_io::{Integrator, LoadOptions, RenderSettings, Scene};
use rt_shading::{AlphaMode, Material};
use rt_tests::files_below;

/// Scene at a small size, with the lights that the integrator gets by default.
fn load(path: &Path, integrator: Integrator) -> Scene {
    let options = LoadOptions { integrator: Some(integrator), ..LoadOptions::default() };
    let mut scene = rt_scene_io::load(path, &options).unwrap_or_else(|error| panic!("{error}"));
    [scene.film.width, scene.film.height] = [24, 18];
    scene.settings = RenderSettings { integrator, spp: 4, passes: Some(2), adaptive: None, ..scene.settings };
    scene
}

/// Film with its standard errors, and counts of null interfaces, ignored dielectrics, clamped light and bad samples.
type Rendered = (Vec<[f32; 3]>, [u64; 4]);

fn rendered(scene: &Scene) -> Rendered {
    let options = PlanOptions { precision: Precision::F64, ..PlanOptions::default() };
    let plan = RenderPlan::compile(scene, &options).unwrap_or_else(|error| panic!("{error}"));
    let rendering = plan.render(&RunOptions { maps: true, ..RunOptions::default() }, |_| {}).expect("threads");
    let errors = rendering.standard_error.expect("maps are kept");
    let statistics = &rendering.statistics;
    let shading = &statistics.shading;
    let counts = [shading.null_interfaces, shading.interior_overflows, shading.clamped, statistics.bad_samples];
    ([rendering.film.pixels(), errors.pixels()].concat(), counts)
}

/// Number of pixels whose components differ by more than rounding. The order of operations differs in lanes.
fn differing(a: &Rendered, b: &Rendered) -> usize {
    let is_close = |a: &f32, b: &f32| (a - b).abs() <= 1e-5 * a.abs().max(b.abs()).max(1e-3);
    let differs = |(a, b): &(&[f32; 3], &[f32; 3])| !a.iter().zip(*b).all(|(a, b)| is_close(a, b));
    a.0.iter().zip(&b.0).filter(differs).count()
}

/// Compares the integrators in all files, with the settings of the file and with others. Returns the number of files, and that of
/// pairs of images whose pixels differ from each other.
fn compare(paths: &[PathBuf]) -> (usize, usize) {
    let mut varied = 0;
    for path in paths {
        let [mut waves, mut reference] = [Integrator::Path, Integrator::PathReference].map(|it| load(path, it));
        // Rounding of a ray changes the random number that decides whether it passes a blended surface.
        let is_blended = |material: &Material| material.alpha.mode == AlphaMode::Blend;
        let is_random = waves.appearance.materials.iter().any(is_blended);
        let most = if is_random { 24 * 18 / 20 } else { 0 };
        let place = path.display();
        let compare = |settings: &str, waves: &Rendered, reference: &Rendered| {
            let n_differing = differing(waves, reference);
            assert!(n_differing <= most, "{place}, {settings}: {n_differing} pixels differ");
            assert!(is_random || waves.1 == reference.1, "{place}, {settings}: {:?}, {:?}", waves.1, reference.1);
        };
        for scene in [&mut waves, &mut reference] {
            scene.settings.seed = 3;
        }
        let as_in_file = rendered(&waves);
        compare("with its own settings", &as_in_file, &rendered(&reference));
        // More bounces, all of which Russian roulette may end, and clamped indirect light.
        for scene in [&mut waves, &mut reference] {
            scene.settings = RenderSettings { depth: 9, rr_start_depth: 0, clamp: Some(0.05), ..scene.settings };
        }
        let deep = rendered(&waves);
        compare("deep and clamped", &deep, &rendered(&reference));
        let is_varied = |(film, _): &&Rendered| film.iter().any(|pixel| *pixel != film[0]);
        varied += [&as_in_file, &deep].into_iter().filter(is_varied).count();
    }
    (paths.len(), varied)
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

#[test]
fn scene_files_have_the_image_of_the_reference() {
    let paths = files_below(&repository().join("scenes"), &["ron", "nff", "pbrt", "obj", "gltf"]);
    let (count, varied) = compare(&paths);
    assert!(count >= 30 && varied == 2 * count, "{varied} images of {count} files show something");
}

#[test]
fn golden_scenes_have_the_image_of_the_reference() {
    let paths = files_below(&repository().join("tests/golden"), &["ron"]);
    let (count, varied) = compare(&paths);
    assert!(count >= 75 && varied >= 2 * count - 10, "{varied} images of {count} files show something");
}
