//! Known extents, counted updates, and random edits against a fresh start.

use super::*;
use crate::{Group, MaterialId};
use proptest::prelude::*;
use rt_geometry::{Plane, Shape, Sphere};
use rt_math::DVec3;

fn sphere(centre: DVec3) -> Node {
    Node::new(Content::Shape(Shape::Sphere(Sphere::new(centre, 1.0).unwrap())), MaterialId(0))
}

fn instance(group: u32, offset: DVec3) -> Node {
    let parent_from_local = Transform::translate(offset);
    Node { parent_from_local, ..Node::new(Content::Instance(GroupId(group)), MaterialId(0)) }
}

fn holder(children: Vec<Node>) -> Node {
    Node { content: None, children, ..sphere(DVec3::ZERO) }
}

fn node_mut<'s>(scene: &'s mut Scene, tree: Tree, path: &[usize]) -> &'s mut Node {
    let nodes = match tree {
        Tree::World => &mut scene.nodes,
        Tree::Group(id) => &mut scene.groups[id.0 as usize].nodes,
    };
    path[1..].iter().fold(&mut nodes[path[0]], |node, &child| &mut node.children[child])
}

/// All nodes, with the trees themselves.
fn all_paths(scene: &Scene) -> Vec<(Tree, Vec<usize>)> {
    let groups = (0..scene.groups.len()).map(|id| (Tree::Group(GroupId(id as u32)), &scene.groups[id].nodes));
    let mut paths = Vec::new();
    for (tree, nodes) in groups.chain([(Tree::World, &scene.nodes)]) {
        let mut open: Vec<(Vec<usize>, &[Node])> = vec![(Vec::new(), nodes)];
        while let Some((path, nodes)) = open.pop() {
            open.extend(nodes.iter().enumerate().map(|(i, node)| ([path.as_slice(), &[i]].concat(), &*node.children)));
            paths.push((tree, path));
        }
    }
    paths
}

fn assert_as_fresh(bounds: &SceneBounds, scene: &Scene) -> Result<(), TestCaseError> {
    let fresh = SceneBounds::new(scene);
    for (tree, path) in all_paths(scene) {
        prop_assert_eq!(bounds.of(tree, &path), fresh.of(tree, &path), "{:?} {:?}", tree, path);
    }
    Ok(())
}

/// A tree with ten children at each node, four levels deep: 11 110 nodes, spheres along x at the lowest level.
fn decimal_tree() -> Scene {
    let mut scene = Scene::empty("decimal");
    let mut nodes: Vec<Node> = (0..10_000).map(|i| sphere(DVec3::X * f64::from(i))).collect();
    while nodes.len() > 10 {
        let mut rest = nodes.into_iter();
        nodes =
            std::iter::from_fn(|| Some(holder(rest.by_ref().take(10).collect())).filter(|n| !n.children.is_empty()))
                .collect();
    }
    scene.nodes = nodes;
    scene
}

#[test]
fn moving_one_of_ten_thousand_nodes_measures_it_and_its_ancestors_only() {
    let mut scene = decimal_tree();
    let mut bounds = SceneBounds::new(&scene);
    let path = [9, 9, 9, 9];
    node_mut(&mut scene, Tree::World, &path).parent_from_local = Transform::translate(DVec3::X * 100.0);
    assert_eq!(bounds.update(&scene, Tree::World, &path), Some(4));
    assert!((bounds.world().bounds.max.x - 10_100.0).abs() < 1e-9);
    assert_as_fresh(&bounds, &scene).unwrap();
    // What happens within the box of the siblings concerns nothing above.
    let path = [4, 4, 4, 4];
    let small = Sphere::new(DVec3::X * 4444.5, 0.5).unwrap();
    node_mut(&mut scene, Tree::World, &path).content = Some(Content::Shape(Shape::Sphere(small)));
    assert_eq!(bounds.update(&scene, Tree::World, &path), Some(2));
    assert_as_fresh(&bounds, &scene).unwrap();
}

#[test]
fn a_changed_group_changes_all_its_instances_and_their_ancestors_once_each() {
    let mut scene = Scene::empty("instances");
    scene.groups.push(Group { name: "ball".to_owned(), nodes: vec![holder(vec![sphere(DVec3::ZERO)])] });
    scene.groups.push(Group { name: "two".to_owned(), nodes: vec![instance(0, DVec3::X), instance(0, DVec3::Y)] });
    let family = holder(vec![instance(1, DVec3::ZERO), instance(0, DVec3::Z * 9.0), sphere(DVec3::ZERO)]);
    scene.nodes = vec![holder(vec![family]), sphere(DVec3::NEG_ONE)];
    let mut bounds = SceneBounds::new(&scene);
    let path = [0, 0];
    let tree = Tree::Group(GroupId(0));
    node_mut(&mut scene, tree, &path).parent_from_local = Transform::scale(DVec3::splat(20.0)).unwrap();
    // The ball and its holder; two instances in the second group; in the world two instances and two holders.
    assert_eq!(bounds.update(&scene, tree, &path), Some(2 + 2 + 4));
    assert_as_fresh(&bounds, &scene).unwrap();
    assert!((bounds.world().bounds.max - DVec3::new(21.0, 21.0, 29.0)).length() < 1e-9);
    assert!((bounds.group(GroupId(1)).unwrap().bounds.max - DVec3::new(21.0, 21.0, 20.0)).length() < 1e-9);
}

#[test]
fn own_extents_are_local_and_those_of_subtrees_are_the_parents() {
    let mut scene = Scene::empty("spaces");
    scene.nodes = vec![Node { children: vec![sphere(DVec3::Y)], ..sphere(DVec3::ZERO) }];
    scene.nodes[0].parent_from_local = Transform::scale(DVec3::splat(2.0)).unwrap();
    let of = SceneBounds::new(&scene).of(Tree::World, &[0]).unwrap();
    assert!((of.own.bounds.max - DVec3::ONE).length() < 1e-12);
    assert!((of.subtree.bounds.max - DVec3::new(2.0, 4.0, 2.0)).length() < 1e-12);
}

#[test]
fn the_unbounded_is_told_upwards_and_forgotten() {
    let mut scene = Scene::empty("floor");
    let plane = Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Y).unwrap());
    scene.groups.push(Group { name: "floor".to_owned(), nodes: vec![sphere(DVec3::ZERO)] });
    scene.groups[0].nodes[0].content = Some(Content::Shape(plane));
    scene.nodes = vec![holder(vec![instance(0, DVec3::X)])];
    let mut bounds = SceneBounds::new(&scene);
    assert_eq!(bounds.world(), Extent { bounds: Aabb::EMPTY, unbounded: true });
    scene.groups[0].nodes[0].content = None;
    assert_eq!(bounds.update(&scene, Tree::Group(GroupId(0)), &[0]), Some(3));
    assert_eq!(bounds.world(), Extent::NOTHING);
}

#[test]
fn paths_that_lead_nowhere_and_dangling_ids_are_answered() {
    let mut scene = Scene::empty("nothing");
    scene.nodes = vec![instance(3, DVec3::X), Node::new(Content::Mesh(MeshId(7)), MaterialId(0))];
    let mut bounds = SceneBounds::new(&scene);
    assert_eq!(bounds.world(), Extent::NOTHING);
    assert_eq!(bounds.of(Tree::World, &[2]), None);
    assert_eq!(bounds.of(Tree::Group(GroupId(0)), &[]), None);
    assert_eq!(bounds.group(GroupId(0)), None);
    assert_eq!(bounds.update(&scene, Tree::World, &[0, 0]), None);
    scene.nodes.clear();
    assert_eq!(bounds.update(&scene, Tree::World, &[0]), None);
    assert_eq!(bounds.update(&scene, Tree::World, &[]), Some(0));
    assert_eq!(bounds.of(Tree::World, &[0]), None);
    // A group that contains itself has the extent of what else is in it.
    scene.groups.push(Group { name: "loop".to_owned(), nodes: vec![instance(0, DVec3::X), sphere(DVec3::ZERO)] });
    let extent = SceneBounds::new(&scene).group(GroupId(0)).unwrap();
    assert!((extent.bounds.max - DVec3::ONE).length() < 1e-12);
}

#[test]
fn deep_trees_fit_the_stack() {
    const DEPTH: usize = 100_000;
    let mut node = sphere(DVec3::ZERO);
    for _ in 1..DEPTH {
        node = holder(vec![node]);
    }
    let mut scene = Scene::empty("deep");
    scene.nodes = vec![node];
    let mut bounds = SceneBounds::new(&scene);
    let path = vec![0; DEPTH];
    node_mut(&mut scene, Tree::World, &path).parent_from_local = Transform::translate(DVec3::X);
    assert_eq!(bounds.update(&scene, Tree::World, &path), Some(DEPTH));
    assert_eq!(bounds.update_below(&scene, Tree::World, &[0]), Some(DEPTH));
    // Nodes own their children, and dropping a chain of them takes the stack that is spared here.
    std::mem::forget(scene);
}

fn any_node() -> impl Strategy<Value = Node> {
    let content = prop_oneof![
        (-9.0..9.0f64).prop_map(|x| sphere(DVec3::new(x, 1.0, -x)).content),
        Just(Some(Content::Shape(Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Y).unwrap())))),
        (0..4u32).prop_map(|id| Some(Content::Instance(GroupId(id)))),
        Just(None),
    ];
    let leaf = (content, any_transform()).prop_map(|(content, parent_from_local)| Node {
        content,
        parent_from_local,
        ..sphere(DVec3::ZERO)
    });
    leaf.prop_recursive(3, 12, 4, |child| {
        (child.clone(), prop::collection::vec(child, 0..4)).prop_map(|(node, children)| Node { children, ..node })
    })
}

fn any_transform() -> impl Strategy<Value = Transform> {
    (prop::array::uniform3(-5.0..5.0f64), -3.0..3.0f64, 0.2..3.0f64).prop_map(|(offset, angle, factor)| {
        let turned = Transform::rotate(DVec3::new(1.0, 2.0, -1.0), angle).unwrap();
        Transform::translate(offset.into()).compose(&turned).compose(&Transform::scale(DVec3::splat(factor)).unwrap())
    })
}

fn any_scene() -> impl Strategy<Value = Scene> {
    let nodes = || prop::collection::vec(any_node(), 0..4);
    (prop::collection::vec(nodes(), 3), nodes()).prop_map(|(groups, nodes)| {
        let mut scene = Scene::empty("any");
        scene.groups = groups.into_iter().map(|nodes| Group { name: String::new(), nodes }).collect();
        scene.nodes = nodes;
        scene
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn updates_give_the_bits_of_a_fresh_start(
        mut scene in any_scene(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), any_node(), any_transform(), 0..4u32), 1..8),
    ) {
        let mut bounds = SceneBounds::new(&scene);
        for (target, node, place, kind) in edits {
            let (tree, path) = target.get(&all_paths(&scene)).clone();
            if path.is_empty() {
                let nodes = match tree {
                    Tree::World => &mut scene.nodes,
                    Tree::Group(id) => &mut scene.groups[id.0 as usize].nodes,
                };
                nodes.push(node);
                prop_assert!(bounds.update(&scene, tree, &path).is_some());
            } else {
                let edited = node_mut(&mut scene, tree, &path);
                match kind {
                    0 => edited.parent_from_local = place,
                    1 => edited.content = node.content,
                    2 => edited.children.push(node),
                    _ => *edited = node,
                }
                let updated = if kind == 3 {
                    bounds.update_below(&scene, tree, &path)
                } else {
                    bounds.update(&scene, tree, &path)
                };
                prop_assert!(updated.is_some());
            }
            assert_as_fresh(&bounds, &scene)?;
        }
    }

    #[test]
    fn the_world_contains_the_bounds_of_the_scene(scene in any_scene()) {
        let (propagated, exact) = (SceneBounds::new(&scene).world().bounds, scene.bounds());
        prop_assert!(exact.is_empty() || propagated.padded().encloses(&exact), "{:?} in {:?}", exact, propagated);
    }
}
