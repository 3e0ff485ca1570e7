use super::*;
use crate::finding::Measurement;
use crate::fixture::*;
use rt_geometry::{Cuboid, Rectangle, Triangle};
use rt_math::Transform;
use rt_scene_io::{Content, MaterialId, Scene, SceneNode};

fn solid(min: DVec3, max: DVec3, material: MaterialId) -> SceneNode {
    SceneNode::new(Content::Shape(Shape::Cuboid(Cuboid::new(min, max).unwrap())), material)
}

fn faces(count: f64, visible: f64) -> [Measurement; 2] {
    [value("faces", count), value("visible_faces", visible)]
}

fn scene_of(nodes: Vec<SceneNode>) -> Scene {
    Scene { nodes, cameras: vec![camera(DVec3::new(0.3, 2.0, 6.0), DVec3::ZERO)], ..empty() }
}

/// Node with a different material.
fn painted(node: SceneNode) -> SceneNode {
    SceneNode { material: CHECKER, ..node }
}

#[test]
fn a_flush_top_is_seen_and_a_bottom_on_the_floor_is_not() {
    let floor = floor(0.0);
    let standing = solid(DVec3::new(-0.5, 0.0, -0.5), DVec3::new(0.5, 1.0, 0.5), CHECKER);
    let scene = scene_of(vec![floor.clone(), standing.clone()]);
    assert_eq!(of_kind(&scene, Kind::CoincidentSurfaces), [], "the camera is above the floor");

    let sunk = SceneNode { parent_from_local: Transform::translate(DVec3::NEG_Y), ..standing };
    let scene = scene_of(vec![floor, sunk]);
    let finding = only(&scene, Kind::CoincidentSurfaces);
    assert_eq!((finding.object.as_str(), finding.values.as_slice()), ("nodes[0]", &faces(2.0, 2.0)[..]));
    assert_eq!(finding.severity, Severity::Warning);
    assert!(finding.message.contains("overlaps nodes[1]"), "{finding:?}");
}

#[test]
fn neighbours_touch_without_lying_in_each_other() {
    // Tops in one plane with a common edge, sides face to face.
    let left = solid(DVec3::ZERO, DVec3::ONE, GREY);
    let right = solid(DVec3::X, DVec3::new(2.0, 1.0, 1.0), CHECKER);
    assert_eq!(of_kind(&scene_of(vec![left.clone(), right]), Kind::CoincidentSurfaces), []);
    // Its top overlaps with that of its neighbour: of two triangles each, some three or four pairs.
    let lapping = solid(DVec3::new(0.5, -1.0, 0.25), DVec3::new(2.0, 1.0, 0.75), CHECKER);
    let finding = only(&scene_of(vec![left, lapping]), Kind::CoincidentSurfaces);
    assert!((1.0..=4.0).contains(&finding.values[1].value), "{finding:?}");
}

#[test]
fn two_sheets_are_seen_from_both_sides() {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Z];
    let sheet = SceneNode::new(Content::Shape(Shape::Triangle(Triangle::new(corners).unwrap())), GREY);
    let rectangle = SceneNode::new(Content::Shape(Shape::Rectangle(Rectangle::new(1.0, 1.0).unwrap())), CHECKER);
    let finding = only(&scene_of(vec![sheet.clone(), rectangle]), Kind::CoincidentSurfaces);
    assert_eq!(finding.values[1].value, finding.values[0].value);
    let same = only(&scene_of(vec![sheet.clone(), sheet]), Kind::CoincidentSurfaces);
    assert_eq!(same.severity, Severity::Note, "they look the same");
}

#[test]
fn rounding_of_transforms_does_not_hide_what_coincides() {
    let turn = Transform::rotate(DVec3::new(1.0, 2.0, 3.0), 0.7).unwrap();
    let far = Transform::translate(DVec3::new(1e5, 3e4, -2e5));
    let place = far.compose(&turn);
    let one = SceneNode { parent_from_local: place, ..solid(DVec3::ZERO, DVec3::ONE, GREY) };
    let shifted = place.compose(&Transform::translate(DVec3::new(0.3, 0.0, 0.1)));
    let two = painted(SceneNode { parent_from_local: shifted, ..solid(DVec3::ZERO, DVec3::ONE, GREY) });
    let mut scene = scene_of(vec![one, two]);
    scene.cameras.clear();
    // Bottom and top lie in each other's; the other faces do not.
    let finding = only(&scene, Kind::CoincidentSurfaces);
    assert!((4.0..=8.0).contains(&finding.values[0].value), "{finding:?}");
}

#[test]
fn the_same_sphere_twice_and_the_same_floor_twice_are_found() {
    let unit = sphere(DVec3::ZERO, 1.0);
    let scaled = painted(SceneNode {
        parent_from_local: Transform::scale(DVec3::splat(0.1)).unwrap(),
        ..sphere(DVec3::ZERO, 10.0)
    });
    let finding = only(&scene_of(vec![unit.clone(), scaled]), Kind::CoincidentSurfaces);
    assert_eq!(finding.values, faces(1.0, 1.0));
    let other = painted(sphere(DVec3::ZERO, 1.0 + 1e-9));
    assert_eq!(of_kind(&scene_of(vec![unit, other]), Kind::CoincidentSurfaces), []);
    let finding = only(&scene_of(vec![floor(0.0), painted(floor(0.0))]), Kind::CoincidentSurfaces);
    assert_eq!(finding.values, faces(1.0, 1.0));
}

#[test]
fn glass_that_touches_is_named() {
    let glass = solid(DVec3::new(-0.5, 0.0, -0.5), DVec3::new(0.5, 1.0, 0.5), GLASS);
    let first = only(&scene_of(vec![glass.clone(), floor(0.0)]), Kind::TouchingGlass);
    assert_eq!((first.severity, first.values[0]), (Severity::Warning, value("faces", 2.0)));
    let second = only(&scene_of(vec![floor(0.0), glass.clone()]), Kind::TouchingGlass);
    assert_eq!(second.severity, Severity::Note, "light stops at the floor");
    let above = solid(DVec3::new(-0.5, 1.0, -0.5), DVec3::new(0.5, 2.0, 0.5), GLASS);
    assert_eq!(only(&scene_of(vec![glass, above]), Kind::TouchingGlass).severity, Severity::Note);
}

#[test]
fn a_mesh_that_lies_in_itself_is_noted() {
    let mut scene = empty();
    let mut data = cube_data();
    let first = data.positions.len() as u32;
    let flap = [[0.25, 0.25, 0.0], [0.25, 0.75, 0.0], [0.75, 0.25, 0.0]];
    data.positions.extend(flap.map(rt_math::Vec3::from));
    data.triangles.push([first, first + 1, first + 2]);
    let node = add_mesh(&mut scene, data);
    scene.nodes = vec![node];
    let finding = only(&scene, Kind::CoincidentSurfaces);
    assert_eq!((finding.severity, finding.values[0].value), (Severity::Note, 2.0));
}
