use super::*;
use crate::finding::Measurement;
use crate::fixture::*;
use std::sync::Arc;

use rt_geometry::{CappedQuadric, Cuboid, Disk, InsideRule, Polygon, Rectangle, Triangle};
use rt_math::Transform;
use rt_scene_io::{Content, MaterialId, Scene, SceneNode};

fn solid(min: DVec3, max: DVec3, material: MaterialId) -> SceneNode {
    SceneNode::new(Content::Shape(Shape::Cuboid(Cuboid::new(min, max).unwrap())), material)
}

fn faces(count: f64, visible: f64) -> [Measurement; 2] {
    [value("faces", count), value("visible_faces", visible)]
}

fn scene_of(nodes: Vec<SceneNode>) -> Scene {
    seen_from(DVec3::new(0.3, 2.0, 6.0), nodes)
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
    let mut data = cube_data();
    let first = data.positions.len() as u32;
    let flap = [[0.25, 0.25, 0.0], [0.25, 0.75, 0.0], [0.75, 0.25, 0.0]];
    data.positions.extend(flap.map(rt_math::Vec3::from));
    data.triangles.push([first, first + 1, first + 2]);
    let scene = scene_of_mesh(data);
    let finding = only(&scene, Kind::CoincidentSurfaces);
    assert_eq!((finding.severity, finding.values[0].value), (Severity::Note, 2.0));
}

fn shape(shape: Shape, material: MaterialId) -> SceneNode {
    SceneNode::new(Content::Shape(shape), material)
}

fn cylinder(bottom: f64, top: f64, material: MaterialId) -> SceneNode {
    shape(Shape::Cylinder(CappedQuadric::cylinder(0.5, bottom, top, true).unwrap()), material)
}

fn disk(radius: f64, inner_radius: f64) -> SceneNode {
    shape(Shape::Disk(Disk::new(radius, inner_radius).unwrap()), CHECKER)
}

fn rectangle(side: f64) -> SceneNode {
    shape(Shape::Rectangle(Rectangle::new(side, side).unwrap()), GREY)
}

/// A polygon in the plane y = 0.
fn polygon(outline: &[[f64; 2]], rule: InsideRule) -> SceneNode {
    let outline = outline.iter().map(|[x, z]| DVec3::new(*x, 0.0, *z)).collect();
    shape(Shape::Polygon(Arc::new(Polygon::new(outline, Vec::new(), rule).unwrap())), CHECKER)
}

fn at(offset: DVec3, node: SceneNode) -> SceneNode {
    SceneNode { parent_from_local: Transform::translate(offset), ..node }
}

/// Glass on a plane was found for boxes and meshes only.
#[test]
fn a_glass_cylinder_frustum_or_cone_that_stands_on_something_is_found() {
    let frustum = |bottom, top| shape(Shape::Frustum(CappedQuadric::frustum(bottom, top, 1.0, true).unwrap()), GLASS);
    let cone = shape(Shape::Cone(CappedQuadric::cone(0.5, 1.0, true).unwrap()), GLASS);
    let slab = solid(DVec3::new(-2.0, -1.0, -2.0), DVec3::new(2.0, 0.0, 2.0), GREY);
    for glass in [cylinder(0.0, 1.0, GLASS), frustum(0.5, 0.25), frustum(0.25, 0.5), cone] {
        for (ground, count) in [(floor(0.0), 1.0), (slab.clone(), 2.0), (rectangle(4.0), 2.0)] {
            let first = only(&scene_of(vec![glass.clone(), ground.clone()]), Kind::TouchingGlass);
            assert_eq!((first.severity, first.values[0]), (Severity::Warning, value("faces", count)));
            let second = only(&scene_of(vec![ground.clone(), glass.clone()]), Kind::TouchingGlass);
            assert_eq!(second.severity, Severity::Note, "light stops at the ground");
            let above = at(DVec3::Y * 1e-6, glass.clone());
            assert_eq!(of_kind(&scene_of(vec![above, ground]), Kind::TouchingGlass), []);
        }
    }
    let open = shape(Shape::Cylinder(CappedQuadric::cylinder(0.5, 0.0, 1.0, false).unwrap()), GREY);
    assert_eq!(of_kind(&scene_of(vec![open, floor(0.0)]), Kind::TouchingGlass), []);
}

#[test]
fn a_disk_on_a_plane_or_rectangle_is_found() {
    for ground in [floor(0.0), rectangle(1.0), painted(disk(3.0, 0.0))] {
        let finding =
            only(&scene_of(vec![SceneNode { material: GREY, ..ground }, disk(0.25, 0.0)]), Kind::CoincidentSurfaces);
        assert_eq!(finding.severity, Severity::Warning);
    }
    let outside = at(DVec3::X * 0.75, disk(0.25, 0.0));
    assert_eq!(of_kind(&scene_of(vec![rectangle(1.0), outside]), Kind::CoincidentSurfaces), [], "at the edge");
    let ring = || SceneNode { material: GREY, ..disk(0.5, 0.25) };
    let turned = Transform::rotate(DVec3::Y, 0.05).unwrap();
    let inlay = SceneNode { parent_from_local: turned, ..disk(0.25, 0.0) };
    assert_eq!(of_kind(&scene_of(vec![ring(), inlay]), Kind::CoincidentSurfaces), [], "fills the hole");
    let finding = only(&scene_of(vec![ring(), disk(0.26, 0.0)]), Kind::CoincidentSurfaces);
    assert_eq!(finding.values, faces(1.0, 1.0));
}

#[test]
fn a_polygon_on_a_rectangle_is_found() {
    let square = [[-0.25, -0.25], [-0.25, 0.25], [0.25, 0.25], [0.25, -0.25]];
    let notched = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]];
    for rule in [InsideRule::Convex, InsideRule::EvenOdd] {
        let finding = only(&scene_of(vec![rectangle(1.0), polygon(&square, rule)]), Kind::CoincidentSurfaces);
        assert_eq!((finding.severity, finding.values[0]), (Severity::Warning, value("faces", 2.0)));
        let finding = only(&scene_of(vec![floor(0.0), polygon(&square, rule)]), Kind::CoincidentSurfaces);
        assert_eq!(finding.values, faces(1.0, 1.0));
        let outside = at(DVec3::X * 0.75, polygon(&square, rule));
        assert_eq!(of_kind(&scene_of(vec![rectangle(1.0), outside]), Kind::CoincidentSurfaces), [], "at the edge");
    }
    let polygons = |offset| {
        vec![SceneNode { material: GREY, ..polygon(&notched, InsideRule::EvenOdd) }, at(offset, disk(0.5, 0.0))]
    };
    let mut scene = scene_of(polygons(DVec3::new(2.0, 0.0, 3.5)));
    assert_eq!(of_kind(&scene, Kind::CoincidentSurfaces), [], "in the notch");
    scene.nodes = polygons(DVec3::new(2.0, 0.0, 0.75));
    assert_eq!(of_kind(&scene, Kind::CoincidentSurfaces).len(), 1);
}

#[test]
fn coaxial_cylinders_of_equal_radius_are_found() {
    let label = shape(Shape::Cylinder(CappedQuadric::cylinder(0.5, 0.25, 0.75, false).unwrap()), CHECKER);
    let can = cylinder(0.0, 1.0, GREY);
    let finding = only(&scene_of(vec![can.clone(), label.clone()]), Kind::CoincidentSurfaces);
    assert_eq!((finding.severity, finding.values), (Severity::Warning, faces(1.0, 1.0).to_vec()));
    let turn = Transform::rotate(DVec3::new(1.0, 2.0, 3.0), 0.7).unwrap();
    let turned =
        |node: &SceneNode| SceneNode { parent_from_local: turn.compose(&node.parent_from_local), ..node.clone() };
    let flipped = Transform::translate(DVec3::Y).compose(&Transform::scale(DVec3::new(2.0, -1.0, 2.0)).unwrap());
    let shape_of_half = shape(Shape::Cylinder(CappedQuadric::cylinder(0.25, 0.25, 0.75, false).unwrap()), CHECKER);
    let same = SceneNode { parent_from_local: flipped, ..shape_of_half };
    let scene = scene_of(vec![turned(&can), turned(&same)]);
    assert_eq!(of_kind(&scene, Kind::CoincidentSurfaces)[0].values, faces(1.0, 1.0));

    for apart in [at(DVec3::Y * 0.75, label.clone()), at(DVec3::X * 1e-6, label.clone()), at(DVec3::X, label)] {
        assert_eq!(of_kind(&scene_of(vec![can.clone(), apart]), Kind::CoincidentSurfaces), []);
    }
    let stacked = scene_of(vec![can, cylinder(1.0, 2.0, CHECKER)]);
    assert_eq!(of_kind(&stacked, Kind::CoincidentSurfaces), [], "both are opaque");
    // A frustum that is the lower part of a cone.
    let cone = shape(Shape::Cone(CappedQuadric::cone(1.0, 2.0, false).unwrap()), GREY);
    let part = shape(Shape::Frustum(CappedQuadric::frustum(1.0, 0.5, 1.0, false).unwrap()), CHECKER);
    let other = shape(Shape::Frustum(CappedQuadric::frustum(1.0, 0.75, 1.0, false).unwrap()), CHECKER);
    assert_eq!(of_kind(&scene_of(vec![cone.clone(), part]), Kind::CoincidentSurfaces)[0].values, faces(1.0, 1.0));
    assert_eq!(of_kind(&scene_of(vec![cone, other]), Kind::CoincidentSurfaces), []);
}
