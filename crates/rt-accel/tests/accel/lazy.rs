//! A tree that is built where rays go is the one that would have been built at once.

use std::ops::ControlFlow;
use std::sync::Barrier;

use crate::soup::Soup;
use crate::soup::rays::adversarial;
use rt_accel::{Aabb, Accelerator, Bih, Counters, DVec3, Interval, LazyBih, NoProbe, Primitives, Ray};
use rt_tests::Draw;

fn rays(soup: &Soup, count: usize) -> Vec<(Ray, Interval)> {
    let world = Aabb::new(DVec3::splat(-1.2), DVec3::splat(1.2));
    let mut draw = Draw::new(7);
    (0..count).map(|_| adversarial(soup, &world, &mut draw)).map(|query| (query.ray, query.span)).collect()
}

#[test]
fn only_what_rays_come_to_is_split() {
    let soup = Soup::spheres(20_000, &mut Draw::new(1));
    let lazy = LazyBih::build(&soup).unwrap();
    let full = Bih::build(&soup).unwrap().build_stats();
    let stats = lazy.build_stats();
    assert_eq!((stats.nodes, stats.leaves, stats.references), (0, 1, 20_000));
    let before = lazy.memory();

    let aside = Ray::new(DVec3::splat(9.0), DVec3::ONE);
    assert!(lazy.closest(&soup, &aside, Interval::FORWARD, &mut NoProbe).is_none());
    assert_eq!(lazy.build_stats(), stats);

    let across = Ray::new(DVec3::new(-3.0, 0.11, 0.23), DVec3::X);
    lazy.closest(&soup, &across, Interval::FORWARD, &mut NoProbe);
    let some = lazy.build_stats();
    assert!(some.nodes > 10 && some.nodes < full.nodes / 4, "{some:?} of {full:?}");
    assert!(lazy.memory() < before + before / 4, "lists of parents are freed: {} after {before}", lazy.memory());
    assert_eq!(lazy.validate(&soup), Ok(()));

    lazy.complete();
    assert_eq!(lazy.build_stats(), full);
    assert_eq!(lazy.validate(&soup), Ok(()));
    assert!(lazy.memory() < before, "{} after {before}", lazy.memory());
}

#[test]
fn a_search_splits_what_it_needs_as_rays_do() {
    let soup = Soup::spheres(5000, &mut Draw::new(1));
    let lazy = LazyBih::build(&soup).unwrap();
    lazy.visit_overlapping(&soup, &Aabb::new(DVec3::ZERO, DVec3::splat(0.1)), |_| ControlFlow::Continue(()));
    let some = lazy.build_stats();
    lazy.complete();
    assert!(some.nodes > 5 && some.nodes < lazy.build_stats().nodes / 4, "{some:?}");
}

#[test]
fn it_does_the_same_work_as_the_full_tree() {
    let soup = Soup::mixed(&mut Draw::new(3));
    let (lazy, full) = (LazyBih::build(&soup).unwrap(), Bih::build(&soup).unwrap());
    let [mut expected, mut counted] = [Counters::default(); 2];
    for (ray, span) in rays(&soup, 5000) {
        let hit = full.closest(&soup, &ray, span, &mut expected);
        assert_eq!(lazy.closest(&soup, &ray, span, &mut counted), hit, "{ray:?}");
        assert_eq!(counted, expected, "{ray:?}");
    }
    lazy.complete();
    assert_eq!(boxes(&lazy), boxes(&full));
}

fn boxes(accelerator: &impl Accelerator) -> Vec<(Aabb, u32)> {
    let mut all = Vec::new();
    accelerator.for_each_box(|aabb, depth| all.push((aabb, depth)));
    all
}

/// All threads begin at once, each with another ray, so that they race for the same nodes.
fn traced_by(n_threads: usize, soup: &Soup, rays: &[(Ray, Interval)]) -> LazyBih {
    let lazy = LazyBih::build(soup).unwrap();
    let start = Barrier::new(n_threads);
    std::thread::scope(|scope| {
        for thread in 0..n_threads {
            let (lazy, start) = (&lazy, &start);
            scope.spawn(move || {
                start.wait();
                for i in 0..rays.len() {
                    let (ray, span) = rays[(i + thread * rays.len() / n_threads) % rays.len()];
                    lazy.closest(soup, &ray, span, &mut NoProbe);
                }
            });
        }
    });
    lazy
}

#[test]
fn the_tree_is_the_same_whoever_comes_first() {
    let soup = Soup::spheres(3000, &mut Draw::new(5));
    let rays: Vec<_> = rays(&soup, 64);
    let expected = traced_by(1, &soup, &rays);
    assert_eq!(expected.validate(&soup), Ok(()));
    let n_nodes = expected.build_stats().nodes;
    let full = Bih::build(&soup).unwrap().build_stats().nodes;
    assert!(n_nodes > 100 && n_nodes < full, "part of the tree: {n_nodes} of {full}");
    for _ in 0..20 {
        assert!(traced_by(16, &soup, &rays) == expected);
    }
}

#[test]
fn it_can_be_looked_at_and_copied_while_rays_arrive() {
    let soup = Soup::spheres(3000, &mut Draw::new(5));
    let rays: Vec<_> = rays(&soup, 300);
    let lazy = LazyBih::build(&soup).unwrap();
    std::thread::scope(|scope| {
        for part in rays.chunks(100) {
            let (lazy, soup) = (&lazy, &soup);
            scope.spawn(move || {
                for (ray, span) in part {
                    lazy.closest(soup, ray, *span, &mut NoProbe);
                }
            });
        }
        for _ in 0..20 {
            let copy = lazy.clone();
            assert_eq!(copy.validate(&soup), Ok(()));
            assert!(lazy.build_stats().nodes >= copy.build_stats().nodes);
        }
    });
    assert!(lazy == lazy.clone());
    let part = lazy.clone();
    lazy.complete();
    assert!(lazy != part, "what has been split in one only tells them apart");
    part.complete();
    assert!(lazy == part);
}

#[test]
fn it_notices_that_primitives_have_changed() {
    let mut soup = Soup::spheres(300, &mut Draw::new(1));
    let lazy = LazyBih::build(&soup).unwrap();
    let moved = soup.clone().moved(DVec3::X);
    assert!(lazy.validate(&moved).is_err(), "before it is split");
    lazy.complete();
    assert!(lazy.validate(&moved).is_err());
    soup.0.pop();
    assert!(lazy.validate(&soup).is_err());
    assert_eq!(soup.len(), 299);
}
