//! An image is a function of scene, settings and seed: threads and accelerators change no bit of it, whatever is drawn at random.

use std::path::Path;

use rt_camera::SamplerKind;
use rt_render::{PlanOptions, RenderPlan, RunOptions};
use rt_scene_io::{Accel, Integrator, LoadOptions, Scene, format::parse_ron, resolve};

/// Area lights and a delta light, and surfaces of all kinds, in more than one tile.
const SCENE: &str = r#"(
    camera: (look_from: (0, 2, 6), look_at: (0, 0.7, 0)),
    film: (size: (40, 30)),
    settings: (spp: 4, max_depth: 4, rr_start_depth: 1),
    background: gradient(bottom: gray(0.1), top: rgb(0.2, 0.3, 0.5)),
    lights: [
        quad(corner: (-1, 4, -1), edges: ((2, 0, 0), (0, 0, 2)), radiance: gray(4), emission_sides: both),
        sphere(center: (3, 2, 1), radius: 0.2, radiance: rgb(9, 6, 3)),
        point(position: (-4, 3, 2), intensity: gray(0.3)),
    ],
    materials: {
        "chalk": diffuse(albedo: rgb(0.8, 0.7, 0.6), roughness: 0.5),
        "gold": metal(metal: gold, roughness: 0.2),
        "glass": glass(absorption: rgb(0.1, 0.2, 0.1)),
        "pane": thin_glass(),
        "plastic": metallic_roughness(base_color: rgb(0.2, 0.3, 0.9), metallic: 0, roughness: 0.3),
        "lacquer": mix([(0.7, glossy(diffuse: gray(0.4), specular: gray(0.4), exponent: 90)), (0.3, mirror())]),
    },
    nodes: [
        (shape: plane(), material: "chalk"),
        (shape: sphere(center: (-1.2, 0.6, 0), radius: 0.6), material: "gold"),
        (shape: sphere(center: (0.2, 0.6, 0.8), radius: 0.6), material: "glass"),
        (shape: box(min: (0.9, 0, -0.6), max: (1.8, 1.2, 0.2)), material: "plastic"),
        (shape: torus(radius: 0.5, tube_radius: 0.15), transform: [translate(-0.4, 0.2, 1.9)], material: "lacquer"),
        (shape: triangle((1.5, 0, 1.5), (2.5, 0, 1.2), (2, 1.2, 1.4)), material: "pane"),
        (shape: cylinder(radius: 0.3, top: 1.5), transform: [translate(-2.2, 0, -1)], material: "chalk"),
    ],
)"#;

const INTEGRATORS: [Integrator; 4] =
    [Integrator::Path, Integrator::Direct, Integrator::Distributed, Integrator::AmbientOcclusion];

fn scene() -> Scene {
    let name = Path::new("determinism.ron");
    let file = parse_ron(SCENE, name).unwrap_or_else(|error| panic!("{error}"));
    resolve(&file, name, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Bits of the film and of its error estimates.
fn bits(scene: &Scene, threads: usize) -> Vec<u32> {
    bits_by(PlanOptions::default(), scene, threads)
}

fn bits_by(options: PlanOptions, scene: &Scene, threads: usize) -> Vec<u32> {
    let plan = RenderPlan::compile(scene, &options).expect("a scene that can be rendered");
    let rendering = plan.render(&RunOptions { threads, maps: true, ..RunOptions::default() }, |_| {}).expect("threads");
    assert_eq!(rendering.statistics.bad_samples, 0);
    let errors = rendering.standard_error.expect("maps are asked for");
    let films = [&rendering.film, &errors].map(|film| film.pixels().as_flattened());
    films.concat().into_iter().map(f32::to_bits).collect()
}

#[test]
fn threads_and_structures_change_no_bit_of_any_integrator_with_any_pattern() {
    let mut scene = scene();
    for integrator in INTEGRATORS {
        for pattern in SamplerKind::ALL {
            (scene.settings.integrator, scene.settings.pattern, scene.settings.accel) =
                (integrator, pattern, Accel::Linear);
            let expected = bits(&scene, 1);
            assert!(expected.iter().any(|bits| *bits != expected[0]), "an even picture shows nothing");
            for (accel, threads) in [
                (Accel::Linear, 2),
                (Accel::Linear, 3),
                (Accel::Bvh, 1),
                (Accel::Bvh, 3),
                (Accel::Wide, 1),
                (Accel::Wide, 2),
                (Accel::Auto, 3),
            ] {
                scene.settings.accel = accel;
                let (integrator, pattern) = (integrator.name(), pattern.name());
                let what = format!("{integrator}, {pattern}, {}, {threads} threads", accel.name());
                assert!(bits(&scene, threads) == expected, "{what}");
            }
        }
    }
}

#[test]
fn the_full_plan_changes_no_bit_of_any_integrator() {
    let mut scene = scene();
    for integrator in INTEGRATORS {
        scene.settings.integrator = integrator;
        let full = bits_by(PlanOptions { full: true, ..PlanOptions::default() }, &scene, 1);
        assert!(bits(&scene, 1) == full, "{}", integrator.name());
    }
}

#[test]
fn the_seed_changes_the_picture() {
    let mut scene = scene();
    for integrator in INTEGRATORS {
        scene.settings.integrator = integrator;
        let images = [1, 2].map(|seed| {
            scene.settings.seed = seed;
            bits(&scene, 0)
        });
        assert_ne!(images[0], images[1], "{}", integrator.name());
    }
}
