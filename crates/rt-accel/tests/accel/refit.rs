//! Accelerators follow primitives that move.

use crate::soup::rays::{Query, adversarial};
use crate::soup::{Solid, Soup};
use rt_accel::{
    Aabb, Accelerator, Bih, BuildError, Bvh, Counters, CylinderTree, DVec3, Hit, Interval, LazyBih, Linear, NoProbe,
    Primitives, Refit, SphereTree, SplitMethod, WideBvh, brute_force,
};
use rt_tests::Draw;

/// The same solids, each moved by itself, and all of them far away.
fn shaken(soup: &Soup, by: f64, offset: DVec3, seed: u64) -> Soup {
    let mut draw = Draw::new(seed);
    Soup(soup.0.iter().map(|&solid| Soup(vec![solid]).moved(draw.point() * by + offset).0.swap_remove(0)).collect())
}

fn check<R: Refit + Clone + PartialEq + core::fmt::Debug>(name: &str, build: impl Fn(&Soup) -> R) {
    let mut start = Soup::mixed(&mut Draw::new(1));
    start.0.insert(5, Solid::Ground { height: -0.7 });
    let built = build(&start);
    let mut still = built.clone();
    still.refit(&start).unwrap();
    assert_eq!(still.validate(&start), Ok(()));
    for (by, offset) in [(0.1, DVec3::ZERO), (1.0, DVec3::ZERO), (0.3, DVec3::splat(1e6)), (0.0, DVec3::NEG_X * 1e3)] {
        let moved = shaken(&start, by, offset, 2);
        let mut accelerator = built.clone();
        accelerator.refit(&moved).unwrap();
        assert_eq!(accelerator.validate(&moved), Ok(()), "{name}");
        let world = Aabb::new(offset - 1.5, offset + 1.5);
        let mut draw = Draw::new(3);
        let mut counters = Counters::default();
        for _ in 0..3000 {
            let Query { ray, span } = adversarial(&moved, &world, &mut draw);
            let key = |hit: Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.primitive));
            let found = key(accelerator.closest(&moved, &ray, span, &mut counters));
            assert_eq!(found, key(brute_force::closest(&moved, &ray, span, &mut NoProbe)), "{name}: {ray:?}");
        }
        let tested = counters.total().tests as f64 / (3000 * moved.len()) as f64;
        assert!(by > 0.5 || name == "linear" || tested < 0.2, "{name}: {tested} of all primitives are tested");
    }
    refusals(name, &built, &start);
}

/// Rejected refits leave the accelerator unchanged.
fn refusals<R: Refit + Clone + PartialEq + core::fmt::Debug>(name: &str, built: &R, start: &Soup) {
    let mut accelerator = built.clone();
    let mut fewer = start.clone();
    fewer.0.pop();
    assert!(matches!(accelerator.refit(&fewer), Err(BuildError::Changed(_))), "{name}");
    let mut broken = start.clone();
    broken.0[7] = Solid::Box(Aabb::new(DVec3::NAN, DVec3::ONE));
    assert!(matches!(accelerator.refit(&broken), Err(BuildError::BadBounds { index: 7, .. })), "{name}");
    assert_eq!(accelerator, *built, "{name}");
    let nothing = Soup::default();
    assert!(accelerator.refit(&nothing).is_err(), "{name}");
}

#[test]
fn lists_follow() {
    check("linear", |soup| Linear::build(soup).unwrap());
}

#[test]
fn trees_of_boxes_follow() {
    check("bvh", |soup| Bvh::build(soup).unwrap());
    check("bvh by medians", |soup| Bvh::build_with(soup, SplitMethod::Median).unwrap());
    check("bvh with spatial splits", |soup| Bvh::build_with(soup, SplitMethod::Spatial).unwrap());
}

#[test]
fn wide_trees_follow() {
    check("wide", |soup| WideBvh::build(soup).unwrap());
    // Leaves hold copies of triangles, until these go too far from the origin for that.
    let start = Soup::facets(&mut Draw::new(4));
    for offset in [0.0, 3.0, 1e5] {
        let moved = shaken(&start, 0.01, DVec3::splat(offset), 5);
        let mut wide = WideBvh::build(&start).unwrap();
        wide.refit(&moved).unwrap();
        assert_eq!(wide.validate(&moved), Ok(()), "offset {offset}");
        for i in 0..200 {
            let from = DVec3::new(2.0, 1.0 + f64::from(i) * 0.01, -3.0) + offset;
            let ray = rt_accel::Ray::new(from, DVec3::splat(offset) - from);
            let hit = wide.closest(&moved, &ray, Interval::FORWARD, &mut NoProbe);
            assert_eq!(
                hit,
                brute_force::closest(&moved, &ray, Interval::FORWARD, &mut NoProbe),
                "offset {offset}, ray {i}"
            );
        }
    }
}

#[test]
fn trees_of_other_volumes_and_of_intervals_follow() {
    check("spheres", |soup| SphereTree::build(soup).unwrap());
    check("cylinders", |soup| CylinderTree::build(soup).unwrap());
    check("bih", |soup| Bih::build(soup).unwrap());
    check("lazy bih", |soup| LazyBih::build(soup).unwrap());
}

#[test]
fn what_has_not_moved_is_fitted_to_the_same_bits() {
    fn check<R: Refit + Clone + PartialEq + core::fmt::Debug>(built: R, soup: &Soup) {
        let mut accelerator = built.clone();
        assert_eq!(accelerator.refit(soup), Ok(()));
        assert_eq!(accelerator, built);
        accelerator.refit(&soup.clone().moved(DVec3::X)).unwrap();
        assert_ne!(accelerator, built);
    }
    let soup = Soup::mixed(&mut Draw::new(5));
    check(SphereTree::build(&soup).unwrap(), &soup);
    check(CylinderTree::build(&soup).unwrap(), &soup);
    check(Bih::build(&soup).unwrap(), &soup);
    check(LazyBih::build(&soup).unwrap(), &soup);
}

#[test]
fn a_primitive_that_loses_its_bounds_is_noticed() {
    let start = Soup::mixed(&mut Draw::new(1));
    let mut bvh = Bvh::build(&start).unwrap();
    let mut unbounded = start.clone();
    unbounded.0[3] = Solid::Ground { height: 0.0 };
    assert!(matches!(bvh.refit(&unbounded), Err(BuildError::Changed(_))));
    assert_eq!(bvh.validate(&start), Ok(()));
}

#[test]
fn an_empty_tree_follows_nothing() {
    let nothing = Soup::default();
    let mut bvh = Bvh::build(&nothing).unwrap();
    assert_eq!(bvh.refit(&nothing), Ok(()));
    let ray = rt_accel::Ray::new(DVec3::ZERO, DVec3::X);
    assert_eq!(bvh.closest(&nothing, &ray, Interval::FORWARD, &mut NoProbe), None);
    assert_eq!(nothing.len(), 0);
}
