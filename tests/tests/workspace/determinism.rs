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
fn bits(scene: &Scene, full: bool, threads: usize) -> Vec<u32> {
    let options = PlanOptions { full, ..PlanOptions::default() };
    let plan = RenderPlan::compile(scene, &options).expect("a scene that can be rendered");
    let rendering = plan.render(&RunOptions { threads, maps: true, ..RunOptions::default() }, |_| {}).expect("threads");
    assert_eq!(rendering.statistics.bad_samples, 0);
    let errors = rendering.standard_error.expect("maps are asked for");
    let films = [&rendering.film, &errors].map(|film| film.pixels().as_flattened());
    films.concat().into_iter().map(f32::to_bits).collect()
}

#[test]
fn threads_structures_and_the_full_plan_change_no_bit_and_the_seed_does() {
    let mut scene = scene();
    for integrator in INTEGRATORS {
        for pattern in SamplerKind::ALL {
            let settings = &mut scene.settings;
            (settings.integrator, settings.pattern, settings.accel) = (integrator, pattern, Accel::Linear);
            let expected = bits(&scene, false, 1);
            assert!(expected.iter().any(|bits| *bits != expected[0]), "an even image shows nothing");
            for (accel, full, threads) in [
                (Accel::Linear, false, 2),
                (Accel::Linear, true, 3),
                (Accel::Bvh, false, 1),
                (Accel::Bvh, false, 3),
                (Accel::Wide, false, 1),
                (Accel::Wide, true, 2),
                (Accel::Auto, false, 3),
            ] {
                scene.settings.accel = accel;
                let (integrator, pattern) = (integrator.name(), pattern.name());
                let what = format!("{integrator}, {pattern}, {}, full: {full}, {threads} threads", accel.name());
                assert!(bits(&scene, full, threads) == expected, "{what}");
            }
        }
        scene.settings.pattern = SamplerKind::Random;
        let images = [1, 2].map(|seed| {
            scene.settings.seed = seed;
            bits(&scene, false, 0)
        });
        assert_ne!(images[0], images[1], "{}", integrator.name());
    }
}
