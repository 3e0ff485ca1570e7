//! Plans that look through another camera than they were compiled with.

use crate::support::{everything, spheres};
use rt_camera::{CameraSettings, FovAxis, Lens, Projection};
use rt_image::Image;
use rt_math::{DVec3, Transform};
use rt_render::{Crop, PlanOptions, RenderError, RenderPlan, RunOptions};
use rt_scene_io::{Accel, Integrator, Scene};

const PLAIN: PlanOptions = PlanOptions {
    camera: 0,
    crop: None,
    transparent: false,
    backdrop: None,
    full: false,
    simd: None,
    quality: rt_render::Quality::Medium,
    memory: None,
    progressive: false,
};

fn picture(plan: &RenderPlan<'_>) -> Image {
    plan.render(&RunOptions::default(), |_| {}).expect("threads start").film
}

fn compile<'s>(scene: &'s Scene, options: &PlanOptions) -> RenderPlan<'s> {
    RenderPlan::compile(scene, options).expect("the scene compiles")
}

fn looking(eye: [f64; 3], target: [f64; 3]) -> CameraSettings {
    let place = Transform::look_at(eye.into(), target.into(), DVec3::Y).expect("a view");
    CameraSettings::new(place, Projection::Perspective { fov: 0.9, axis: FovAxis::Horizontal })
}

/// Cameras from which different things are seen, left out and around the eye.
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

/// The picture through each camera is that of a plan compiled with it, whatever the plan looked at before.
fn assert_same_pictures(mut scene: Scene, options: &PlanOptions) {
    let first = scene.clone();
    let mut plan = compile(&first, options);
    for (index, camera) in cameras().into_iter().enumerate() {
        let [width, height] = [[37, 29], [64, 16]][index % 2];
        plan.look_through(&camera, [width, height]).expect("a sound camera");
        (scene.film.width, scene.film.height) = (width, height);
        scene.cameras[0].settings = camera;
        let compiled = compile(&scene, options);
        let context = format!("camera {index}, {:?}", scene.settings.integrator);
        assert_eq!(plan.samples_per_pixel(), compiled.samples_per_pixel(), "{context}");
        assert_eq!(plan.explain().used, compiled.explain().used, "{context}");
        assert_eq!(picture(&plan), picture(&compiled), "{context}");
    }
}

#[test]
fn another_camera_is_as_if_it_had_been_there_from_the_beginning() {
    for integrator in Integrator::ALL {
        let mut scene = everything();
        scene.settings.integrator = integrator;
        scene.settings.spp = 2;
        assert_same_pictures(scene, &PLAIN);
    }
    assert_same_pictures(spheres(), &PLAIN);
    assert_same_pictures(everything(), &PlanOptions { full: true, transparent: true, ..PLAIN });
}

#[test]
fn in_a_scene_far_from_the_origin_as_well() {
    let far = DVec3::new(3e6, -2e6, 1e6);
    let mut scene = spheres();
    for node in &mut scene.nodes {
        node.parent_from_local = Transform::translate(far);
    }
    let camera = |offset: f64| {
        let place = Transform::look_at(far + DVec3::new(offset, 0.0, 9.0), far, DVec3::Y).expect("a view");
        CameraSettings::new(place, Projection::Perspective { fov: 0.5, axis: FovAxis::Vertical })
    };
    scene.cameras[0].settings = camera(0.0);
    let first = scene.clone();
    let mut plan = compile(&first, &PLAIN);
    // The last is so far away that the scene is not small beside its distance from the origin any more.
    for offset in [0.5, 7.0, 3e5] {
        plan.look_through(&camera(offset), [61, 43]).expect("a sound camera");
        scene.cameras[0].settings = camera(offset);
        assert_eq!(picture(&plan), picture(&compile(&scene, &PLAIN)), "{offset}");
    }
}

#[test]
fn structures_are_not_built_again() {
    let mut scene = spheres();
    scene.settings.accel = Accel::BihLazy;
    let mut plan = compile(&scene, &PLAIN);
    let build_seconds = plan.build_seconds();
    plan.look_through(&cameras()[0], [20, 20]).expect("a sound camera");
    assert_eq!(plan.build_seconds().to_bits(), build_seconds.to_bits());
}

#[test]
fn the_whole_image_is_looked_at() {
    let scene = everything();
    let crop = Some(Crop { x: 5, y: 6, width: 7, height: 8 });
    let mut plan = compile(&scene, &PlanOptions { crop, ..PLAIN });
    plan.look_through(&scene.cameras[0].settings, [61, 43]).expect("a sound camera");
    assert_eq!(picture(&plan), picture(&compile(&scene, &PLAIN)));
}

#[test]
fn a_refused_camera_leaves_the_plan_as_it_was() {
    let scene = everything();
    let mut plan = compile(&scene, &PLAIN);
    let before = picture(&plan);
    let blind =
        CameraSettings { projection: Projection::Orthographic { height: 0.0 }, ..looking([0.0, 0.0, 5.0], [0.0; 3]) };
    assert!(matches!(plan.look_through(&blind, [8, 8]), Err(RenderError::Camera { .. })));
    assert!(matches!(plan.look_through(&cameras()[0], [0, 8]), Err(RenderError::Film(_))));
    assert_eq!(picture(&plan), before);
}
