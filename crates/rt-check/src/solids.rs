//! Solids: objects that separate an inside from an outside.

use rt_geometry::{Hit, InteractionFlags, Primitives, Shape, ShapeHit, TransformedShape};
use rt_math::{DVec3, Interval, Ray};

use crate::finding::{Finding, Findings, Kind};
use crate::objects::{Geometry, Object, Objects};
use crate::tolerance::tolerance;
use crate::topology::Topology;

/// Flags of objects: true for the closed surface of a solid.
#[derive(Debug)]
pub(crate) struct Solids(Vec<bool>);

impl Solids {
    /// Classifies objects, given the topology of each mesh of the scene.
    pub(crate) fn of(objects: &Objects<'_>, topologies: &[Topology]) -> Self {
        let is_closed = |object: &Object<'_>| match object.geometry {
            Geometry::Shape(shape) => encloses(shape),
            Geometry::Mesh(index, _) => topologies[index].is_closed(),
        };
        Self(objects.list.iter().map(is_closed).collect())
    }

    pub(crate) fn is_closed(&self, object: usize) -> bool {
        self.0[object]
    }

    /// Solids that contain a point.
    pub(crate) fn containing<'o>(
        &'o self,
        objects: &'o Objects<'o>,
        point: DVec3,
    ) -> impl Iterator<Item = Enclosure<'o>> {
        objects
            .list
            .iter()
            .enumerate()
            .filter(|(index, _)| self.is_closed(*index))
            .filter_map(move |(_, object)| Some(Enclosure { object, wall: wall_around(object, point)? }))
    }
}

/// A solid around a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Enclosure<'o> {
    pub(crate) object: &'o Object<'o>,
    /// Minimum distance from the point to the surface along a few directions.
    pub(crate) wall: f64,
}

/// True if a shape has an inside. A plane and flat or open shapes have two sides instead.
fn encloses(shape: &Shape) -> bool {
    match shape {
        Shape::Sphere(_) | Shape::Cuboid(_) | Shape::Torus(_) | Shape::InfiniteCylinder(_) | Shape::DoubleCone(_) => {
            true
        }
        Shape::Cylinder(quadric) | Shape::Cone(quadric) | Shape::Frustum(quadric) => quadric.has_caps(),
        _ => false,
    }
}

/// True if a point is inside of a closed object.
pub(crate) fn contains(solid: &Object<'_>, point: DVec3) -> bool {
    wall_around(solid, point).is_some()
}

/// Distance from a point to the surface of the solid around it; `None` if the point is outside.
///
/// A point is inside if most rays from it first hit a back face. A mesh that is inside out gives the opposite result;
/// another lint reports it.
fn wall_around(object: &Object<'_>, point: DVec3) -> Option<f64> {
    if object.bounds.is_some_and(|bounds| !bounds.contains(point)) {
        return None;
    }
    let leaves = walls(object, point).flatten();
    (2 * leaves.clone().count() > DIRECTIONS.len()).then(|| leaves.fold(f64::INFINITY, f64::min))
}

/// Distance from a point to the surface of the solid around it. `None` unless all rays from it first hit a back face, farther
/// than rounding.
pub(crate) fn wall_all_around(object: &Object<'_>, point: DVec3) -> Option<f64> {
    let nearest = walls(object, point).try_fold(f64::INFINITY, |nearest, wall| Some(wall?.min(nearest)))?;
    (nearest > tolerance(object.placement_error(), point.abs().max_element() + nearest)).then_some(nearest)
}

/// Directions of rays from a point. No symmetric shape or mesh has edges in them.
const DIRECTIONS: [DVec3; 5] = [
    DVec3::new(0.267, 0.802, 0.534),
    DVec3::new(-0.715, 0.204, 0.669),
    DVec3::new(0.611, -0.377, -0.696),
    DVec3::new(-0.143, -0.871, 0.470),
    DVec3::new(0.393, 0.231, -0.890),
];

/// Distances from a point to the back faces that rays from it hit first; `None` for a ray that misses or hits a front face.
fn walls(object: &Object<'_>, point: DVec3) -> impl Iterator<Item = Option<f64>> + Clone {
    DIRECTIONS.into_iter().map(move |direction| {
        let (t, normal) = first_hit(object, &Ray::new(point, direction))?;
        (normal.dot(direction) > 0.0).then(|| t * direction.length())
    })
}

/// Closest hit of a ray in world space on an object: its `t` and the normal of the front.
pub(crate) fn first_hit(object: &Object<'_>, ray: &Ray) -> Option<(f64, DVec3)> {
    let needs = InteractionFlags::NONE;
    match object.geometry {
        Geometry::Shape(shape) => {
            let placed = TransformedShape::new(shape.clone(), object.world_from_local);
            let hit: ShapeHit = placed.intersect(ray, Interval::FORWARD)?;
            Some((hit.t, placed.surface(ray, &hit, needs).geometric_normal))
        }
        Geometry::Mesh(_, mesh) => {
            let local = object.world_from_local.inverse_ray(ray);
            let mut nearest: Option<Hit> = None;
            for index in 0..mesh.len() as u32 {
                let span = nearest.map_or(Interval::FORWARD, |hit| Interval { max: hit.t, ..Interval::FORWARD });
                if let Some(hit) = mesh.intersect(index, &local, span).filter(|hit| hit.t < span.max) {
                    nearest = Some(hit);
                }
            }
            let hit = nearest?;
            let surface = mesh.surface(&local, &hit, needs)?;
            Some((hit.t, object.world_from_local.normal(surface.geometric_normal)))
        }
    }
}

/// Reports transparent surfaces without an inside.
pub(crate) fn check(objects: &Objects<'_>, solids: &Solids, topologies: &[Topology], findings: &mut Findings) {
    for (index, object) in objects.list.iter().enumerate() {
        if solids.is_closed(index) || !objects.is_glass(object) {
            continue;
        }
        let (edges, what) = match object.geometry {
            Geometry::Mesh(mesh, _) => {
                let topology = topologies[mesh];
                let edges = topology.open + topology.inconsistent;
                (edges as f64, format!("a mesh with {edges} edges that are open or inconsistently oriented"))
            }
            Geometry::Shape(_) => (0.0, "a shape without an interior".to_owned()),
        };
        findings.add(Finding::new(
            Kind::OpenGlass,
            objects.name(object),
            &[("open_edges", edges)],
            format!("is transmissive, but {what}: light may enter it and never leave"),
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::*;
    use crate::welded::Welded;
    use rt_geometry::{CappedQuadric, Cuboid, Plane, Torus};
    use rt_math::{Transform, Vec3};
    use rt_scene_io::{Content, SceneNode};

    fn shape(shape: Shape) -> SceneNode {
        SceneNode::new(Content::Shape(shape), GLASS)
    }

    #[test]
    fn points_are_inside_or_outside_of_solids() {
        let mut scene = empty();
        let mut egg = sphere(DVec3::ZERO, 1.0);
        let stretch = Transform::scale(DVec3::new(1.0, -3.0, 1.0)).unwrap();
        egg.parent_from_local = Transform::translate(DVec3::X * 10.0).compose(&stretch);
        let cube = add_mesh(&mut scene, cube_data());
        let ring = shape(Shape::Torus(Torus::new(5.0, 0.5).unwrap()));
        scene.nodes = vec![egg, cube, ring];
        let objects = Objects::of(&scene);
        let mesh = &scene.meshes[0].mesh;
        let topology = Topology::of(mesh, &Welded::new(mesh.data()));
        let solids = Solids::of(&objects, &[topology]);
        let inside = |x: f64, y: f64, z: f64| -> Vec<String> {
            solids.containing(&objects, DVec3::new(x, y, z)).map(|within| objects.name(within.object)).collect()
        };
        assert_eq!(inside(10.0, 2.9, 0.0), ["nodes[0]"]);
        assert_eq!(inside(10.8, 2.0, 0.0), [""; 0]);
        assert_eq!(inside(0.5, 0.5, 0.5), ["nodes[1] \"cube\""]);
        assert_eq!(inside(0.5, 0.5, 1.1), [""; 0]);
        assert_eq!(inside(0.0, 0.0, 5.2), ["nodes[2]"]);
        assert_eq!(inside(0.0, 0.0, 4.2), [""; 0], "in the hole of the ring");
        let within = solids.containing(&objects, DVec3::splat(0.5)).next().unwrap();
        assert!((0.5..0.6).contains(&within.wall), "{within:?}");
    }

    #[test]
    fn open_glass_is_warned_of() {
        let plane = Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Y).unwrap());
        let open_cylinder = Shape::Cylinder(CappedQuadric::cylinder(1.0, 0.0, 1.0, false).unwrap());
        for open in [plane, open_cylinder] {
            assert_eq!(only(&scene_with(vec![shape(open)]), Kind::OpenGlass).severity, Severity::Warning);
        }
        let solid = Shape::Cuboid(Cuboid::new(DVec3::ZERO, DVec3::ONE).unwrap());
        let can = Shape::Cylinder(CappedQuadric::cylinder(1.0, 5.0, 6.0, true).unwrap());
        assert_eq!(of_kind(&scene_with(vec![shape(solid), shape(can)]), Kind::OpenGlass), []);
    }

    #[test]
    fn open_glass_meshes_count_their_edges() {
        let mut data = cube_data();
        data.triangles.pop();
        data.positions.iter_mut().for_each(|p| *p *= Vec3::new(1.0, 2.0, 1.0));
        let mut scene = scene_of_mesh(data);
        scene.nodes[0].material = GLASS;
        assert_eq!(only(&scene, Kind::OpenGlass).values, [value("open_edges", 3.0)]);
    }
}
