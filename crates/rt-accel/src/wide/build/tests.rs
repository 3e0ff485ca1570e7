//! What must hold of every tree.

use glam::Vec3A;
use rt_math::random::{hash, unit};

use super::*;

/// Boxes of all sizes, some of them flat, some with the same centre.
pub(super) fn soup(count: u32, seed: u64, scale: f32) -> Vec<Reference> {
    let reference = |index: u32| {
        let draw = |axis| unit(hash(&[seed, u64::from(index), axis])) as f32;
        let centre = Vec3A::new((draw(0) * 40.0).round(), draw(1) * 20.0, draw(2) * 3.0) - 10.0;
        let reach = Vec3A::new(draw(3), draw(4), (draw(5) * 2.0).floor()) * if draw(6) < 0.02 { 9.0 } else { 0.2 };
        Reference::new(NodeBox { min: (centre - reach) * scale, max: (centre + reach) * scale }, index)
    };
    (0..count).map(reference).collect()
}

fn points(count: u32, place: impl Fn(u32) -> Vec3A) -> Vec<Reference> {
    (0..count).map(|index| Reference::new(NodeBox { min: place(index), max: place(index) }, index)).collect()
}

fn with_quality(quality: Quality) -> BuildParams {
    BuildParams { quality, ..BuildParams::default() }
}

const QUALITIES: [Quality; 3] = [Quality::Low, Quality::Medium, Quality::High];

fn contains(outer: &NodeBox, inner: &NodeBox) -> bool {
    outer.min.cmple(inner.min).all() && outer.max.cmpge(inner.max).all()
}

/// Checks what is below a node, and returns the depth of the deepest leaf.
fn check_node(tree: &WideTree, number: usize, within: Option<&NodeBox>, own: &[NodeBox], max_leaf: usize) -> u32 {
    let node = &tree.nodes[number];
    let mut depth = 0;
    for (bounds, child) in node.boxes.iter().zip(&node.children).take(usize::from(node.count)) {
        assert!(within.is_none_or(|outer| contains(outer, bounds)));
        depth = depth.max(match *child {
            WideChild::Node(child) => {
                assert!(child as usize > number, "depth first");
                check_node(tree, child as usize, Some(bounds), own, max_leaf)
            }
            WideChild::Leaf { first, count } => {
                assert!((1..=max_leaf).contains(&(count as usize)));
                let leaf = &tree.order[first as usize..][..count as usize];
                assert!(leaf.is_sorted_by(|a, b| a < b));
                assert!(leaf.iter().all(|&index| contains(bounds, &own[index as usize])));
                0
            }
        });
    }
    depth + 1
}

/// Checks the whole tree; `references` are in order of their indices.
fn check(tree: &WideTree, references: &[Reference], max_leaf: usize) {
    let own: Vec<_> = references.iter().map(Reference::bounds).collect();
    let depth = check_node(tree, 0, None, &own, max_leaf);
    assert_eq!(depth, tree.depth.max(1));
    assert!(depth <= crate::bounded_depth::MAX_DEPTH);
    let runs = tree.nodes.iter().flat_map(|node| &node.children[..usize::from(node.count)]);
    let mut listed = vec![0; references.len()];
    for child in runs {
        if let WideChild::Leaf { first, count } = *child {
            tree.order[first as usize..][..count as usize].iter().for_each(|&index| listed[index as usize] += 1);
        }
    }
    assert!(listed.iter().all(|&times| times == 1));
}

#[test]
fn every_primitive_is_in_one_leaf_that_contains_it() {
    for quality in QUALITIES {
        for (count, seed) in [(0, 1), (1, 2), (2, 3), (3, 4), (9, 5), (100, 6), (5000, 7), (20_000, 8)] {
            let references = soup(count, seed, 1.0);
            check(&build(references.clone(), &with_quality(quality)), &references, 8);
        }
    }
}

#[test]
fn leaves_are_as_small_as_asked() {
    for max_leaf in [0, 1, 3, 100] {
        let references = soup(3000, 1, 1.0);
        let params = BuildParams { max_leaf, ..BuildParams::default() };
        check(&build(references.clone(), &params), &references, max_leaf.clamp(1, 8));
    }
}

#[test]
fn any_scale_is_bounded() {
    for quality in QUALITIES {
        for scale in [0.0, 1e-44, 1e-38, 1e-20, 1e18, 1e30, 1e36, f32::INFINITY] {
            let finite = soup(6000, 3, scale).into_iter().all(|reference| !reference.bounds().min.is_nan());
            let references = if finite { soup(6000, 3, scale) } else { points(6000, |_| Vec3A::INFINITY) };
            check(&build(references.clone(), &with_quality(quality)), &references, 8);
        }
    }
}

#[test]
fn nasty_sets_are_bounded() {
    let sets = [
        points(300_000, |_| Vec3A::splat(0.1)),
        points(10_000, |i| Vec3A::X * f32::from_bits(i % 3000)),
        // Ever smaller distances, which bins cut off one by one.
        points(5000, |i| Vec3A::splat(f32::from_bits((i % 250) << 23))),
        points(5000, |i| [Vec3A::splat(f32::MAX), Vec3A::splat(f32::MIN), Vec3A::ZERO][i as usize % 3]),
        points(5000, |i| [Vec3A::INFINITY, Vec3A::NEG_INFINITY, Vec3A::ZERO][i as usize % 3]),
    ];
    for quality in QUALITIES {
        for references in &sets {
            check(&build(references.clone(), &with_quality(quality)), references, 8);
        }
    }
}

#[test]
fn ten_boxes_in_two_heaps_become_two_leaves() {
    let heap = |min: Vec3A| NodeBox { min, max: min + Vec3A::new(8.0, 0.0, 4.0) };
    let heaps = [heap(Vec3A::ZERO), heap(Vec3A::X * 100.0)];
    let references = (0..10).map(|index| Reference::new(heaps[index as usize % 2], index)).collect();
    let tree = build(references, &BuildParams::default());
    assert_eq!((tree.nodes.len(), tree.nodes[0].count, tree.depth), (1, 2, 1));
    assert_eq!(tree.order, [0, 2, 4, 6, 8, 1, 3, 5, 7, 9]);
    assert_eq!(tree.nodes[0].boxes[..2], heaps);
    // The areas are 8 · 4 of 108 · 4 each.
    let expected = 1.0 + 2.0 * (32.0 / 432.0) * (0.6 + 0.1 * 5.0);
    assert!((tree.sah_cost - expected).abs() < 1e-6, "{}", tree.sah_cost);
}

#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_grows_the_same_tree() {
    for quality in QUALITIES {
        let references = soup(100_000, 5, 1.0);
        let with_threads = |count| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("a pool");
            pool.install(|| build(references.clone(), &with_quality(quality)))
        };
        let alone = with_threads(1);
        assert_eq!(with_threads(2), alone);
        assert_eq!(with_threads(3), alone);
    }
}

#[test]
fn more_time_makes_no_dearer_tree() {
    for seed in 0..4 {
        let [_, medium, high] = QUALITIES.map(|quality| build(soup(8000, seed, 1.0), &with_quality(quality)).sah_cost);
        assert!(high <= medium, "{high} {medium}");
    }
}
