//! Emissive objects, and opaque solids around them.

use std::ops::ControlFlow;

use rt_accel::{Accelerator, Boxes, Bvh};
use rt_math::{Aabb, DVec3};

use crate::enclosed::is_outside_of_cameras;
use crate::facets::Facets;
use crate::finding::{Finding, Findings, Kind};
use crate::objects::{Geometry, Object, Objects};
use crate::solids::{Solids, first_hit, wall_all_around};

/// Largest number of intersection tests of rays and triangles.
const MAX_TESTS: usize = 1 << 28;

/// Directions from the centre of an emitter to its examined points.
const DIRECTIONS: [DVec3; 14] = [
    DVec3::X,
    DVec3::NEG_X,
    DVec3::Y,
    DVec3::NEG_Y,
    DVec3::Z,
    DVec3::NEG_Z,
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(-1.0, 1.0, 1.0),
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(-1.0, -1.0, 1.0),
    DVec3::new(1.0, 1.0, -1.0),
    DVec3::new(-1.0, 1.0, -1.0),
    DVec3::new(1.0, -1.0, -1.0),
    DVec3::new(-1.0, -1.0, -1.0),
];

/// Finds opaque bounded solids that hide emissive objects from all cameras.
pub(crate) fn check(objects: &Objects<'_>, solids: &Solids, findings: &mut Findings) {
    let emitters: Vec<_> = (objects.list.iter().enumerate())
        .filter(|(_, object)| objects.is_emissive(object))
        .filter_map(|(index, object)| Some((index, object.bounds?)))
        .collect();
    let walls = objects
        .list
        .iter()
        .enumerate()
        .filter(|(index, object)| solids.is_closed(*index) && object.casts_shadow && objects.is_opaque(object));
    let (walls, boxes): (Vec<usize>, Vec<Aabb>) = walls.filter_map(|(i, object)| Some((i, object.bounds?))).unzip();
    let boxes = Boxes(&boxes);
    let Ok(bvh) = Bvh::build(&boxes) else { return };
    let facets = Facets::of(objects);
    let mut tests_left = MAX_TESTS;
    let mut hides = vec![None; walls.len()];
    for (index, bounds) in emitters {
        let emitter = &objects.list[index];
        let mut around = Vec::new();
        bvh.visit_overlapping(&boxes, &bounds, |rank| {
            let wall = boxes.0[rank as usize];
            if walls[rank as usize] != index && wall.contains(bounds.min) && wall.contains(bounds.max) {
                around.push(rank as usize);
            }
            ControlFlow::Continue(())
        });
        around.sort_unstable();
        let points = if around.is_empty() { Vec::new() } else { surface_points(objects, &facets, index) };
        for rank in around {
            let solid = &objects.list[walls[rank]];
            let rays = 5 * (points.len() + objects.scene.cameras.len());
            let Some(left) = tests_left.checked_sub(rays.saturating_mul(test_count(solid))) else {
                let message = "has too many emissive objects within solids to test all of them";
                findings.add(Finding::new(Kind::LimitReached, &objects.scene.name, &[], message));
                return;
            };
            tests_left = left;
            let distances: Option<Vec<f64>> = points.iter().map(|point| wall_all_around(solid, *point)).collect();
            let Some(distances) = distances.filter(|distances| !distances.is_empty()) else { continue };
            if *hides[rank].get_or_insert_with(|| is_outside_of_cameras(objects, solid)) {
                let wall = distances.into_iter().fold(f64::INFINITY, f64::min);
                let message = format!("is inside {}, which blocks its light", objects.name(solid));
                let finding =
                    Finding::new(Kind::LightEnclosed, objects.name(emitter), &[("distance_to_wall", wall)], message);
                findings.add(finding.with_advice("move it out of the solid, or make the solid smaller or transparent"));
            }
        }
    }
}

/// Number of intersection tests of a ray with an object.
fn test_count(object: &Object<'_>) -> usize {
    match object.geometry {
        Geometry::Mesh(_, mesh) => mesh.data().triangles.len(),
        Geometry::Shape(_) => 1,
    }
}

/// Points on the surface of an object in world space: extreme corners, and points of curved shapes.
fn surface_points(objects: &Objects<'_>, facets: &Facets<'_>, index: usize) -> Vec<DVec3> {
    let object = &objects.list[index];
    match object.geometry {
        Geometry::Mesh(_, mesh) => {
            let placed = mesh.data().positions.iter().map(|p| object.world_from_local.point(p.as_dvec3()));
            extremes(placed)
        }
        Geometry::Shape(_) => {
            let mut points = extremes(facets.corners_of(index).into_iter());
            if let Some(bounds) = object.bounds {
                let reach = bounds.extent().length();
                points.extend(DIRECTIONS.iter().filter_map(|direction| {
                    let ray = rt_math::Ray::new(bounds.centre() + *direction * reach, -*direction * reach);
                    let (t, _) = first_hit(object, &ray)?;
                    Some(ray.at(t))
                }));
            }
            points
        }
    }
}

/// Extreme points in all [`DIRECTIONS`].
fn extremes(points: impl Iterator<Item = DVec3>) -> Vec<DVec3> {
    let mut best = [(f64::NEG_INFINITY, DVec3::ZERO); DIRECTIONS.len()];
    for point in points {
        for (best, direction) in best.iter_mut().zip(DIRECTIONS) {
            let distance = point.dot(direction);
            if distance > best.0 {
                *best = (distance, point);
            }
        }
    }
    best.into_iter().filter(|(distance, _)| distance.is_finite()).map(|(_, point)| point).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::fixture::*;
    use rt_geometry::{Cuboid, InsideRule, Polygon, Rectangle, Shape};
    use rt_math::{Rgb, Transform};
    use rt_scene_io::{Content, Scene, SceneNode};
    use rt_shading::{Alpha, AlphaMode, ColorTexture};

    /// The material `checker` emits light.
    fn scene_of(nodes: Vec<SceneNode>) -> Scene {
        let mut scene = seen_from(DVec3::Z * 9.0, nodes);
        scene.appearance.materials[2].emission = ColorTexture::Constant(Rgb::WHITE);
        scene
    }

    fn cuboid() -> SceneNode {
        SceneNode::new(Content::Shape(Shape::Cuboid(Cuboid::new(DVec3::NEG_ONE, DVec3::ONE).unwrap())), GREY)
    }

    fn emissive(node: SceneNode) -> SceneNode {
        SceneNode { material: CHECKER, ..node }
    }

    #[test]
    fn an_emissive_object_in_an_opaque_solid_is_found() {
        let scene = scene_of(vec![cuboid(), emissive(sphere(DVec3::ZERO, 0.3))]);
        let finding = only(&scene, Kind::LightEnclosed);
        assert_eq!((finding.severity, finding.object.as_str()), (Severity::Warning, "nodes[1]"));
        assert!((0.7..0.9).contains(&finding.values[0].value), "{finding:?}");

        let flat = Shape::Rectangle(Rectangle::new(1.0, 1.0).unwrap());
        let corners = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let polygon = Polygon::new(corners.to_vec(), Vec::new(), InsideRule::Convex).unwrap();
        for shape in [flat, Shape::Polygon(Arc::new(polygon))] {
            let scene = scene_of(vec![sphere(DVec3::ZERO, 1.0), emissive(SceneNode::new(Content::Shape(shape), GREY))]);
            assert_eq!(of_kind(&scene, Kind::LightEnclosed).len(), 1);
        }
        let mut scene = scene_of(Vec::new());
        let mesh = add_mesh(&mut scene, cube_data());
        scene.nodes = vec![emissive(mesh), sphere(DVec3::splat(0.5), 0.9)];
        assert_eq!(of_kind(&scene, Kind::LightEnclosed).len(), 1);
        scene.nodes[1] = sphere(DVec3::splat(0.5), 0.8);
        assert_eq!(of_kind(&scene, Kind::LightEnclosed), [], "its corners stick out");
    }

    #[test]
    fn an_emissive_object_whose_light_leaves_is_not_found() {
        let emitter = || emissive(sphere(DVec3::ZERO, 0.3));
        let enclosed = |scene: &Scene| of_kind(scene, Kind::LightEnclosed);
        let moved = |by| SceneNode { parent_from_local: Transform::translate(by), ..emitter() };
        assert_eq!(enclosed(&scene_of(vec![cuboid(), moved(DVec3::X * 0.9)])), [], "sticks out");
        assert_eq!(enclosed(&scene_of(vec![cuboid(), moved(DVec3::X * 3.0)])), []);
        assert_eq!(enclosed(&scene_of(vec![SceneNode { material: GLASS, ..cuboid() }, emitter()])), []);
        assert_eq!(enclosed(&scene_of(vec![SceneNode { casts_shadow: false, ..cuboid() }, emitter()])), []);
        assert_eq!(enclosed(&scene_of(vec![emissive(cuboid())])), [], "a solid around itself");
        let flush = SceneNode {
            parent_from_local: Transform::translate(DVec3::Y),
            ..emissive(SceneNode::new(Content::Shape(Shape::Rectangle(Rectangle::new(0.5, 0.5).unwrap())), GREY))
        };
        assert_eq!(enclosed(&scene_of(vec![cuboid(), flush])), [], "flush with the top");
        let mut leaves = scene_of(vec![cuboid(), emitter()]);
        leaves.appearance.materials[0].alpha = Alpha { mode: AlphaMode::Mask(0.5), ..Alpha::OPAQUE };
        assert_eq!(enclosed(&leaves), []);
    }

    #[test]
    fn a_room_with_an_emissive_object_is_lit() {
        let mut scene = scene_of(vec![cuboid(), emissive(sphere(DVec3::ZERO, 0.3))]);
        scene.cameras = vec![camera(DVec3::Z * 0.9, DVec3::ZERO)];
        assert_eq!(of_kind(&scene, Kind::LightEnclosed), []);
        assert_eq!(only(&scene, Kind::CameraInside).severity, Severity::Note);
    }
}
