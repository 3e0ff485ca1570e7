//! Everything that stands in a scene, with its path in the tree.

use std::fmt::Write;
use std::sync::Arc;

use rt_geometry::{Shape, TransformedShape, TriangleMesh};
use rt_math::{Aabb, Transform};
use rt_scene_io::{Content, Group, NamedMesh, Node, Scene};
use rt_shading::Material;

use super::transforms::condition;

/// Most nodes that are looked at, instances counted as often as they are placed.
const MAX_PLACES: usize = 1 << 20;

/// Deepest nesting that is looked at; plans refuse more.
const MAX_DEPTH: usize = 1024;

/// What an object is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Geometry<'s> {
    Shape(&'s Shape),
    /// With its index in the scene.
    Mesh(usize, &'s TriangleMesh),
}

/// A shape or mesh in world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Object<'s> {
    place: usize,
    pub(super) geometry: Geometry<'s>,
    pub(super) world_from_local: Transform,
    /// Product of the condition numbers of all transforms on the way to the object: what rounding may grow by.
    pub(super) chain_condition: f64,
    /// Number of the material.
    pub(super) material: usize,
    pub(super) casts_shadow: bool,
    /// World space; `None` for what is infinite.
    pub(super) bounds: Option<Aabb>,
}

impl Object<'_> {
    /// The greatest distance, per axis, by which rounding in the transform may move a point of the object.
    pub(super) fn placement_error(&self) -> f64 {
        let local = match self.geometry {
            Geometry::Shape(shape) => shape.bounds(),
            Geometry::Mesh(_, mesh) => Some(mesh.bounds()),
        };
        let corners = local.map(|bounds| bounds.corners()).into_iter().flatten();
        let errors = corners.map(|p| self.world_from_local.point_with_error(p, rt_math::DVec3::ZERO).1.max_element());
        if self.world_from_local.is_identity() { 0.0 } else { errors.fold(0.0, f64::max) }
    }
}

/// A node on some way through the tree; a node of a group has a place for each instance.
#[derive(Clone, Copy, Debug)]
struct Place<'s> {
    parent: Option<usize>,
    /// Set where this is a node of a group, reached through an instance.
    group: Option<&'s Group>,
    index: usize,
    node: &'s Node,
}

/// All objects of a scene, in the order in which they are rendered: of surfaces in the same place, the first is seen.
#[derive(Debug)]
pub(super) struct Objects<'s> {
    pub(super) scene: &'s Scene,
    pub(super) list: Vec<Object<'s>>,
    places: Vec<Place<'s>>,
    pub(super) group_used: Vec<bool>,
    /// Whether the tree holds more than is looked at.
    pub(super) truncated: bool,
}

/// Siblings that are still to be visited.
struct Siblings<'s> {
    nodes: std::iter::Enumerate<std::slice::Iter<'s, Node>>,
    parent: Option<usize>,
    group: Option<&'s Group>,
    world_from_parent: Transform,
    chain_condition: f64,
    casts_shadow: bool,
}

impl<'s> Objects<'s> {
    pub(super) fn of(scene: &'s Scene) -> Self {
        let mut objects = Self {
            scene,
            list: Vec::new(),
            places: Vec::new(),
            group_used: vec![false; scene.groups.len()],
            truncated: false,
        };
        objects.walk();
        objects
    }

    /// Trees may be deep, so the walk keeps its own stack.
    fn walk(&mut self) {
        let mut open = vec![Siblings {
            nodes: self.scene.nodes.iter().enumerate(),
            parent: None,
            group: None,
            world_from_parent: Transform::IDENTITY,
            chain_condition: 1.0,
            casts_shadow: true,
        }];
        while let Some(siblings) = open.last_mut() {
            let Some((index, node)) = siblings.nodes.next() else {
                open.pop();
                continue;
            };
            let place = Place { parent: siblings.parent, group: siblings.group, index, node };
            let world_from_local = siblings.world_from_parent.compose(&node.parent_from_local);
            let chain_condition = siblings.chain_condition * condition(&node.parent_from_local.linear());
            let casts_shadow = siblings.casts_shadow && node.casts_shadow;
            if self.places.len() >= MAX_PLACES || open.len() >= MAX_DEPTH {
                self.truncated = true;
                return;
            }
            let here = self.places.len();
            self.places.push(place);
            let below = |nodes: &'s [Node], group| Siblings {
                nodes: nodes.iter().enumerate(),
                parent: Some(here),
                group,
                world_from_parent: world_from_local,
                chain_condition,
                casts_shadow,
            };
            open.push(below(&node.children, None));
            let geometry = match &node.content {
                Some(Content::Shape(shape)) => Some(Geometry::Shape(shape)),
                Some(Content::Mesh(id)) => {
                    let mesh = self.scene.meshes.get(id.0 as usize);
                    mesh.map(|named| Geometry::Mesh(id.0 as usize, &named.mesh))
                }
                Some(Content::Instance(id)) => {
                    if let Some(group) = self.scene.groups.get(id.0 as usize) {
                        self.group_used[id.0 as usize] = true;
                        open.push(below(&group.nodes, Some(group)));
                    }
                    None
                }
                None => None,
            };
            if let Some(geometry) = geometry {
                self.list.push(Object {
                    place: here,
                    geometry,
                    world_from_local,
                    chain_condition,
                    material: node.material.0 as usize,
                    casts_shadow,
                    bounds: world_bounds(geometry, &world_from_local),
                });
            }
        }
    }

    /// The path of an object in the tree and its name, such as `nodes[2].children[0] "lamp"`.
    pub(super) fn name(&self, object: &Object<'_>) -> String {
        let mut steps = Vec::new();
        let mut at = Some(object.place);
        while let Some(place) = at.and_then(|index| self.places.get(index)) {
            steps.push(place);
            at = place.parent;
        }
        let mut path = String::new();
        for place in steps.iter().rev() {
            let index = place.index;
            let written = match (place.group, place.parent) {
                (Some(group), _) => write!(path, " > groups[{:?}][{index}]", group.name),
                (None, Some(_)) => write!(path, ".children[{index}]"),
                (None, None) => write!(path, "nodes[{index}]"),
            };
            debug_assert!(written.is_ok(), "strings take what is written to them");
        }
        match steps.first().map(|place| place.node.name.as_str()) {
            Some("") | None => path,
            Some(name) => format!("{path} {name:?}"),
        }
    }

    /// The meshes of the scene; those without a name are numbered.
    pub(super) fn meshes(&self) -> impl Iterator<Item = NamedMesh> {
        self.scene.meshes.iter().enumerate().map(|(index, named)| match named.name.as_str() {
            "" => NamedMesh { name: format!("mesh number {index}"), mesh: Arc::clone(&named.mesh) },
            _ => named.clone(),
        })
    }

    /// The material of an object; `None` if it does not exist.
    pub(super) fn material(&self, object: &Object<'_>) -> Option<&'s Material> {
        self.scene.appearance.materials.get(object.material)
    }

    pub(super) fn is_glass(&self, object: &Object<'_>) -> bool {
        self.material(object).is_some_and(|material| material.body().is_some())
    }

    /// The box around all that is bounded; empty for nothing.
    pub(super) fn bounds(&self) -> Aabb {
        self.list.iter().filter_map(|object| object.bounds).fold(Aabb::EMPTY, Aabb::union)
    }
}

fn world_bounds(geometry: Geometry<'_>, world_from_local: &Transform) -> Option<Aabb> {
    match geometry {
        Geometry::Shape(shape) => TransformedShape::new(shape.clone(), *world_from_local).bounds(),
        Geometry::Mesh(_, mesh) => Some(world_from_local.aabb(&mesh.bounds())),
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::*;
    use super::*;
    use rt_math::DVec3;
    use rt_scene_io::{GroupId, MaterialId};

    #[test]
    fn objects_are_named_by_their_path() {
        let mut scene = empty();
        let mut lamp = ball(DVec3::ZERO, 1.0);
        lamp.name = "lamp".into();
        scene.groups = vec![Group { name: "pair".into(), nodes: vec![ball(DVec3::ZERO, 1.0), lamp] }];
        let instance = Node::new(Content::Instance(GroupId(0)), MaterialId(0));
        let mut parent = ball(DVec3::ZERO, 1.0);
        parent.children = vec![instance];
        scene.nodes = vec![ball(DVec3::X, 1.0), parent];
        let objects = Objects::of(&scene);
        let names: Vec<_> = objects.list.iter().map(|object| objects.name(object)).collect();
        let inside = "nodes[1].children[0] > groups[\"pair\"]";
        assert_eq!(names, ["nodes[0]", "nodes[1]", &format!("{inside}[0]"), &format!("{inside}[1] \"lamp\"")]);
        assert_eq!(objects.group_used, [true]);
    }

    #[test]
    fn a_group_that_contains_itself_ends() {
        let mut scene = empty();
        let instance = || Node::new(Content::Instance(GroupId(0)), MaterialId(0));
        scene.groups = vec![Group { name: "loop".into(), nodes: vec![instance(), instance()] }];
        scene.nodes = vec![instance()];
        assert!(Objects::of(&scene).truncated);
    }
}
