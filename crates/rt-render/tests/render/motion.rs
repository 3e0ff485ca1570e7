//! Motion blur: animated objects are intersected at the time of each ray.

use rt_camera::{Projection, SamplerKind};
use rt_image::Image;
use rt_math::{AnimatedTransform, DVec3, Rgb, Transform};
use rt_render::{PlanOptions, RenderError, RenderPlan};
use rt_scene_io::{AdaptiveSampling, Integrator, RenderSettings, Scene};
use rt_shading::{Background, ColorTexture, Phong};

use crate::support::{compile, cuboid, everything, film, film_with, full, glowing, node, node_at, sphere, spheres};

fn shift(x: f64, y: f64, z: f64) -> Transform {
    Transform::translate(DVec3::new(x, y, z))
}

/// Scene in which everything except the floor moves: shapes, a mesh, instances, and an object within a group.
pub(crate) fn everything_moves() -> Scene {
    let mut scene = everything();
    let turn = Transform::rotate(DVec3::new(0.3, 1.0, -0.2), 0.7).expect("an axis");
    for (i, node) in (0..).zip(&mut scene.nodes).skip(1) {
        let step = shift(0.2 * f64::from(i % 3), 0.3, -0.1 * f64::from(i));
        node.moves_to = Some(step.compose(&node.parent_from_local).compose(&turn));
    }
    scene.groups[1].nodes[2].moves_to = Some(shift(0.0, 0.5, 0.0));
    scene
}

/// The camera moves as well.
pub(crate) fn camera_moves(mut scene: Scene) -> Scene {
    let camera = &mut scene.cameras[0].settings;
    camera.moves_to = Some(shift(0.5, 0.2, 0.0).compose(&camera.world_from_camera));
    scene
}

/// Static scene with all objects at their positions of one time.
fn frozen(scene: &Scene, time: f64) -> Scene {
    let mut scene = scene.clone();
    let groups = scene.groups.iter_mut().flat_map(|group| &mut group.nodes);
    for node in scene.nodes.iter_mut().chain(groups) {
        if let Some(motion) = node.motion().expect("a motion") {
            node.parent_from_local = motion.at(time);
        }
        node.moves_to = None;
    }
    let camera = &mut scene.cameras[0].settings;
    if let Some(end) = camera.moves_to.take() {
        camera.world_from_camera = AnimatedTransform::new(&camera.world_from_camera, &end).expect("a motion").at(time);
    }
    scene
}

#[test]
fn a_shutter_interval_of_length_zero_gives_the_static_image() {
    let mut scene = camera_moves(everything_moves());
    for integrator in [Integrator::Whitted, Integrator::Path, Integrator::Depth] {
        scene.settings.integrator = integrator;
        for time in [0.0, 0.375, 1.0] {
            scene.cameras[0].settings.shutter = [time; 2];
            assert_eq!(film(&scene), film(&frozen(&scene, time)), "{integrator:?} {time}");
        }
    }
    scene.cameras[0].settings.shutter = [0.0, 1.0];
    assert_ne!(film(&scene), film(&frozen(&scene, 0.0)));
}

/// With a shutter interval of one ulp, the image is the static one except for rounding.
#[test]
fn a_minimal_shutter_interval_gives_the_static_image() {
    let mut scene = everything_moves();
    scene.settings.passes = Some(1);
    let still = film(&frozen(&scene, 0.375));
    scene.cameras[0].settings.shutter = [0.375, 0.375_f64.next_up()];
    let plan = compile(&scene);
    assert!(!plan.explain().left_out.iter().any(|left| left.what == "motion blur"));
    let moving = film(&scene);
    let differs = |(a, b): &(&[f32; 3], &[f32; 3])| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1e-4);
    // A sample next to an edge may fall on the other side of it.
    let different = moving.pixels().iter().zip(still.pixels()).filter(differs).count();
    assert!(different <= 3, "{different} of {} pixels", moving.pixels().len());
}

/// Means of blocks of 10 × 10 pixels.
fn blocks(film: &Image) -> Vec<f64> {
    let (width, height) = (film.width() as usize, film.pixels().len() / film.width() as usize);
    let block = |left: usize, top: usize| {
        let rows = film.pixels().chunks(width).skip(top).take(10);
        let sum: f32 = rows.flat_map(|row| &row[left..left + 10]).map(|[r, g, b]| r + g + b).sum();
        f64::from(sum) / 300.0
    };
    (0..height / 10).flat_map(|y| (0..width / 10).map(move |x| block(10 * x, 10 * y))).collect()
}

/// Mean of [`blocks`] over static images, at the midpoints of equal subintervals of the shutter.
fn blocks_of_stills(scene: &Scene, count: u32) -> Vec<f64> {
    let stills = (0..count).map(|i| {
        let mut still = frozen(scene, (f64::from(i) + 0.5) / f64::from(count));
        (still.settings.seed, still.settings.spp) = (u64::from(i) + 1, scene.settings.spp / 8);
        blocks(&film(&still))
    });
    let add = |sum: Vec<f64>, still: Vec<f64>| sum.iter().zip(still).map(|(a, b)| a + b).collect();
    let sum = stills.reduce(add).unwrap_or_default();
    sum.iter().map(|value| value / f64::from(count)).collect()
}

/// All rays of a camera path share its time, and all rays of a light path have the time of that path.
#[test]
fn the_image_is_the_mean_of_static_images() {
    let mut scene = camera_moves(everything_moves());
    scene.appearance.materials[5].emission = ColorTexture::ZERO;
    for (integrator, tolerance) in [
        (Integrator::Whitted, 0.015),
        (Integrator::Distributed, 0.015),
        (Integrator::Path, 0.03),
        (Integrator::Direct, 0.015),
        (Integrator::AmbientOcclusion, 0.015),
        (Integrator::Normals, 0.005),
    ] {
        scene.settings = RenderSettings { integrator, spp: 64, ..scene.settings };
        for (moving, still) in blocks(&film(&scene)).into_iter().zip(blocks_of_stills(&scene, 16)) {
            assert!((moving - still).abs() < tolerance, "{integrator:?}: {moving} {still}");
        }
    }
}

/// A glass sphere with its caustic moves over a floor. A diffuse sphere casts a shadow, and the camera moves as well.
#[test]
fn caustics_in_motion_are_means_of_static_images() {
    let mut scene = everything();
    scene.groups.clear();
    scene.appearance.background = Background::Constant(Rgb::BLACK);
    scene.appearance.ambient = Rgb::BLACK;
    scene.appearance.lights.truncate(1);
    scene.nodes.truncate(1);
    let fly = |x: f64, material| {
        let mut moving_sphere = node_at(sphere(0.0, 0.0, 0.0, 0.7), material, shift(x, 0.6, 0.0));
        moving_sphere.moves_to = Some(shift(x + 1.5, 0.6, 1.0));
        moving_sphere
    };
    scene.nodes.extend([fly(-1.0, 3), fly(-3.0, 0)]);
    let camera = &mut scene.cameras[0].settings;
    camera.moves_to = Some(shift(0.8, 0.0, 0.0).compose(&camera.world_from_camera));
    scene.settings = RenderSettings { integrator: Integrator::Caustics, spp: 64, ..scene.settings };
    let moving = blocks(&film(&scene));
    let paths = Scene { settings: RenderSettings { integrator: Integrator::Path, ..scene.settings }, ..scene.clone() };
    let without = blocks(&film(&paths));
    let gathered = moving.iter().zip(&without).map(|(with, without)| with - without).fold(0.0, f64::max);
    for (moving, still) in moving.iter().zip(blocks_of_stills(&scene, 16)) {
        assert!((moving - still).abs() < 0.012, "{moving} {still}");
    }
    assert!(gathered > 0.03, "{gathered}");
}

/// Water moves away from the camera, or the camera leaves it: each ray starts in the medium of its time.
#[test]
fn camera_rays_start_in_the_medium_of_their_time() {
    let mut scene = everything();
    scene.groups.clear();
    scene.nodes.truncate(1);
    scene.nodes.push(node(sphere(0.0, 0.0, 0.0, 2.0), 3));
    scene.cameras[0].settings.world_from_camera = shift(0.0, 0.0, 0.5);
    scene.settings.spp = 16;
    let mut camera_moves = scene.clone();
    camera_moves.cameras[0].settings.moves_to = Some(shift(0.0, 0.0, 4.5));
    scene.nodes[1].moves_to = Some(shift(0.0, 0.0, -4.0));
    for scene in [scene, camera_moves] {
        for (moving, still) in blocks(&film(&scene)).into_iter().zip(blocks_of_stills(&scene, 32)) {
            assert!((moving - still).abs() < 0.02, "{moving} {still}");
        }
    }
}

#[test]
fn edges_are_looked_for_where_nothing_moves() {
    let mut scene = spheres();
    scene.settings.adaptive = Some(AdaptiveSampling::ObjectSpace { min_spp: None });
    let refusal = |scene: &Scene| RenderPlan::compile(scene, &PlanOptions::default()).err();
    assert!(refusal(&scene).is_none());
    scene.nodes[3].moves_to = Some(shift(1.0, 0.0, 0.0));
    assert!(matches!(refusal(&scene), Some(RenderError::AdaptiveMotion)));
    scene.cameras[0].settings.shutter = [0.5; 2];
    assert!(refusal(&scene).is_none());
    let camera = &mut scene.cameras[0].settings;
    (camera.shutter, camera.moves_to) = ([0.0, 0.5], Some(shift(0.0, 1.0, 9.0)));
    scene.nodes[3].moves_to = None;
    assert!(matches!(refusal(&scene), Some(RenderError::AdaptiveMotion)));
}

/// 200 spheres that move in all directions past a static camera. Culling excludes most, and none that is visible at any time.
#[test]
fn objects_that_cross_the_view_are_not_culled() {
    let mut scene = spheres();
    scene.nodes = (0..200u64)
        .map(|i| {
            let unit = |k| 2.0 * rt_math::random::unit(rt_math::random::hash(&[i, k])) - 1.0;
            let place = DVec3::new(unit(0), unit(1), unit(2)) * 20.0;
            let mut node = node_at(sphere(0.0, 0.0, 0.0, 0.5), 0, Transform::translate(place));
            let turn = Transform::rotate(DVec3::new(unit(3), unit(4), unit(5)), 2.0).expect("an axis");
            node.moves_to =
                Some(Transform::translate(place + DVec3::new(unit(6), unit(7), unit(8)) * 4.0).compose(&turn));
            node
        })
        .collect();
    let plan = compile(&scene);
    let explanation = plan.explain();
    assert!(explanation.left_out.iter().any(|left| left.what == "objects, for camera rays"));
    assert!(explanation.used.iter().any(|line| line.starts_with("200 animated objects:")));
    let full = film_with(&scene, full(), 0);
    assert_eq!(film(&scene), full);
}

#[test]
fn static_scenes_sample_no_time() {
    let mut scene = everything();
    let image = film(&scene);
    scene.cameras[0].settings.shutter = [0.25, 0.5];
    for node in &mut scene.nodes {
        node.moves_to = Some(node.parent_from_local);
    }
    scene.cameras[0].settings.moves_to = Some(scene.cameras[0].settings.world_from_camera);
    let plan = compile(&scene);
    assert!(plan.explain().left_out.iter().any(|left| left.what == "motion blur"));
    assert_eq!(film(&scene), image);
}

/// A white sphere of radius r moves by 4r over black. On the line of its centre, away from both ends, coverage is ½.
#[test]
fn coverage_by_a_moving_sphere_is_proportional_to_its_chords() {
    let (radius, way) = (0.5, 2.0);
    let mut scene = spheres();
    let place = shift(0.0, 0.0, 9.0);
    scene.cameras[0].settings = rt_camera::CameraSettings::new(place, Projection::Orthographic { height: 2.0 });
    (scene.film.width, scene.film.height) = (1, 65);
    (scene.settings.spp, scene.settings.pattern) = (4096, SamplerKind::Sobol);
    scene.appearance.lights.clear();
    scene.appearance.background = Background::Constant(Rgb::BLACK);
    scene.appearance.materials[0] = glowing(Rgb::WHITE);
    let mut moving_sphere = node_at(sphere(0.0, 0.0, 0.0, radius), 0, shift(-0.5 * way, 0.0, 0.0));
    moving_sphere.moves_to = Some(shift(0.5 * way, 0.0, 0.0));
    scene.nodes = vec![moving_sphere];
    for (shutter, open_share) in [([0.0, 1.0], 1.0), ([0.25, 0.75], 0.5)] {
        scene.cameras[0].settings.shutter = shutter;
        let film = film(&scene);
        let mut squares = 0.0;
        for (row, pixel) in film.pixels().iter().enumerate() {
            // The mean over the pixel of the chord 2·√(r² − y²), by the antiderivative y·√(r² − y²) + r²·asin(y/r).
            let integral = |y: f64| {
                let y = y.clamp(-radius, radius);
                y * (radius * radius - y * y).sqrt() + radius * radius * rt_math::transcendental::asin(y / radius)
            };
            let side = 2.0 / 65.0;
            let bottom = 1.0 - side * (row as f64 + 1.0);
            let expected = (integral(bottom + side) - integral(bottom)) / side / (way * open_share);
            let error = f64::from(pixel[0]) - expected;
            assert!(error.abs() < 0.01, "row {row}: {} for {expected}", pixel[0]);
            squares += error * error;
        }
        let rms = (squares / 65.0).sqrt();
        assert!(rms < 0.002, "{rms}");
    }
}

/// Rays reflected by a rotating sphere must not hit it again: it is convex.
#[test]
fn reflected_rays_do_not_hit_their_origin() {
    let mut scene = spheres();
    let mirror = Phong { mirror: ColorTexture::Constant(Rgb::WHITE), diffuse: ColorTexture::ZERO, ..Phong::default() };
    scene.appearance.materials[0].model =
        Phong { specular: ColorTexture::ZERO, ambient: ColorTexture::ZERO, ..mirror }.into();
    scene.appearance.lights.clear();
    scene.appearance.background = Background::Constant(Rgb::WHITE);
    scene.settings.depth = 1;
    let squash = Transform::scale(DVec3::new(1.5, 0.4, 0.9)).expect("regular");
    let turn = Transform::rotate(DVec3::new(1.0, 2.0, 3.0), 2.5).expect("an axis");
    let mut egg = node_at(sphere(0.0, 0.0, 0.0, 1.0), 0, squash);
    egg.moves_to = Some(shift(0.5, 0.5, 0.0).compose(&turn).compose(&squash));
    scene.nodes = vec![egg];
    assert!(film(&scene).pixels().iter().all(|pixel| *pixel == [1.0; 3]), "all is as white as the sky");
}

/// Animated lights are not sampled. Paths that hit them compute the same radiance as for static lights.
#[test]
fn animated_lights_are_found_by_rays() {
    let mut scene = spheres();
    scene.appearance.lights.clear();
    scene.appearance.background = Background::Constant(Rgb::BLACK);
    let mut emissive_material = scene.appearance.materials[0].clone();
    emissive_material.emission = ColorTexture::Constant(Rgb::WHITE);
    emissive_material.model = Phong::default().into();
    scene.appearance.materials.push(emissive_material);
    // An infinite ceiling covers the same points at all times: its light is that of a static one.
    scene.nodes.push(node(cuboid([-40.0, 4.0, -40.0], [40.0, 5.0, 40.0]), 1));
    let mean = |scene: &Scene| {
        let film = film(scene);
        film.pixels().iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / film.pixels().len() as f64
    };
    let mut moving = scene.clone();
    moving.nodes.last_mut().expect("the light").moves_to = Some(shift(0.0, 1e-6, 0.0));
    for integrator in [Integrator::Path, Integrator::Direct, Integrator::Caustics] {
        let [still, moving] = [&scene, &moving].map(|scene| {
            let settings = RenderSettings { integrator, spp: 128, ..scene.settings };
            mean(&Scene { settings, ..scene.clone() })
        });
        assert!(still > 0.01 && (moving / still - 1.0).abs() < 0.02, "{integrator:?}: {moving} {still}");
    }
    let plan = compile(&moving);
    assert!(
        plan.explain().used.iter().all(|line| !line.starts_with("moving emitters")),
        "whitted samples no area lights"
    );
    moving.settings.integrator = Integrator::Path;
    let plan = compile(&moving);
    assert!(plan.explain().used.iter().any(|line| line.starts_with("moving emitters")));
}
