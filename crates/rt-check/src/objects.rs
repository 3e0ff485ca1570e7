//! All objects of a scene in world space, with their paths in the node tree.

use std::fmt::Write;
use std::sync::Arc;

use rt_geometry::{Shape, TransformedShape, TriangleMesh};
use rt_math::{Aabb, Transform};
use rt_scene_io::{Content, Group, NamedMesh, Scene, SceneNode};
use rt_shading::{AlphaMode, Material};

use crate::singular_values::condition;

/// Largest number of nodes to visit; those of a group count once per instance.
pub(crate) const MAX_NODES: usize = 1 << 20;

/// Maximum nesting to visit; the renderer rejects more.
pub(crate) const MAX_DEPTH: usize = 1024;

#[derive(Clone, Copy, Debug)]
pub(crate) enum Geometry<'s> {
    Shape(&'s Shape),
    /// Mesh with its index in the scene.
    Mesh(usize, &'s TriangleMesh),
}

/// A shape or mesh in world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Object<'s> {
    tree_node: usize,
    pub(crate) geometry: Geometry<'s>,
    pub(crate) world_from_local: Transform,
    /// Product of the condition numbers of all transforms above the object: the possible growth of rounding errors.
    pub(crate) chain_condition: f64,
    pub(crate) material: usize,
    pub(crate) casts_shadow: bool,
    /// True below an odd number of [left-handed](SceneNode::is_left_handed) nodes.
    pub(crate) is_left_handed: bool,
    /// World space; `None` for an infinite object.
    pub(crate) bounds: Option<Aabb>,
}

impl Object<'_> {
    /// Maximum displacement of a point of the object by rounding in the transform, per axis.
    pub(crate) fn placement_error(&self) -> f64 {
        let local = match self.geometry {
            Geometry::Shape(shape) => shape.bounds(),
            Geometry::Mesh(_, mesh) => Some(mesh.bounds()),
        };
        let corners = local.map(|bounds| bounds.corners()).into_iter().flatten();
        let errors = corners.map(|p| self.world_from_local.point_with_error(p, rt_math::DVec3::ZERO).1.max_element());
        if self.world_from_local.is_identity() { 0.0 } else { errors.fold(0.0, f64::max) }
    }
}

/// A node with its position in the tree; a node of a group has one for each instance.
#[derive(Clone, Copy, Debug)]
struct TreeNode<'s> {
    parent: Option<usize>,
    /// Group of the node, if it was reached through an instance.
    group: Option<&'s Group>,
    index: usize,
    node: &'s SceneNode,
}

/// Bytes per node of a list of objects.
pub(crate) const NODE_BYTES: usize = size_of::<TreeNode<'_>>();

/// All objects of a scene in rendering order: of surfaces at the same distance, the first is visible.
#[derive(Debug)]
pub(crate) struct Objects<'s> {
    pub(crate) scene: &'s Scene,
    pub(crate) list: Vec<Object<'s>>,
    nodes: Vec<TreeNode<'s>>,
    pub(crate) group_used: Vec<bool>,
    /// True if the tree exceeds [`MAX_NODES`] or [`MAX_DEPTH`].
    pub(crate) truncated: bool,
}

/// Siblings still to visit.
struct Siblings<'s> {
    nodes: std::iter::Enumerate<std::slice::Iter<'s, SceneNode>>,
    parent: Option<usize>,
    group: Option<&'s Group>,
    world_from_parent: Transform,
    chain_condition: f64,
    casts_shadow: bool,
    is_left_handed: bool,
}

impl<'s> Objects<'s> {
    pub(crate) fn of(scene: &'s Scene) -> Self {
        let mut objects = Self {
            scene,
            list: Vec::new(),
            nodes: Vec::new(),
            group_used: vec![false; scene.groups.len()],
            truncated: false,
        };
        objects.traverse();
        objects
    }

    /// Visits all nodes depth first, with an explicit stack since trees may be deep.
    fn traverse(&mut self) {
        let mut open = vec![Siblings {
            nodes: self.scene.nodes.iter().enumerate(),
            parent: None,
            group: None,
            world_from_parent: Transform::IDENTITY,
            chain_condition: 1.0,
            casts_shadow: true,
            is_left_handed: false,
        }];
        while let Some(siblings) = open.last_mut() {
            let Some((index, node)) = siblings.nodes.next() else {
                open.pop();
                continue;
            };
            let place = TreeNode { parent: siblings.parent, group: siblings.group, index, node };
            let world_from_local = siblings.world_from_parent.compose(&node.parent_from_local);
            let chain_condition = siblings.chain_condition * condition(&node.parent_from_local.linear());
            let casts_shadow = siblings.casts_shadow && node.casts_shadow;
            let is_left_handed = siblings.is_left_handed != node.is_left_handed;
            if self.nodes.len() >= MAX_NODES || open.len() >= MAX_DEPTH {
                self.truncated = true;
                return;
            }
            let here = self.nodes.len();
            self.nodes.push(place);
            let below = |nodes: &'s [SceneNode], group| Siblings {
                nodes: nodes.iter().enumerate(),
                parent: Some(here),
                group,
                world_from_parent: world_from_local,
                chain_condition,
                casts_shadow,
                is_left_handed,
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
                    tree_node: here,
                    geometry,
                    world_from_local,
                    chain_condition,
                    material: node.material.0 as usize,
                    casts_shadow,
                    is_left_handed,
                    bounds: world_bounds(geometry, &world_from_local),
                });
            }
        }
    }

    /// Path of an object in the tree and its name, such as `nodes[2].children[0] "lamp"`.
    pub(crate) fn name(&self, object: &Object<'_>) -> String {
        let mut steps = Vec::new();
        let mut at = Some(object.tree_node);
        while let Some(place) = at.and_then(|index| self.nodes.get(index)) {
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
            debug_assert!(written.is_ok(), "writing to strings is infallible");
        }
        match steps.first().map(|place| place.node.name.as_str()) {
            Some("") | None => path,
            Some(name) => format!("{path} {name:?}"),
        }
    }

    /// Meshes of the scene; unnamed ones are named by index.
    pub(crate) fn meshes(&self) -> impl Iterator<Item = NamedMesh> {
        self.scene.meshes.iter().enumerate().map(|(index, named)| match named.name.as_str() {
            "" => NamedMesh { name: format!("mesh number {index}"), mesh: Arc::clone(&named.mesh) },
            _ => named.clone(),
        })
    }

    /// Material of an object; `None` if it does not exist.
    pub(crate) fn material(&self, object: &Object<'_>) -> Option<&'s Material> {
        self.scene.appearance.materials.get(object.material)
    }

    pub(crate) fn is_glass(&self, object: &Object<'_>) -> bool {
        self.material(object).is_some_and(|material| material.interior.is_some())
    }

    /// True if no ray passes the surface of an object.
    pub(crate) fn is_opaque(&self, object: &Object<'_>) -> bool {
        self.material(object).is_none_or(|material| {
            material.interior.is_none()
                && material.alpha.mode == AlphaMode::Opaque
                && material.to_phong().transmission.is_none()
        })
    }

    pub(crate) fn is_emissive(&self, object: &Object<'_>) -> bool {
        self.material(object).is_some_and(|material| !material.emission.is_zero())
    }

    /// Box around all bounded objects; empty if there are none.
    pub(crate) fn bounds(&self) -> Aabb {
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
    use super::*;
    use crate::fixture::*;
    use rt_math::DVec3;
    use rt_scene_io::{GroupId, MaterialId};

    #[test]
    fn objects_are_named_by_their_path() {
        let mut scene = empty();
        let mut emitter = sphere(DVec3::ZERO, 1.0);
        emitter.name = "lamp".into();
        scene.groups = vec![Group { name: "pair".into(), nodes: vec![sphere(DVec3::ZERO, 1.0), emitter] }];
        let instance = SceneNode::new(Content::Instance(GroupId(0)), MaterialId(0));
        let mut parent = sphere(DVec3::ZERO, 1.0);
        parent.children = vec![instance];
        scene.nodes = vec![sphere(DVec3::X, 1.0), parent];
        let objects = Objects::of(&scene);
        let names: Vec<_> = objects.list.iter().map(|object| objects.name(object)).collect();
        let inside = "nodes[1].children[0] > groups[\"pair\"]";
        assert_eq!(names, ["nodes[0]", "nodes[1]", &format!("{inside}[0]"), &format!("{inside}[1] \"lamp\"")]);
        assert_eq!(objects.group_used, [true]);
    }

    #[test]
    fn a_group_that_contains_itself_ends() {
        let mut scene = empty();
        let instance = || SceneNode::new(Content::Instance(GroupId(0)), MaterialId(0));
        scene.groups = vec![Group { name: "loop".into(), nodes: vec![instance(), instance()] }];
        scene.nodes = vec![instance()];
        assert!(Objects::of(&scene).truncated);
    }
}
