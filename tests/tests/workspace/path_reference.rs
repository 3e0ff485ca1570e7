//! The path integrator renders the bits of the reference integrator (`rt_shading::ReferencePathTracer`) in `f64`, in all scene files
//! and golden scenes.

use std::path::{Path, PathBuf};

use rt_render::{PlanOptions, Precision, RenderPlan, RunOptions};
use rt_scene_io::{Integrator, LoadOptions, RenderSettings, Scene};
use rt_tests::files_below;

/// Scene at a small size, with the lights that the integrator gets by default.
fn load(path: &Path, integrator: Integrator) -> Scene {
    let options = LoadOptions { integrator: Some(integrator), ..LoadOptions::default() };
    let mut scene = rt_scene_io::load(path, &options).unwrap_or_else(|error| panic!("{error}"));
    [scene.film.width, scene.film.height] = [24, 18];
    scene.settings = RenderSettings { integrator, spp: 4, passes: Some(2), adaptive: None, ..scene.settings };
    scene
}

/// Bits of the film and of its standard errors, and counts of null interfaces, ignored dielectrics, clamped light and bad samples.
fn rendered(scene: &Scene) -> (Vec<u32>, [u64; 5]) {
    let options = PlanOptions { precision: Precision::F64, ..PlanOptions::default() };
    let plan = RenderPlan::compile(scene, &options).unwrap_or_else(|error| panic!("{error}"));
    let rendering = plan.render(&RunOptions { maps: true, ..RunOptions::default() }, |_| {}).expect("threads");
    let errors = rendering.standard_error.expect("maps are kept");
    let films = [&rendering.film, &errors].map(|film| film.pixels().as_flattened());
    let statistics = &rendering.statistics;
    let shading = &statistics.shading;
    let counts =
        [shading.passages, shading.interior_overflows, shading.clamped, shading.clamped_units, statistics.bad_samples];
    (films.concat().into_iter().map(f32::to_bits).collect(), counts)
}

/// Compares the integrators in all files, with the settings of the file and with others. Returns the number of files, and that of
/// pairs of images whose pixels differ from each other.
fn compare(paths: &[PathBuf]) -> (usize, usize) {
    let mut varied = 0;
    for path in paths {
        let [mut waves, mut reference] = [Integrator::Path, Integrator::PathReference].map(|it| load(path, it));
        for scene in [&mut waves, &mut reference] {
            scene.settings.seed = 3;
        }
        let as_in_file = rendered(&waves);
        let place = path.display();
        assert!(as_in_file == rendered(&reference), "{place}, with its own settings");
        // More bounces, all of which Russian roulette may end, and clamped indirect light.
        for scene in [&mut waves, &mut reference] {
            scene.settings = RenderSettings { depth: 9, rr_start_depth: 0, clamp: Some(0.05), ..scene.settings };
        }
        let deep = rendered(&waves);
        assert!(deep == rendered(&reference), "{place}, deep and clamped");
        varied += [&as_in_file, &deep].into_iter().filter(|(bits, _)| bits.iter().any(|it| *it != bits[0])).count();
    }
    (paths.len(), varied)
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

#[test]
fn scene_files_have_the_bits_of_the_reference() {
    let paths = files_below(&repository().join("scenes"), &["ron", "nff", "pbrt", "obj", "gltf"]);
    let (count, varied) = compare(&paths);
    assert!(count >= 30 && varied == 2 * count, "{varied} images of {count} files show something");
}

#[test]
fn golden_scenes_have_the_bits_of_the_reference() {
    let paths = files_below(&repository().join("tests/golden"), &["ron"]);
    let (count, varied) = compare(&paths);
    assert!(count >= 75 && varied >= 2 * count - 10, "{varied} images of {count} files show something");
}
