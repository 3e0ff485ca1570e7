//! Bounds over the tree of a scene.

use rt_geometry::Shape;
use rt_math::{Aabb, AnimatedTransformChain};

use crate::{Content, Group, GroupId, MeshId, NamedMesh, Scene, SceneNode};

impl Scene {
    /// Box around all bounded objects, in world space, at all times; empty without any.
    ///
    /// Infinite planes do not count. Neither do instances of a group that does not precede the group they are in.
    pub fn bounds(&self) -> Aabb {
        tree_bounds(&self.nodes, &self.groups, &self.meshes)
    }
}

/// [`Scene::bounds`] of the parts of a scene.
pub(crate) fn tree_bounds(nodes: &[SceneNode], groups: &[Group], meshes: &[NamedMesh]) -> Aabb {
    // Each group is measured once, in its own space, however often it is placed.
    let mut measured = Vec::with_capacity(groups.len());
    for group in groups {
        measured.push(measure(&group.nodes, &measured, meshes));
    }
    measure(nodes, &measured, meshes)
}

/// The box around nodes, in the space of their parent. Trees may be deep, so the walk keeps its own stack.
fn measure(nodes: &[SceneNode], groups: &[Aabb], meshes: &[NamedMesh]) -> Aabb {
    let mut sum = Aabb::EMPTY;
    let here = AnimatedTransformChain::IDENTITY;
    let mut open: Vec<(&SceneNode, AnimatedTransformChain)> = nodes.iter().map(|node| (node, here.clone())).collect();
    while let Some((node, outer)) = open.pop() {
        // A motion that cannot be interpolated is ignored.
        let outer_from_local =
            node.place_below(&outer).unwrap_or_else(|_| outer.clone().compose(&node.parent_from_local));
        let local = node.content.as_ref().map_or(Aabb::EMPTY, |content| content_bounds(content, groups, meshes));
        if !local.is_empty() {
            sum = sum.union(outer_from_local.aabb(&local));
        }
        open.extend(node.children.iter().map(|child| (child, outer_from_local.clone())));
    }
    sum
}

fn content_bounds(content: &Content, groups: &[Aabb], meshes: &[NamedMesh]) -> Aabb {
    match content {
        Content::Shape(shape) => Shape::bounds(shape).unwrap_or(Aabb::EMPTY),
        Content::Mesh(MeshId(id)) => meshes.get(*id as usize).map_or(Aabb::EMPTY, |mesh| mesh.mesh.bounds()),
        Content::Instance(GroupId(id)) => groups.get(*id as usize).copied().unwrap_or(Aabb::EMPTY),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MaterialId;
    use rt_geometry::{Plane, Sphere};
    use rt_math::{DVec3, Transform};

    fn sphere(centre: DVec3) -> SceneNode {
        SceneNode::new(Content::Shape(Shape::Sphere(Sphere::new(centre, 1.0).unwrap())), MaterialId(0))
    }

    fn close(bounds: Aabb, min: [f64; 3], max: [f64; 3]) {
        assert!((bounds.min - DVec3::from(min)).length() < 1e-9, "{bounds:?}");
        assert!((bounds.max - DVec3::from(max)).length() < 1e-9, "{bounds:?}");
    }

    #[test]
    fn transforms_and_instances_are_followed() {
        let mut scene = Scene::empty("test");
        let moved = Transform::translate(DVec3::new(10.0, 0.0, 0.0));
        scene.groups.push(Group { name: "ball".to_owned(), nodes: vec![sphere(DVec3::ZERO)] });
        let mut instance = SceneNode::new(Content::Instance(GroupId(0)), MaterialId(0));
        instance.parent_from_local = Transform::scale(DVec3::splat(2.0)).unwrap();
        let parent =
            SceneNode { content: None, parent_from_local: moved, children: vec![instance], ..sphere(DVec3::ZERO) };
        scene.nodes = vec![parent, sphere(DVec3::ZERO)];
        close(scene.bounds(), [-1.0, -2.0, -2.0], [12.0, 2.0, 2.0]);
    }

    #[test]
    fn planes_and_dangling_ids_have_no_bounds() {
        let mut scene = Scene::empty("test");
        let plane = Plane::new(DVec3::ZERO, DVec3::Y).unwrap();
        scene.nodes.push(SceneNode::new(Content::Shape(Shape::Plane(plane)), MaterialId(0)));
        scene.nodes.push(SceneNode::new(Content::Mesh(MeshId(7)), MaterialId(0)));
        scene.nodes.push(SceneNode::new(Content::Instance(GroupId(7)), MaterialId(0)));
        assert!(scene.bounds().is_empty());
        // A group that contains itself does not hang.
        scene.groups.push(Group { name: "loop".to_owned(), nodes: vec![scene.nodes[2].clone(), sphere(DVec3::ZERO)] });
        scene.groups[0].nodes[0].content = Some(Content::Instance(GroupId(0)));
        scene.nodes = vec![SceneNode::new(Content::Instance(GroupId(0)), MaterialId(0))];
        close(scene.bounds(), [-1.0; 3], [1.0; 3]);
    }
}
