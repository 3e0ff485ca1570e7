//! Frustum culling: camera rays skip objects outside the view; other rays and the image do not change.

use rt_camera::{Filter, Projection};
use rt_geometry::RayKind;
use rt_image::Image;
use rt_math::{DVec2, Rgb, Transform};
use rt_render::{Crop, PlanOptions, RunOptions, Statistics};
use rt_scene_io::{Accel, Content, Group, GroupId, Integrator, Scene};
use rt_shading::{Background, ColorTexture, Phong};

use crate::support::{self, compile, compile_with, everything, full, node, node_at, point_light, sphere, spheres};

/// 300 mirrors in all directions around the camera, most of them outside the view.
pub(crate) fn surrounded() -> Scene {
    let mut scene = spheres();
    scene.name = "surrounded".into();
    let eye = scene.cameras[0].settings.world_from_camera.translation();
    let mirror = ColorTexture::Constant(Rgb::gray(0.5));
    scene.appearance.materials[0].model = Phong { mirror, ..Phong::default() }.into();
    scene.appearance.lights = vec![point_light((eye + 0.5).to_array(), 0.8)];
    scene.nodes = (0..300u32)
        .map(|i| {
            let unit = |k| 2.0 * rt_math::random::unit(rt_math::random::hash(&[u64::from(i), k])) - 1.0;
            let centre = rt_math::DVec3::new(unit(0), unit(1), unit(2)).normalize() * (4.0 + f64::from(i % 7)) + eye;
            node(sphere(centre.x, centre.y, centre.z, 0.3), 0)
        })
        .collect();
    scene.settings.depth = 3;
    scene
}

fn render(scene: &Scene, options: PlanOptions) -> (Image, Statistics) {
    let rendering = support::render(scene, options, RunOptions { count: true, ..RunOptions::default() });
    (rendering.film, rendering.statistics)
}

/// Number of objects that the plan culls for camera rays.
fn culled(scene: &Scene, options: &PlanOptions) -> Option<usize> {
    let plan = compile_with(scene, *options);
    let line = plan.explain().left_out.into_iter().find(|left| left.what == "objects, for camera rays")?;
    line.reason.split(' ').next()?.parse().ok()
}

fn assert_culling_keeps_image(scene: &Scene, options: PlanOptions) {
    let culled = render(scene, options).0;
    let full = render(scene, PlanOptions { full: true, ..options }).0;
    assert_eq!(culled, full, "{}", scene.name);
    let distinct: std::collections::HashSet<_> = culled.pixels().iter().map(|p| p.map(f32::to_bits)).collect();
    assert!(distinct.len() > culled.pixels().len() / 50, "an image worth comparing");
}

#[test]
fn the_image_is_the_same_for_all_cameras_filters_and_crops() {
    let mut scene = surrounded();
    let view = scene.cameras[0].settings;
    let parallel = Projection::Orthographic { height: 4.0 };
    let crop = Some(Crop { x: 20, y: 10, width: 9, height: 7 });
    for projection in [view.projection, parallel] {
        scene.cameras[0].settings.projection = projection;
        for filter in [Filter::Box, Filter::Gaussian { sigma: 2.0 }, Filter::Mitchell] {
            scene.film.filter = filter;
            for (crop, sample_offset) in [(None, 0.5), (crop, 0.5), (crop, -7.0)] {
                scene.film.sample_offset = DVec2::splat(sample_offset);
                let options = PlanOptions { crop, ..PlanOptions::default() };
                assert!(culled(&scene, &options).expect("something to leave out") >= 150);
                assert_culling_keeps_image(&scene, options);
            }
        }
    }
}

#[test]
fn mixed_worlds_keep_their_floor_and_their_groups() {
    let mut scene = everything();
    scene.name = "mixed".into();
    let eye = scene.cameras[0].settings.world_from_camera.translation();
    // Behind the camera: single spheres, and instances of a group, culled as a whole.
    scene.groups.push(Group { name: "ball".into(), nodes: vec![node(sphere(0.0, 0.0, 0.0, 0.5), 2)] });
    let group = GroupId(scene.groups.len() as u32 - 1);
    for i in 0..40 {
        let centre = eye * 1.5 + rt_math::DVec3::X * f64::from(i - 20);
        scene.nodes.push(node(sphere(centre.x, centre.y, centre.z, 0.4), 0));
        scene.nodes.push(node_at(Content::Instance(group), 0, Transform::translate(centre + rt_math::DVec3::Y)));
    }
    let left_out = culled(&scene, &PlanOptions::default()).expect("something to leave out");
    assert!((80..90).contains(&left_out), "{left_out}: all that were added, and hardly more");
    assert_culling_keeps_image(&scene, PlanOptions::default());
}

#[test]
fn culling_saves_work_of_camera_rays_only() {
    let mut scene = surrounded();
    let work = |scene: &Scene, options: PlanOptions| {
        let counters = render(scene, options).1.counters;
        (counters.of(RayKind::Primary), counters.of(RayKind::Reflection))
    };
    for accel in [Accel::Linear, Accel::Bvh] {
        scene.settings.accel = accel;
        let (primary, reflection) = work(&scene, PlanOptions::default());
        let (primary_full, reflection_full) = work(&scene, full());
        assert_eq!((primary.rays, primary.hits > 0), (primary_full.rays, true));
        assert!(
            primary.nodes + primary.tests < primary_full.nodes + primary_full.tests,
            "{primary:?} {primary_full:?}"
        );
        assert!(reflection.rays > 1000);
        assert_eq!(reflection, reflection_full);
    }
    // Brute force tests each camera ray against all visible primitives.
    scene.settings.accel = Accel::Linear;
    let (primary, _) = work(&scene, PlanOptions::default());
    let visible = 300 - culled(&scene, &PlanOptions::default()).expect("something to leave out") as u64;
    assert_eq!(primary.tests, primary.rays * visible);
}

#[test]
fn a_second_accelerator_is_built_only_if_it_pays() {
    assert_eq!(culled(&spheres(), &PlanOptions::default()), None, "all in the view");
    let mut scene = surrounded();
    scene.settings.integrator = Integrator::Cost;
    assert_eq!(culled(&scene, &PlanOptions::default()), None, "the cost of the accelerator itself is shown");
    scene.settings.integrator = Integrator::Whitted;
    for accel in Accel::ALL {
        scene.settings.accel = accel;
        assert!(culled(&scene, &PlanOptions::default()).is_some(), "{accel:?}");
    }
    scene.nodes.truncate(8);
    assert_eq!(culled(&scene, &PlanOptions::default()), None, "few objects");
}

#[test]
fn predicted_memory_includes_the_second_accelerator() {
    let scene = surrounded();
    let accelerators = |integrator| {
        let mut scene = scene.clone();
        scene.settings.integrator = integrator;
        compile(&scene).memory().accelerators
    };
    let (with, without) = (accelerators(Integrator::Normals), accelerators(Integrator::Cost));
    assert!(without < with && with <= without + without / 2, "{with} after {without}");
}

/// Scene with tiles that show no sphere, a few spheres, and many.
fn scattered() -> Scene {
    let mut scene = surrounded();
    scene.nodes = (0..40u32)
        .map(|i| {
            let (x, y) = (f64::from(i % 8), f64::from(i / 8));
            node(sphere(-1.0 + 0.1 * x, 0.2 + 0.05 * y * y, -y, 0.12), 0)
        })
        .collect();
    (scene.film.width, scene.film.height) = (96, 64);
    scene
}

#[test]
fn culling_by_tile_keeps_the_image_and_traces_fewer_rays() {
    let mut scene = scattered();
    let gradient = Background::Gradient { bottom: Rgb::gray(0.1), top: Rgb::gray(0.9) };
    for background in [Background::Constant(Rgb::new(0.1, 0.2, 0.7)), gradient] {
        scene.appearance.background = background.clone();
        for filter in [Filter::Box, Filter::Gaussian { sigma: 2.0 }, Filter::Mitchell] {
            scene.film.filter = filter;
            for transparent in [false, true] {
                let options = PlanOptions { transparent, ..PlanOptions::default() };
                let (narrowed, work) = render(&scene, options);
                let (full, full_work) = render(&scene, PlanOptions { full: true, ..options });
                assert_eq!(narrowed.checksum(), full.checksum(), "{background:?}, {filter:?}, {transparent}");
                let rays = |work: &Statistics| RayKind::ALL.map(|kind| work.counters.of(kind).rays);
                let [traced, others @ ..] = rays(&work);
                let [camera, full_others @ ..] = rays(&full_work);
                assert_eq!((traced + work.primary_rays_skipped, others), (camera, full_others));
                assert_eq!(full_work.primary_rays_skipped, 0);
                assert!(2 * work.primary_rays_skipped > camera, "most tiles are empty: {work:?}");
                let nodes = |work: &Statistics| work.counters.of(RayKind::Primary).nodes;
                assert!(2 * nodes(&work) < nodes(&full_work), "most tiles traverse no tree");
            }
        }
    }
}

#[test]
fn invalid_background_radiance_is_counted_in_empty_tiles() {
    let mut scene = scattered();
    scene.nodes.truncate(1);
    scene.appearance.background = Background::Constant(Rgb::new(f64::NAN, 0.0, 0.0));
    let (film, work) = render(&scene, PlanOptions::default());
    let (full, full_work) = render(&scene, full());
    assert_eq!((film.checksum(), work.bad_samples), (full.checksum(), full_work.bad_samples));
    assert!(work.bad_samples > work.samples / 2);
}

#[test]
fn a_requested_accelerator_traces_all_camera_rays() {
    let mut scene = scattered();
    scene.settings.accel = Accel::Linear;
    let (_, work) = render(&scene, PlanOptions::default());
    let primary = work.counters.of(RayKind::Primary);
    assert_eq!(primary.tests, primary.rays * scene.nodes.len() as u64);
}
