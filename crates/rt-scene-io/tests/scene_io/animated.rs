//! Scene files at moments of an animation, against closed forms.

use std::path::Path;

use rt_camera::{CameraSettings, Projection};
use rt_math::{AnimatedTransform, DVec3, Transform};
use rt_scene_io::format::{SceneFile, parse_json, parse_ron};
use rt_scene_io::{LoadOptions, Scene, SceneNode, convert, load, resolve};

fn parse(text: &str) -> SceneFile {
    parse_ron(text, Path::new("scene.ron")).unwrap()
}

fn posed(text: &str, options: &LoadOptions) -> Scene {
    resolve(&parse(text), Path::new("folder/test.ron"), options).unwrap()
}

fn at(text: &str, time: f64) -> Scene {
    posed(text, &LoadOptions { at_time: Some(time), ..LoadOptions::default() })
}

fn place(scene: &Scene) -> Transform {
    scene.nodes[0].parent_from_local
}

fn camera(scene: &Scene) -> &CameraSettings {
    &scene.cameras[0].settings
}

fn about_y(degrees: f64) -> Transform {
    Transform::rotate(DVec3::Y, degrees.to_radians()).unwrap()
}

fn close(a: &Transform, b: &Transform) -> bool {
    [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].iter().all(|p| (a.point(*p) - b.point(*p)).length() < 1e-13)
}

/// A sphere of twice the size, one unit out, which turns by 120° in the first second and flies up in the two after it.
const SPHERE: &str = "(
    nodes: [(shape: sphere(), transform: [scale(2), translate(1, 0, 0)], animation: (keys: [
        (time: 1, transform: []),
        (time: 2, transform: [rotate_y(120)]),
        (time: 4, transform: [rotate_y(120), translate(0, 8, 0)]),
    ]))],
)";

#[test]
fn nodes_go_straight_from_key_to_key_and_keep_their_own_transform() {
    let rest = Transform::translate(DVec3::X).compose(&Transform::scale(DVec3::splat(2.0)).unwrap());
    let up = |height: f64| Transform::translate(DVec3::Y * height);
    for (time, expected) in [
        (-5.0, rest),
        (1.0, rest),
        (1.5, about_y(60.0).compose(&rest)),
        (1.25, about_y(30.0).compose(&rest)),
        (2.0, about_y(120.0).compose(&rest)),
        (2.5, up(2.0).compose(&about_y(120.0)).compose(&rest)),
        (4.0, up(8.0).compose(&about_y(120.0)).compose(&rest)),
        (99.0, up(8.0).compose(&about_y(120.0)).compose(&rest)),
    ] {
        let scene = at(SPHERE, time);
        assert!(close(&place(&scene), &expected), "{time}: {:?}", place(&scene));
        assert_eq!(scene.nodes[0].moves_to, None, "no camera has a shutter");
    }
}

#[test]
fn without_a_time_an_animation_is_as_at_its_beginning() {
    let scene = posed(SPHERE, &LoadOptions::default());
    assert_eq!(place(&scene), place(&at(SPHERE, 0.0)));
    assert!(scene.notes.contains(&"The scene is animated: it is shown at 0 s.".to_owned()));
    assert!(at(SPHERE, 0.0).notes.iter().all(|note| !note.contains("animated")));
}

#[test]
fn steps_hold_and_smooth_ways_start_at_rest() {
    let with = |interpolation: &str| SPHERE.replace("(keys:", &format!("(interpolation: {interpolation}, keys:"));
    assert_eq!(place(&at(&with("step"), 1.999)), place(&at(SPHERE, 1.0)));
    // The velocities at the ends are 0 and at the middle key, two thirds of 120°/s and a third of none: 80°/s. So
    // Hermite's cubic has at its half 60° less an eighth of 80°.
    let turned = place(&at(&with("smooth"), 1.5));
    let rest = place(&at(SPHERE, 1.0));
    assert!((turned.linear().y_axis - DVec3::Y * 2.0).length() < 1e-13);
    let angle = rt_math::transcendental::atan2(-turned.linear().x_axis.z, turned.linear().x_axis.x).to_degrees();
    assert!((angle - 50.0).abs() < 1e-9, "{angle}");
    assert_eq!(place(&at(&with("smooth"), 0.5)), rest);
}

#[test]
fn blur_leads_from_the_pose_at_which_the_shutter_opens_to_that_at_which_it_closes() {
    let text = SPHERE.replace("nodes:", "camera: (look_from: (0, 0, 9), shutter: (0.25, 0.75)), nodes:");
    let options = |time| LoadOptions { at_time: Some(time), frame_time: Some(0.5), ..LoadOptions::default() };
    let scene = posed(&text, &options(1.5));
    assert_eq!(place(&scene), place(&at(SPHERE, 1.625)));
    assert_eq!(scene.nodes[0].moves_to, Some(place(&at(SPHERE, 1.875))));
    assert_eq!(camera(&scene).shutter, [0.0, 1.0], "all of the way is seen");
    // What does not move meanwhile, stands.
    assert_eq!(posed(&text, &options(9.0)).nodes[0].moves_to, None);
    // A frame is a 24th of a second by default.
    assert_eq!(at(&text, 1.5).nodes[0].moves_to, Some(place(&at(SPHERE, 1.5 + 0.75 * (1.0 / 24.0)))));
    // The caller may say how long the shutter is open.
    let scene = posed(SPHERE, &LoadOptions { shutter: Some([0.0, 1.0]), ..options(1.0) });
    assert_eq!((place(&scene), scene.nodes[0].moves_to), (place(&at(SPHERE, 1.0)), Some(place(&at(SPHERE, 1.5)))));
}

/// The next key was the end of a motion, and the object was smeared on the line to it.
#[test]
fn steps_hold_their_pose_while_the_shutter_is_open() {
    let text = SPHERE.replace("(keys:", "(interpolation: step, keys:");
    let camera = "camera: (look_at: (0, 0, 0), shutter: (0, 1), animation: (interpolation: step, keys: [
        (time: 0, look_from: (0, 0, 9)), (time: 2, look_from: (0, 0, 5)),
    ])), nodes:";
    let text = text.replace("nodes:", camera);
    for (time, key) in [(1.0, 1.0), (1.5, 1.0), (2.0, 2.0)] {
        let options = LoadOptions { at_time: Some(time), frame_time: Some(1.0), ..LoadOptions::default() };
        let scene = posed(&text, &options);
        assert_eq!((place(&scene), scene.nodes[0].moves_to), (place(&at(SPHERE, key)), None), "{time}");
        let eye = if time < 2.0 { 9.0 } else { 5.0 };
        let settings = self::camera(&scene);
        assert_eq!((settings.world_from_camera.translation(), settings.moves_to), (DVec3::Z * eye, None), "{time}");
    }
}

#[test]
fn motions_next_to_an_animation_are_seen_for_as_long() {
    let text = "(
        camera: (look_from: (0, 0, 9), shutter: (0.25, 0.5)),
        cameras: [(name: \"other\", look_from: (0, 0, 9), shutter: (0.5, 0.75)), (name: \"sharp\", look_from: (0, 0, 9))],
        nodes: [(shape: sphere(), motion: [translate(8, 0, 0), rotate_y(80)]), (animation: (keys: [(time: 0)]))],
    )";
    let scene = posed(text, &LoadOptions::default());
    let shutters: Vec<_> = scene.cameras.iter().map(|camera| camera.settings.shutter).collect();
    assert_eq!(shutters, [[0.0, 0.5], [0.5, 1.0], [0.0, 0.0]]);
    let end = about_y(80.0).compose(&Transform::translate(DVec3::X * 8.0));
    let whole = AnimatedTransform::new(&Transform::IDENTITY, &end).unwrap();
    let node = &scene.nodes[0];
    assert_eq!((node.parent_from_local, node.moves_to), (whole.at(0.25), Some(whole.at(0.75))));
    // At the same moments, the part goes the same way as the whole.
    let part = node.motion().unwrap().unwrap();
    for s in [0.0, 0.25, 0.5, 1.0] {
        assert!(close(&part.at(s), &whole.at(0.25 + 0.5 * s)), "{s}");
    }
    // Without an animation nothing is cut.
    let still = posed(&text.replace(", (animation: (keys: [(time: 0)]))", ""), &LoadOptions::default());
    assert_eq!((still.nodes[0].moves_to, still.cameras[0].settings.shutter), (Some(end), [0.25, 0.5]));
}

#[test]
fn cameras_look_from_key_to_key() {
    let text = "(
        camera: (look_at: (0, 1, 0), fov: 20, animation: (keys: [
            (time: 0, look_from: (0, 1, 4)),
            (time: 2, look_from: (0, 1, 8), fov: 60),
            (time: 4, look_from: (4, 1, 8), look_at: (4, 1, 0)),
        ])),
        nodes: [],
    )";
    let seen = |time: f64| {
        let scene = at(text, time);
        let CameraSettings { world_from_camera, projection, .. } = *camera(&scene);
        let Projection::Perspective { fov, .. } = projection else { panic!("{projection:?}") };
        (world_from_camera, fov.to_degrees())
    };
    let look = |from: [f64; 3], at: [f64; 3]| Transform::look_at(from.into(), at.into(), DVec3::Y).unwrap();
    for (time, place, fov) in [
        (-1.0, look([0.0, 1.0, 4.0], [0.0, 1.0, 0.0]), 20.0),
        (1.0, look([0.0, 1.0, 6.0], [0.0, 1.0, 0.0]), 40.0),
        (3.0, look([2.0, 1.0, 8.0], [2.0, 1.0, 0.0]), 40.0),
        (5.0, look([4.0, 1.0, 8.0], [4.0, 1.0, 0.0]), 20.0),
    ] {
        let (found, angle) = seen(time);
        assert!(close(&found, &place) && (angle - fov).abs() < 1e-12, "{time}: {found:?} {angle}");
    }
    // The lens is focused on what the camera looks at, wherever both are.
    let sharp = text.replace("fov: 20,", "fov: 20, lens: (radius: 0.1),");
    let focus = |time| camera(&at(&sharp, time)).lens.unwrap().focus;
    assert_eq!((focus(0.0), focus(1.0)), (4.0, 6.0));
}

#[test]
fn cameras_are_taken_around_by_steps() {
    let text = "(
        camera: (look_from: (0, 3, 4), lens: (radius: 0.1), shutter: (0, 1), animation: (keys: [
            (time: 0), (time: 1, transform: [rotate_y(120)]), (time: 2, transform: [rotate_y(240)]),
        ])),
        nodes: [],
    )";
    let options = LoadOptions { at_time: Some(0.25), frame_time: Some(0.5), ..LoadOptions::default() };
    let scene = posed(text, &options);
    let rest = Transform::look_at(DVec3::new(0.0, 3.0, 4.0), DVec3::ZERO, DVec3::Y).unwrap();
    let camera = camera(&scene);
    assert!(close(&camera.world_from_camera, &about_y(30.0).compose(&rest)));
    assert!(close(&camera.moves_to.unwrap(), &about_y(90.0).compose(&rest)));
    assert!((camera.lens.unwrap().focus - 5.0).abs() < 1e-15);
    // Keys alone place a camera as `transform` does.
    let alone = "(camera: (animation: (keys: [(time: 0, transform: [translate(0, 0, 7)])])), nodes: [])";
    assert_eq!(self::camera(&at(alone, 0.0)).world_from_camera, Transform::translate(DVec3::Z * 7.0));
}

#[test]
fn a_camera_without_a_place_does_not_shake() {
    let eye = |text: &str, time| camera(&at(text, time)).world_from_camera;
    assert_eq!(eye(SPHERE, 0.0), eye(SPHERE, 3.0));
    assert_eq!(eye(SPHERE, 0.0), camera(&posed(SPHERE, &LoadOptions::default())).world_from_camera);
    let zoom =
        SPHERE.replace("nodes:", "camera: (animation: (keys: [(time: 0, fov: 20), (time: 4, fov: 60)])), nodes:");
    assert_eq!(eye(&zoom, 0.0), eye(&zoom, 3.0));
}

#[test]
fn children_and_groups_are_posed_as_well() {
    let text = "(
        camera: (look_from: (0, 0, 9), shutter: (0, 1)),
        groups: {\"wheel\": [(shape: sphere(), animation: (keys: [(time: 0), (time: 1, transform: [translate(0, 6, 0)])]))]},
        nodes: [
            (animation: (keys: [(time: 0), (time: 1, transform: [translate(6, 0, 0)])]), children: [(instance: \"wheel\")]),
        ],
    )";
    let options = LoadOptions { at_time: Some(0.5), frame_time: Some(0.25), ..LoadOptions::default() };
    let scene = posed(text, &options);
    let way = |node: &SceneNode| [Some(node.parent_from_local), node.moves_to].map(|end| end.unwrap().translation());
    assert_eq!(way(&scene.nodes[0]), [DVec3::X * 3.0, DVec3::X * 4.5]);
    assert_eq!(way(&scene.groups[0].nodes[0]), [DVec3::Y * 3.0, DVec3::Y * 4.5]);
}

#[test]
fn an_animation_is_written_and_read_back() {
    let file = parse(SPHERE);
    assert_eq!(parse_ron(&file.to_ron(), Path::new("a.ron")).unwrap(), file);
    assert_eq!(parse_json(&file.to_json(), Path::new("a.json")).unwrap(), file);
    let folder = tempfile::tempdir().unwrap();
    let [from, to] = ["a.ron", "b.json"].map(|name| folder.path().join(name));
    std::fs::write(&from, SPHERE).unwrap();
    std::fs::write(&to, convert(&from, &to, &LoadOptions::default()).unwrap().text).unwrap();
    let options = LoadOptions { at_time: Some(1.75), ..LoadOptions::default() };
    assert_eq!(place(&load(&to, &options).unwrap()), place(&load(&from, &options).unwrap()));
}
