//! Plans whose camera is replaced after compilation.

use rt_camera::{CameraSettings, FovAxis, Lens, Projection};
use rt_image::Image;
use rt_math::{DVec3, Transform};
use rt_render::{Crop, PlanOptions, RenderError, RenderPlan, RunOptions};
use rt_scene_io::{Accel, Integrator, Scene};

use crate::support::{self, compile, compile_with, everything, film, full, spheres};

fn image(plan: &RenderPlan<'_>) -> Image {
    plan.render(&RunOptions::default(), |_| {}).expect("threads start").film
}

fn looking(eye: [f64; 3], target: [f64; 3]) -> CameraSettings {
    let place = Transform::look_at(eye.into(), target.into(), DVec3::Y).expect("a view");
    CameraSettings::new(place, Projection::Perspective { fov: 0.9, axis: FovAxis::Horizontal })
}

/// Cameras with different visible objects, culled objects and surrounding media.
fn cameras() -> Vec<CameraSettings> {
    let lens = Lens { radius: 0.2, focus: 3.0, blades: None, rotation: 0.0 };
    let aside = looking([3.0, 0.4, 1.0], [0.0, 0.0, 0.0]);
    vec![
        looking([-4.0, 1.0, 6.0], [-1.0, 0.0, 0.0]),
        looking([0.1, 0.2, 0.3], [5.0, 0.1, 0.0]),
        CameraSettings { lens: Some(lens), ..aside },
        CameraSettings { projection: Projection::Orthographic { height: 2.5 }, ..aside },
        CameraSettings { moves_to: Some(Transform::translate(DVec3::Z * 4.0)), ..looking([0.0, 0.0, 5.0], [0.0; 3]) },
        CameraSettings { shutter: [0.25, 0.25], ..aside },
    ]
}

/// The image of each camera is bit-identical to that of a plan compiled with it, for all previous cameras.
fn assert_same_images(mut scene: Scene, options: PlanOptions) {
    let first = scene.clone();
    let mut plan = compile_with(&first, options);
    for (index, camera) in cameras().into_iter().enumerate() {
        let [width, height] = [[37, 29], [64, 16]][index % 2];
        plan.set_camera(&camera, [width, height]).expect("a sound camera");
        (scene.film.width, scene.film.height) = (width, height);
        scene.cameras[0].settings = camera;
        let compiled = compile_with(&scene, options);
        let context = format!("camera {index}, {:?}", scene.settings.integrator);
        assert_eq!(plan.samples_per_pixel(), compiled.samples_per_pixel(), "{context}");
        assert_eq!(plan.explain().used, compiled.explain().used, "{context}");
        assert_eq!(image(&plan), image(&compiled), "{context}");
    }
}

#[test]
fn replacing_the_camera_equals_compiling_with_it() {
    for integrator in Integrator::ALL {
        let mut scene = everything();
        scene.settings.integrator = integrator;
        scene.settings.spp = 2;
        assert_same_images(scene, PlanOptions::default());
    }
    assert_same_images(spheres(), PlanOptions::default());
    assert_same_images(everything(), PlanOptions { transparent: true, ..full() });
}

#[test]
fn in_a_scene_far_from_the_origin_as_well() {
    let far = DVec3::new(3e6, -2e6, 1e6);
    let mut scene = spheres();
    for node in &mut scene.nodes {
        node.parent_from_local = Transform::translate(far);
    }
    let camera = |offset: f64| support::camera(far + DVec3::new(offset, 0.0, 9.0), far, DVec3::Y, 0.5);
    scene.cameras[0].settings = camera(0.0);
    let first = scene.clone();
    let mut plan = compile(&first);
    // The last camera is so far away that the scene needs no render space of its own.
    for offset in [0.5, 7.0, 3e5] {
        plan.set_camera(&camera(offset), [61, 43]).expect("a sound camera");
        scene.cameras[0].settings = camera(offset);
        assert_eq!(image(&plan), film(&scene), "{offset}");
    }
}

#[test]
fn accelerators_are_not_built_again() {
    let mut scene = spheres();
    scene.settings.accel = Accel::BihLazy;
    let mut plan = compile(&scene);
    let build_seconds = plan.build_seconds();
    plan.set_camera(&cameras()[0], [20, 20]).expect("a sound camera");
    assert_eq!(plan.build_seconds().to_bits(), build_seconds.to_bits());
}

#[test]
fn replacing_the_camera_drops_the_crop() {
    let scene = everything();
    let crop = Some(Crop { x: 5, y: 6, width: 7, height: 8 });
    let mut plan = compile_with(&scene, PlanOptions { crop, ..PlanOptions::default() });
    plan.set_camera(&scene.cameras[0].settings, [61, 43]).expect("a sound camera");
    assert_eq!(image(&plan), film(&scene));
}

#[test]
fn a_refused_camera_leaves_the_plan_as_it_was() {
    let scene = everything();
    let mut plan = compile(&scene);
    let before = image(&plan);
    let blind =
        CameraSettings { projection: Projection::Orthographic { height: 0.0 }, ..looking([0.0, 0.0, 5.0], [0.0; 3]) };
    assert!(matches!(plan.set_camera(&blind, [8, 8]), Err(RenderError::Camera { .. })));
    assert!(matches!(plan.set_camera(&cameras()[0], [0, 8]), Err(RenderError::Film(_))));
    assert_eq!(image(&plan), before);
}
