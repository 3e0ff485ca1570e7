//! Layers of the first surfaces that camera rays hit.

use std::collections::BTreeSet;

use rt_accel::wide::SimdLevel;
use rt_camera::{CameraSettings, FovAxis, Lens, Projection, SamplerKind};
use rt_geometry::{MeshData, Rectangle, Shape};
use rt_math::{DVec3, Rgb, Transform, Vec3};
use rt_render::{
    Crop, FAR_DEPTH, FirstHitLayer, LayerValues, PlanOptions, RenderPlan, Rendering, RunOptions, StopRule,
};
use rt_scene_io::{Accel, AdaptiveSampling, Content, Group, GroupId, Integrator, MeshId, Scene};
use rt_shading::{ColorTexture, Material, MaterialModel, light::EmissionSides};

use crate::support::{
    compile, compile_with, cuboid, everything, full, interrupted, mesh, node, node_at, sphere, spheres,
};

fn all(plan: &RenderPlan<'_>, threads: usize) -> Vec<LayerValues> {
    plan.first_hit_layers(FirstHitLayer::ALL, plan.samples_per_pixel(), threads).expect("threads")
}

fn values(layers: &[LayerValues], layer: FirstHitLayer, pixel: usize) -> Vec<f32> {
    let found = layers.iter().find(|values| values.layer == layer).expect("it was asked for");
    found.channels.iter().map(|channel| channel[pixel]).collect()
}

/// A red sphere of radius 1 around the origin, seen from (0, 0, 5) by an image of 9 by 9 pixels.
fn one_sphere() -> Scene {
    let mut scene = spheres();
    let mut material = Material::new("red".to_owned(), MaterialModel::Diffuse { albedo: red(), roughness: 0.0 });
    material.emission = ColorTexture::Constant(Rgb::new(0.0, 2.0, 0.0));
    scene.appearance.materials = vec![material];
    scene.nodes = vec![node(sphere(0.0, 0.0, 0.0, 1.0), 0)];
    scene.groups.clear();
    let projection = Projection::Perspective { fov: 0.7, axis: FovAxis::Vertical };
    scene.cameras[0].settings = CameraSettings::new(Transform::translate(DVec3::Z * 5.0), projection);
    (scene.film.width, scene.film.height) = (9, 9);
    scene.settings.spp = 1;
    scene
}

fn red() -> ColorTexture {
    ColorTexture::Constant(Rgb::new(0.75, 0.25, 0.0))
}

#[test]
fn the_middle_of_a_sphere_has_known_values() {
    let mut scene = one_sphere();
    scene.settings.pattern = SamplerKind::Centre;
    let layers = all(&compile(&scene), 1);
    let middle = |layer| values(&layers, layer, 4 * 9 + 4);
    assert_eq!(middle(FirstHitLayer::Depth), [4.0]);
    assert_eq!(middle(FirstHitLayer::Position), [0.0, 0.0, 1.0]);
    assert_eq!(middle(FirstHitLayer::Normal), [0.0, 0.0, 1.0]);
    assert_eq!(middle(FirstHitLayer::GeometricNormal), [0.0, 0.0, 1.0]);
    assert_eq!(middle(FirstHitLayer::Albedo), [0.75, 0.25, 0.0]);
    assert_eq!(middle(FirstHitLayer::Roughness), [1.0]);
    assert_eq!(middle(FirstHitLayer::Emission), [0.0, 2.0, 0.0]);
    assert_eq!(middle(FirstHitLayer::ObjectId), [1.0]);
    assert_eq!(middle(FirstHitLayer::MaterialId), [1.0]);
    assert_eq!(middle(FirstHitLayer::Coverage), [1.0]);
    for &layer in FirstHitLayer::ALL {
        let corner = values(&layers, layer, 0);
        let expected = if layer == FirstHitLayer::Depth { FAR_DEPTH } else { 0.0 };
        assert!(corner.iter().all(|&value| value == expected), "{layer:?} of nothing: {corner:?}");
    }
}

/// A camera inside of the sphere sees the back of its surface.
#[test]
fn normals_are_of_the_side_that_is_seen() {
    let mut scene = one_sphere();
    scene.settings.pattern = SamplerKind::Centre;
    scene.cameras[0].settings.world_from_camera = Transform::IDENTITY;
    let layers = all(&compile(&scene), 1);
    for layer in [FirstHitLayer::Normal, FirstHitLayer::GeometricNormal] {
        assert_eq!(values(&layers, layer, 4 * 9 + 4), [0.0, 0.0, 1.0], "{layer:?}");
    }
    assert_eq!(values(&layers, FirstHitLayer::Position, 4 * 9 + 4), [0.0, 0.0, -1.0]);
}

#[test]
fn coverage_is_partial_at_the_silhouette_only() {
    let mut scene = one_sphere();
    scene.settings.spp = 16;
    let layers = all(&compile(&scene), 1);
    let coverage: Vec<f32> = (0..81).map(|pixel| values(&layers, FirstHitLayer::Coverage, pixel)[0]).collect();
    let partial = coverage.iter().filter(|&&spec| spec > 0.0 && spec < 1.0).count();
    let covered = coverage.iter().filter(|&&spec| spec == 1.0).count();
    assert!(partial >= 8 && covered >= 4, "{coverage:?}");
    for pixel in (0..81).filter(|&pixel| coverage[pixel] > 0.0) {
        let normal = DVec3::from_slice(
            &values(&layers, FirstHitLayer::Normal, pixel).iter().map(|&c| f64::from(c)).collect::<Vec<_>>(),
        );
        assert!((normal.length() - 1.0).abs() < 1e-6 && normal.z > 0.0, "{normal}");
    }
}

#[test]
fn layers_do_not_depend_on_threads_accelerator_trimming_or_crop() {
    let mut scene = everything();
    (scene.film.width, scene.film.height) = (32, 24);
    scene.settings.spp = 4;
    let plan = compile(&scene);
    let expected = all(&plan, 1);
    for threads in [2, 3] {
        assert_eq!(all(&plan, threads), expected, "{threads} threads");
    }
    let mut other = scene.clone();
    for accel in [Accel::Linear, Accel::Bvh, Accel::Kd] {
        other.settings.accel = accel;
        assert_eq!(all(&compile(&other), 2), expected, "{accel:?}");
    }
    let portable = PlanOptions { simd: Some(SimdLevel::Portable), ..PlanOptions::default() };
    assert_eq!(all(&compile_with(&scene, portable), 2), expected, "one hit at a time");
    // Here all surfaces are computed one by one, without lanes.
    for (values, of_full) in expected.iter().zip(all(&compile_with(&scene, full()), 2)) {
        // A full plan keeps the coordinates of surfaces without textures.
        assert!(values.layer == FirstHitLayer::Uv || *values == of_full, "{:?}", values.layer);
    }
    let crop = Crop { x: 5, y: 7, width: 9, height: 4 };
    let cropped = compile_with(&scene, PlanOptions { crop: Some(crop), ..PlanOptions::default() });
    for (whole, shard) in expected.iter().zip(all(&cropped, 2)) {
        for (whole, shard) in whole.channels.iter().zip(shard.channels) {
            let rows = (0..4).flat_map(|y| &whole[(7 + y) * 32 + 5..][..9]);
            assert!(rows.eq(&shard), "{crop:?}");
        }
    }
}

#[test]
fn instances_have_the_same_numbers_in_trimmed_and_full_plans() {
    let mut boxed = one_sphere();
    boxed.nodes.push(node(cuboid([-1.0, -3.0, -1.0], [1.0, -1.5, 1.0]), 0));
    for scene in [spheres(), boxed] {
        let ids = [false, true].map(|full| {
            let plan = compile_with(&scene, PlanOptions { full, ..PlanOptions::default() });
            plan.first_hit_layers(&[FirstHitLayer::InstanceId], 4, 1).expect("threads")
        });
        assert_eq!(ids[0], ids[1]);
        assert!(ids[0][0].channels[0].iter().any(|&id| id > 1.0), "one number only");
    }
}

/// A sheet of `2 n²` triangles, a sphere, and two instances of a group of a sphere and a box.
fn objects_of_all_kinds(n: u32) -> Scene {
    let mut data = MeshData::default();
    for (x, y) in (0..=n).flat_map(|y| (0..=n).map(move |x| (x, y))) {
        let [x, y] = [x, y].map(|at| 8.0 * at as f32 / n as f32 - 4.0);
        data.positions.push(Vec3::new(x, y, -2.0));
    }
    for (x, y) in (0..n).flat_map(|y| (0..n).map(move |x| (x, y))) {
        let corner = y * (n + 1) + x;
        data.triangles.extend([[corner, corner + 1, corner + n + 2], [corner, corner + n + 2, corner + n + 1]]);
    }
    let group = vec![node(sphere(0.0, 0.5, 0.0, 0.3), 0), node(cuboid([-0.3; 3], [0.3; 3]), 0)];
    let instance = |x| node_at(Content::Instance(GroupId(0)), 0, Transform::translate(DVec3::X * x));
    let mut scene = one_sphere();
    (scene.film.width, scene.film.height) = (48, 48);
    scene.meshes = vec![mesh("sheet", data)];
    scene.groups = vec![Group { name: "pair".to_owned(), nodes: group }];
    scene.nodes =
        vec![node(Content::Mesh(MeshId(0)), 0), instance(-0.8), instance(0.8), node(sphere(0.0, -0.8, 0.0, 0.3), 0)];
    scene
}

/// Triangles of a mesh of at most 64 are inlined.
#[test]
fn numbers_of_objects_do_not_depend_on_inlining() {
    let ids = [5, 6].map(|n| {
        let scene = objects_of_all_kinds(n);
        let plan = compile(&scene);
        let of = [FirstHitLayer::ObjectId, FirstHitLayer::InstanceId];
        let layers = plan.first_hit_layers(&of, 1, 1).expect("threads");
        let pixels = layers[0].channels[0].iter().zip(&layers[1].channels[0]);
        pixels.map(|(&object, &instance)| (object as u32, instance as u32)).collect::<Vec<_>>()
    });
    assert!(ids[0] == ids[1]);
    let numbers: BTreeSet<_> = ids[0].iter().copied().filter(|&ids| ids != (0, 0)).collect();
    assert_eq!(numbers, BTreeSet::from([(1, 1), (2, 2), (3, 2), (2, 3), (3, 3), (4, 4)]));
}

#[test]
fn depth_is_in_world_units_if_the_camera_is_scaled() {
    for size in [0.5, 1.0, 2.0] {
        let mut scene = one_sphere();
        scene.settings.pattern = SamplerKind::Centre;
        let scale = Transform::scale(DVec3::splat(size)).expect("a scale");
        scene.cameras[0].settings.world_from_camera = Transform::translate(DVec3::Z * 5.0).compose(&scale);
        assert_eq!(values(&all(&compile(&scene), 1), FirstHitLayer::Depth, 4 * 9 + 4), [4.0], "scaled by {size}");
    }
}

#[test]
fn the_back_of_an_emitter_that_emits_from_its_front_emits_nothing() {
    let mut scene = one_sphere();
    let rectangle = Rectangle::new(2.0, 2.0).expect("a rectangle");
    scene.nodes[0].content = Some(Content::Shape(Shape::Rectangle(rectangle)));
    scene.appearance.materials[0].emission_sides = EmissionSides::Front;
    let emission = |y: f64| {
        let mut scene = scene.clone();
        let turn = Transform::from_rows([
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, y, 5.0 * y],
            [0.0, -y, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]);
        scene.cameras[0].settings.world_from_camera = turn.expect("a rotation");
        let layers = all(&compile(&scene), 1);
        assert_eq!(values(&layers, FirstHitLayer::Coverage, 4 * 9 + 4), [1.0]);
        values(&layers, FirstHitLayer::Emission, 4 * 9 + 4)[1]
    };
    let (above, below) = (emission(1.0), emission(-1.0));
    assert!((above, below) == (2.0, 0.0) || (above, below) == (0.0, 2.0), "{above} and {below}");
}

#[test]
fn integrators_share_the_layers() {
    let mut scene = spheres();
    (scene.film.width, scene.film.height) = (24, 16);
    scene.settings.passes = Some(2);
    let mut of = |integrator| {
        scene.settings.integrator = integrator;
        all(&compile(&scene), 2)
    };
    let expected = of(Integrator::Whitted);
    for integrator in [Integrator::Path, Integrator::Depth, Integrator::AmbientOcclusion] {
        assert!(of(integrator) == expected, "{integrator:?}");
    }
}

/// Scenes with all integrators, with more and with fewer samples than layers take, also in several passes.
fn scenes_of_all_kinds() -> Vec<Scene> {
    let mut scenes = Vec::new();
    for integrator in Integrator::ALL {
        for spp in [4, 25] {
            let mut scene = everything();
            (scene.film.width, scene.film.height) = (41, 24);
            (scene.settings.integrator, scene.settings.spp) = (integrator, spp);
            scenes.push(scene);
        }
    }
    let mut adaptive = spheres();
    adaptive.settings.spp = 25;
    adaptive.settings.adaptive = Some(AdaptiveSampling::ObjectSpace { min_spp: Some(4) });
    let mut with_lens = everything();
    (with_lens.film.width, with_lens.film.height) = (41, 24);
    with_lens.cameras[0].settings.lens = Some(Lens { radius: 0.2, focus: 9.0, blades: None, rotation: 0.0 });
    // Most tiles are empty, or see few objects.
    let mut small = one_sphere();
    (small.film.width, small.film.height, small.settings.spp) = (70, 70, 9);
    let mut empty = small.clone();
    empty.cameras[0].settings.world_from_camera = Transform::translate(DVec3::Z * -5.0);
    // The depth of a sample depends on its time.
    let mut turning = spheres();
    let camera = &mut turning.cameras[0].settings;
    let turn = Transform::rotate(DVec3::Y, 0.2).expect("an angle");
    (camera.moves_to, camera.shutter) = (Some(camera.world_from_camera.compose(&turn)), [0.0, 1.0]);
    scenes.extend([adaptive, with_lens, small, empty, turning]);
    scenes
}

#[test]
fn layers_of_the_image_are_those_of_rays_of_their_own() {
    for scene in scenes_of_all_kinds() {
        let plan = compile(&scene);
        let what = format!("{:?} with {} samples", scene.settings.integrator, scene.settings.spp);
        let expected = all(&plan, 1);
        let run = RunOptions { threads: 2, layers: FirstHitLayer::ALL, ..RunOptions::default() };
        let mut rendering = plan.render(&run, |_| {}).expect("it renders");
        let is_complete = scene.settings.integrator != Integrator::Caustics;
        let before = rendering.layers.clone().expect("layers were asked for");
        assert_eq!(before.values() == expected, is_complete, "{what}");
        plan.complete_layers(&mut rendering, 2).expect("threads");
        assert!(rendering.layers.is_some_and(|layers| layers.values() == expected), "{what}, completed");
        let without = plan.render(&RunOptions::default(), |_| {}).expect("it renders");
        assert!(without.layers.is_none() && without.film == rendering.film, "{what}");
    }
}

#[test]
fn layers_of_resumed_renders_are_those_of_whole_ones() {
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let mut scene = everything();
        (scene.settings.integrator, scene.settings.spp) = (integrator, 9);
        let plan = compile(&scene);
        let run = RunOptions { threads: 1, layers: FirstHitLayer::ALL, ..RunOptions::default() };
        let (checkpoint, mut rendering) = interrupted(&plan, None, None, run, [2, 2]);
        let expected = all(&plan, 1);
        let of = |rendering: &Rendering| rendering.layers.clone().expect("layers were asked for");
        assert!(of(&rendering).values() != expected, "{integrator:?} was not interrupted");
        plan.complete_layers(&mut rendering, 1).expect("threads");
        // The layers of unfinished tiles were computed as well, which takes long.
        let depth = |layers: &[LayerValues]| {
            let depth = layers.iter().find(|values| values.layer == FirstHitLayer::Depth).expect("all layers");
            depth.channels[0].clone()
        };
        let (some, all) = (depth(&of(&rendering).values()), depth(&expected));
        assert!(some.iter().zip(&all).all(|(some, all)| *some == 0.0 || some == all), "{integrator:?}");
        let count = some.iter().filter(|depth| **depth != 0.0).count();
        assert!(0 < count && count < all.len(), "{integrator:?}: {count} of {}", all.len());
        let checkpoint = postcard::from_bytes(&checkpoint).expect("read");
        let resumed = plan.render_shard(&run, None, Some(checkpoint), |_| {}).expect("it renders");
        let mut rendering = resumed.into_rendering();
        assert!(of(&rendering).values() != expected, "{integrator:?} was not resumed");
        plan.complete_layers(&mut rendering, 1).expect("threads");
        assert!(of(&rendering).values() == expected, "{integrator:?}, resumed");
    }
}

#[test]
fn layers_of_a_stop_rule_take_the_largest_number_of_its_samples() {
    let mut scene = one_sphere();
    scene.settings.spp = 1;
    let plan = compile(&scene);
    let run = RunOptions { threads: 1, layers: FirstHitLayer::ALL, ..RunOptions::default() };
    let rule = StopRule { max_spp: 8, ..StopRule::default() };
    let mut rendering = plan.render_until(&run, &rule, |_| {}).expect("it renders");
    plan.complete_layers(&mut rendering, 1).expect("threads");
    let spp = rendering.samples_per_pixel.max;
    let expected = plan.first_hit_layers(FirstHitLayer::ALL, spp, 1).expect("threads");
    assert!(rendering.layers.is_some_and(|layers| layers.values() == expected));
    assert!(all(&plan, 1) != expected, "they have the one sample of the scene");
}

#[test]
fn positions_of_scenes_far_from_the_origin_are_in_world_space() {
    let mut scene = one_sphere();
    let far = DVec3::new(3e6, 0.0, 0.0);
    scene.nodes[0].parent_from_local = Transform::translate(far);
    scene.cameras[0].settings.world_from_camera = Transform::translate(far + DVec3::Z * 5.0);
    let plan = compile(&scene);
    let layers = plan.first_hit_layers(&[FirstHitLayer::Position], 1, 1).expect("threads");
    let [x, y, z] = values(&layers, FirstHitLayer::Position, 4 * 9 + 4)[..] else { panic!("three channels") };
    assert!((x - 3e6).abs() <= 0.5 && y.abs() < 0.5 && (z - 1.0).abs() < 0.1, "{x} {y} {z}");
}

#[test]
fn asking_for_layers_leaves_the_image_alone() {
    let scene = one_sphere();
    let plan = compile(&scene);
    let before = plan.render(&RunOptions::default(), |_| {}).expect("it renders");
    all(&plan, 2);
    assert_eq!(plan.render(&RunOptions::default(), |_| {}).expect("it renders").film, before.film);
    assert_eq!(plan.first_hit_layers(&[], 1, 1).expect("threads"), []);
}
