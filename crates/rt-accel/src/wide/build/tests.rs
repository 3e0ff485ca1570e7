//! Invariants of every tree.

use glam::Vec3A;
use rt_math::random::{hash, unit};

use super::*;
use crate::wide::leaf::LeafOrder;
use crate::{bvh::Aabb32, wide::node::Child, wide::sah::sah_cost};

fn build(references: &[PrimRef], params: &BuildParams) -> WideTree {
    let config = BuildConfig::new(&extent(references).bounds, params);
    let mut list = Vec::new();
    references.iter().for_each(|&reference| config.push(&mut list, reference));
    let scratch = vec![PrimRef::NONE; list.len()];
    over(Gathered { references: list, scratch }, &config, LeafKind::Boxes, params.quality).expect("few nodes")
}

/// Boxes of all sizes, some of them flat, some with the same centre.
pub(super) fn soup(count: u32, seed: u64, scale: f32) -> Vec<PrimRef> {
    let reference = |index: u32| {
        let draw = |axis| unit(hash(&[seed, u64::from(index), axis])) as f32;
        let centre = Vec3A::new((draw(0) * 40.0).round(), draw(1) * 20.0, draw(2) * 3.0) - 10.0;
        let reach = Vec3A::new(draw(3), draw(4), (draw(5) * 2.0).floor()) * if draw(6) < 0.02 { 9.0 } else { 0.2 };
        PrimRef::new(Aabb32 { min: (centre - reach) * scale, max: (centre + reach) * scale }, index)
    };
    (0..count).map(reference).collect()
}

fn points(count: u32, place: impl Fn(u32) -> Vec3A) -> Vec<PrimRef> {
    (0..count).map(|index| PrimRef::new(Aabb32 { min: place(index), max: place(index) }, index)).collect()
}

fn with_quality(quality: Quality) -> BuildParams {
    BuildParams { quality, ..BuildParams::default() }
}

const QUALITIES: [Quality; 3] = [Quality::Low, Quality::Medium, Quality::High];

fn contains(outer: &Aabb32, inner: &Aabb32) -> bool {
    outer.min.cmple(inner.min).all() && outer.max.cmpge(inner.max).all()
}

/// Checks a subtree, and returns the depth of its deepest leaf.
fn check_node(
    nodes: &[WideNode],
    number: usize,
    within: Option<&Aabb32>,
    leaf: &mut impl FnMut(Child, &Aabb32),
) -> u32 {
    let mut depth = 0;
    for (bounds, child) in nodes[number].children() {
        assert!(within.is_none_or(|outer| contains(outer, &bounds)));
        depth = depth.max(if child.is_node() {
            assert!(child.number() > number, "children come after their parents");
            check_node(nodes, child.number(), Some(&bounds), leaf)
        } else {
            leaf(child, &bounds);
            0
        });
    }
    depth + 1
}

/// Checks the whole tree; `references` are in order of their indices.
fn check(tree: &WideTree, references: &[PrimRef], max_leaf: usize) {
    let own: Vec<_> = references.iter().map(PrimRef::bounds).collect();
    // By cache line.
    let mut lists = std::collections::BTreeMap::new();
    let mut n_lines = 0;
    for listing in &tree.listings {
        let mut part = LeafOrder::default();
        for leaf in listing.leaves() {
            lists.insert(n_lines + part.n_lines, leaf);
            part.order.extend(leaf);
            part.close(part.order.len() - leaf.len(), LeafKind::Boxes);
        }
        assert_eq!(&part, listing);
        n_lines += part.n_lines;
    }
    let mut listed = vec![0; references.len()];
    let depth = check_node(&tree.nodes, 0, None, &mut |child, bounds| {
        let leaf = lists[&child.number()];
        assert!(leaf.len() == child.count() && (1..=max_leaf).contains(&leaf.len()));
        assert!(leaf.is_sorted_by(|a, b| a < b));
        assert!(leaf.iter().all(|&index| contains(bounds, &own[index as usize])));
        leaf.iter().for_each(|&index| listed[index as usize] += 1);
    });
    assert_eq!(depth, tree.depth.max(1));
    assert!(depth <= MAX_DEPTH);
    assert!(listed.iter().all(|&times| times == 1));
}

#[test]
fn every_primitive_is_in_one_leaf_that_contains_it() {
    for quality in QUALITIES {
        for (count, seed) in [(0, 1), (1, 2), (2, 3), (3, 4), (9, 5), (100, 6), (5000, 7), (20_000, 8)] {
            let references = soup(count, seed, 1.0);
            check(&build(&references, &with_quality(quality)), &references, 8);
        }
    }
}

#[test]
fn leaves_respect_the_maximum_size() {
    for max_leaf in [0, 1, 3, 100] {
        let references = soup(3000, 1, 1.0);
        let params = BuildParams { max_leaf, ..BuildParams::default() };
        check(&build(&references, &params), &references, max_leaf.clamp(1, 8));
    }
}

#[test]
fn any_scale_is_bounded() {
    for quality in QUALITIES {
        for scale in [0.0, 1e-44, 1e-38, 1e-20, 1e18, 1e30, 1e36, f32::INFINITY] {
            let finite = soup(6000, 3, scale).into_iter().all(|reference| !reference.bounds().min.is_nan());
            let references = if finite { soup(6000, 3, scale) } else { points(6000, |_| Vec3A::INFINITY) };
            check(&build(&references, &with_quality(quality)), &references, 8);
        }
    }
}

#[test]
fn nasty_sets_are_bounded() {
    let sets = [
        points(300_000, |_| Vec3A::splat(0.1)),
        points(10_000, |i| Vec3A::X * f32::from_bits(i % 3000)),
        // Ever smaller distances, which bins split off one by one.
        points(5000, |i| Vec3A::splat(f32::from_bits((i % 250) << 23))),
        points(5000, |i| [Vec3A::splat(f32::MAX), Vec3A::splat(f32::MIN), Vec3A::ZERO][i as usize % 3]),
        points(5000, |i| [Vec3A::INFINITY, Vec3A::NEG_INFINITY, Vec3A::ZERO][i as usize % 3]),
    ];
    for quality in QUALITIES {
        for references in &sets {
            check(&build(references, &with_quality(quality)), references, 8);
        }
    }
}

#[test]
fn ten_boxes_in_two_heaps_become_two_leaves() {
    let heap = |min: Vec3A| Aabb32 { min, max: min + Vec3A::new(8.0, 0.0, 4.0) };
    let heaps = [heap(Vec3A::ZERO), heap(Vec3A::X * 100.0)];
    let references: Vec<_> = (0..10).map(|index| PrimRef::new(heaps[index as usize % 2], index)).collect();
    let tree = build(&references, &BuildParams::default());
    let boxes: Vec<_> = tree.nodes[0].children().map(|(bounds, _)| bounds).collect();
    assert_eq!((tree.nodes.len(), boxes, tree.depth), (1, heaps.to_vec(), 1));
    assert_eq!(tree.listings[0].order, [0, 2, 4, 6, 8, 1, 3, 5, 7, 9]);
    // The areas are 8 · 4 of 108 · 4 each.
    let (expected, cost) = (1.0 + 2.0 * (32.0 / 432.0) * (0.6 + 0.1 * 5.0), sah_cost(&tree.nodes).expect("an area"));
    assert!((cost - expected).abs() < 1e-6, "{cost}");
}

#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_grows_the_same_tree() {
    for quality in QUALITIES {
        // Enough for parallel partitions.
        let references = soup(70_000, 5, 1.0);
        let with_threads = |count| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("a pool");
            pool.install(|| build(&references, &with_quality(quality)))
        };
        assert_eq!(with_threads(3), with_threads(1));
    }
}

#[test]
fn more_time_makes_no_dearer_tree() {
    for seed in 0..4 {
        let references = soup(8000, seed, 1.0);
        let cost = |quality| sah_cost(&build(&references, &with_quality(quality)).nodes);
        let [_, medium, high] = QUALITIES.map(cost);
        assert!(medium.is_some() && high <= medium, "{high:?} {medium:?}");
    }
}
