//! Batches give the results of single queries: for coherent bundles, incoherent rays and mixes, in small and large trees.

#![allow(clippy::unwrap_used, reason = "tests fail by panicking")]

mod soup;

use std::sync::atomic::{AtomicU32, Ordering};

use rt_accel::wide::{SimdLevel, SmallSet};
use rt_accel::{
    Aabb, Accelerator, BatchKernel, Bvh, Counters, DVec3, Hit, Interval, Linear, NoProbe, PrimitiveGeometry,
    Primitives, Probe, Ray, SphereKernel, WideBvh, brute_force,
};
use rt_math::Vec3;
use soup::draw::Draw;
use soup::rays::{Query, adversarial};
use soup::{Solid, Soup, sheet};

/// Rays in bundles of 1 to 20, or of 100 and more: neighbours of one ray, with the same origin or nearby ones.
fn bundles(soup: &Soup, n_rays: usize, draw: &mut Draw) -> Vec<(Ray, Interval)> {
    let world = Aabb::from_points(soup.0.iter().filter_map(Solid::bounds).flat_map(|bounds| [bounds.min, bounds.max]));
    let size = world.extent().max_element();
    let mut rays = Vec::new();
    while rays.len() < n_rays {
        let Query { ray, span } = if draw.one_in(2) {
            adversarial(soup, &world, draw)
        } else {
            let origin = world.centre() + draw.point() * size;
            Query {
                ray: Ray::new(origin, world.centre() + draw.point() * size * 0.4 - origin),
                span: Interval::FORWARD,
            }
        };
        let spread = draw.pick(&[0.0, 1e-9, 1e-3, 0.05]);
        // In proportion to each component, or to the maximum, so that signs change.
        let around = if draw.one_in(2) { ray.direction } else { DVec3::splat(ray.direction.abs().max_element()) };
        let width = if draw.one_in(2) { size * draw.pick(&[0.0, 1e-9, 0.01]) } else { 0.0 };
        let n = if draw.one_in(8) { 100 + draw.below(200) } else { 1 + draw.below(20) };
        for _ in 0..n {
            let jitter = draw.point() * spread;
            let (origin, direction) = (ray.origin + draw.point() * width, ray.direction + around * jitter);
            rays.push((Ray { origin, direction, ..ray }, span));
        }
    }
    rays.truncate(n_rays);
    rays
}

fn key(hit: Option<Hit>) -> Option<(u64, u32, u32, [u64; 2])> {
    hit.map(|hit| (hit.t.to_bits(), hit.instance, hit.primitive, hit.uv.map(f64::to_bits)))
}

/// Traces a batch for closest and any hits: of trees and of small sets, which share no trait.
macro_rules! trace_batch {
    ($accel:expr, $primitives:expr, $rays:expr, $counters:expr) => {{
        let (mut hits, mut occluded) = (vec![None; $rays.len()], vec![false; $rays.len()]);
        $accel.closest_batch($primitives, $rays, &mut hits, $counters);
        $accel.occluded_batch($primitives, $rays, &mut occluded, $counters);
        (hits, occluded)
    }};
}

/// Compares batches of all sizes with single queries.
fn compare<A: Accelerator>(name: &str, structure: &A, soup: &Soup, n_rays: usize, draw: &mut Draw) {
    let rays = bundles(soup, n_rays, draw);
    let (mut n_hits, mut first) = (0, 0);
    let (mut single, mut batched) = (Counters::default(), Counters::default());
    while first < rays.len() {
        let n = draw.pick(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12, 64, 1000]).min(rays.len() - first);
        let rays = &rays[first..first + n];
        let mut hits = vec![None; n];
        let mut blocked = vec![false; n];
        structure.closest_batch(soup, rays, &mut hits, &mut batched);
        structure.occluded_batch(soup, rays, &mut blocked, &mut NoProbe);
        for (i, (ray, span)) in rays.iter().enumerate() {
            let expected = structure.closest(soup, ray, *span, &mut single);
            assert_eq!(key(hits[i]), key(expected), "{name}, ray {}: {ray:?} {span:?}", first + i);
            assert_eq!(blocked[i], expected.is_some(), "{name}, ray {}: {ray:?} {span:?}", first + i);
            n_hits += usize::from(expected.is_some());
        }
        first += n;
    }
    assert!(n_hits > n_rays / 10, "{name}: {n_hits} hits");
    let (single, batched) = (single.total(), batched.total());
    // Work shared by many rays is counted once, so batches may do much less.
    let is_no_more = |batched: u64, single: u64| batched as f64 <= 1.5 * single as f64 && 16 * batched > single;
    assert!(
        is_no_more(batched.nodes, single.nodes) && is_no_more(batched.tests, single.tests),
        "{name}: {single:?} {batched:?}"
    );
    // Few exact hits are computed beyond the results.
    assert!(
        batched.hits >= n_hits as u64 && batched.hits as f64 <= 1.1 * single.hits as f64,
        "{name}: {n_hits} hits, {single:?} {batched:?}"
    );
}

fn levels() -> impl Iterator<Item = SimdLevel> {
    SimdLevel::ALL.iter().copied().filter(|level| level.is_available())
}

#[test]
fn batches_through_small_trees_equal_single_queries() {
    let seed = Draw::run_seed();
    println!("batches: seed {seed}");
    type Kind = (&'static str, fn(&mut Draw) -> Soup);
    let kinds: [Kind; 10] = [
        ("facets", Soup::facets),
        ("triangles", Soup::triangles),
        ("facets and others", |draw| Soup::facets(draw).with_others(draw)),
        ("spheres", |draw| Soup::spheres(300, draw)),
        ("round spheres", |draw| Soup::spheres(300, draw).rounded()),
        ("marbles", Soup::marbles),
        ("round marbles", |draw| Soup::marbles(draw).rounded()),
        ("round and mixed", |draw| Soup::mixed(draw).rounded()),
        ("mixed", Soup::mixed),
        ("one", |draw| Soup::spheres(1, draw)),
    ];
    for level in levels() {
        for (name, kind) in kinds {
            for (scale, offset) in [(1.0, 0.0), (1e-3, 0.0), (1.0, 1e4), (1e12, 0.0)] {
                for grounds in [0, 2] {
                    let draw = &mut Draw::new(seed);
                    let mut soup = kind(draw).scaled(scale).moved(DVec3::new(1.0, -0.7, 0.3) * offset);
                    soup.0.extend((0..grounds).map(|_| Solid::Ground { height: -0.4 * scale }));
                    let wide = WideBvh::build(&soup).unwrap().with_level(level);
                    let name = format!("{} {name}, scale {scale:e}, offset {offset:e}, {grounds} planes", level.name());
                    compare(&name, &wide, &soup, 4000, draw);
                }
            }
        }
    }
}

/// Results do not depend on frustum culling, so this test counts nodes.
#[test]
fn bundles_are_culled_once() {
    let soup = Soup::spheres(2000, &mut Draw::new(7)).rounded();
    let ray = |x: usize| Ray::new(DVec3::new(0.1, 0.2, 5.0), DVec3::new(1e-5 * (1 + x) as f64, -0.1, -1.0));
    let rays: Vec<_> = (0..64).map(|x| (ray(x), Interval::FORWARD)).collect();
    let wide = WideBvh::build(&soup).unwrap();
    let nodes_of = |n_together: usize| {
        let mut counters = Counters::default();
        for rays in rays.chunks(n_together) {
            wide.closest_batch(&soup, rays, &mut vec![None; rays.len()], &mut counters);
        }
        counters.total().nodes
    };
    let (apart, together) = (nodes_of(8), nodes_of(64));
    assert!(5 * together < apart, "{together} nodes instead of {apart}");
}

/// Results do not depend on the last occluder, so this test counts nodes. All rays start below a roof, or next to it,
/// coherent or not. There are too few spheres for frustum culling.
#[test]
fn the_last_occluder_is_tested_first() {
    let corners = [DVec3::new(-9.0, 2.0, -9.0), DVec3::new(9.0, 2.0, -9.0), DVec3::new(0.0, 2.0, 9.0)];
    let mut soups = [
        Soup(sheet(20, |x, z| DVec3::new(x, 0.1 * x * z, z)).collect()),
        Soup::spheres(200, &mut Draw::new(5)).rounded(),
    ];
    soups[0].0.push(Solid::Facet(corners.map(|corner| corner.as_vec3())));
    soups[1].0.push(Solid::Round(SphereKernel { centre: DVec3::Y * 20.0, radius: 18.0 }));
    for (soup, level) in soups.iter().flat_map(|soup| levels().map(move |level| (soup, level))) {
        let tree = WideBvh::build(soup).unwrap().with_level(level);
        for turned in [1.0, -1.0] {
            let ray = |i: usize, aside: f64| {
                let x = 1e-3 * (i % 60) as f64;
                let direction = DVec3::new(if i.is_multiple_of(2) { 1e-3 } else { 1e-3 * turned }, 1.0, -2e-3);
                (Ray::new(DVec3::new(x + aside, 1.5, 0.3), direction), Interval::FORWARD)
            };
            let blocked: Vec<_> = (0..512).map(|i| ray(i, 0.0)).collect();
            let nodes_of = |n_together: usize| {
                let mut counters = Counters::default();
                for rays in blocked.chunks(n_together) {
                    let mut answers = vec![false; rays.len()];
                    tree.occluded_batch(soup, rays, &mut answers, &mut counters);
                    assert!(answers.iter().all(|blocked| *blocked));
                }
                counters.total().nodes
            };
            let (apart, together) = (nodes_of(8), nodes_of(512));
            assert!(10 * together < apart, "{} {turned}: {together} nodes instead of {apart}", level.name());

            let mixed: Vec<_> = (0..512).map(|i| ray(i, if i / 20 % 2 == 0 { 0.0 } else { 40.0 })).collect();
            let mut answers = vec![false; mixed.len()];
            tree.occluded_batch(soup, &mixed, &mut answers, &mut NoProbe);
            for (i, ((ray, span), blocked)) in mixed.iter().zip(answers).enumerate() {
                assert_eq!(blocked, brute_force::occluded(soup, ray, *span, &mut NoProbe), "ray {i}");
            }
        }
    }
}

/// Results do not depend on dropped candidates, so this test counts hits: triangles are certain hits, but the sphere before
/// them is uncertain.
#[test]
fn candidates_beyond_the_closest_hit_are_dropped() {
    let facet = |z: f32| Solid::Facet([Vec3::new(-2.0, -2.0, z), Vec3::new(2.0, -2.0, z), Vec3::new(0.0, 3.0, z)]);
    let ray = |i: usize| Ray::new(DVec3::new(0.01 * i as f64, 0.0, 5.0), DVec3::new(1e-3, 1e-3, -1.0));
    let rays: Vec<_> = (0..8).map(|i| (ray(i), Interval::FORWARD)).collect();
    for place in 0..8 {
        let mut soup = Soup((1..8).map(|i| facet(-i as f32)).collect());
        soup.0.insert(place, Solid::Sphere { centre: DVec3::ZERO, radius: 0.5 });
        for level in levels() {
            let wide = WideBvh::build(&soup).unwrap().with_level(level);
            let (mut hits, mut counters) = ([None; 8], Counters::default());
            wide.closest_batch(&soup, &rays, &mut hits, &mut counters);
            assert!(hits.iter().all(|hit| hit.is_some_and(|hit| hit.primitive == place as u32)), "{hits:?}");
            assert_eq!(counters.total().hits, 8, "{}, sphere {place} of 8", level.name());
        }
    }
}

/// Rays are interleaved in trees of more than 8 MiB.
#[test]
fn batches_through_large_trees_equal_single_queries() {
    let seed = Draw::run_seed();
    println!("batches: seed {seed}");
    let bumps = |x: f64, z: f64| DVec3::new(x, 0.1 * (20.0 * x * z).fract(), z);
    let triangles = || Soup(sheet(400, bumps).collect());
    let facet = |solid: &Solid| match *solid {
        Solid::Triangle(vertices) => Solid::Facet(vertices.map(|vertex| vertex.as_vec3())),
        ref other => *other,
    };
    let facets = || Soup(triangles().0.iter().map(facet).collect());
    let mixed = || {
        let mut soup = triangles();
        soup.0.extend(Soup::spheres(100, &mut Draw::new(seed)).0);
        soup.0.push(Solid::Ground { height: 0.05 });
        soup
    };
    let spheres = || Soup::spheres(400_000, &mut Draw::new(seed));
    let soups = [
        ("facets", facets()),
        ("triangles", triangles()),
        ("mixed", mixed()),
        ("spheres", spheres()),
        ("round spheres", spheres().rounded()),
    ];
    for (name, soup) in soups {
        let wide = WideBvh::build(&soup).unwrap();
        assert!(wide.memory() > 8 << 20, "{name}: {} bytes", wide.memory());
        for level in levels() {
            let wide = wide.clone().with_level(level);
            compare(&format!("{} {name}", level.name()), &wide, &soup, 4000, &mut Draw::new(seed + 1));
        }
    }
}

/// Replaces some rays and spans by ones outside the range of the filters.
fn with_odd_ones(mut rays: Vec<(Ray, Interval)>, draw: &mut Draw) -> Vec<(Ray, Interval)> {
    let odd = [
        Ray::new(DVec3::splat(1e300), DVec3::NEG_ONE),
        Ray::new(DVec3::ZERO, DVec3::ZERO),
        Ray::new(DVec3::X * 3.0, DVec3::NEG_X * 1e-300),
        Ray::new(DVec3::X * 3.0, DVec3::NEG_X * 1e200),
        Ray::new(DVec3::splat(f64::NAN), DVec3::NEG_Y),
        Ray::new(DVec3::X, DVec3::new(0.0, f64::NEG_INFINITY, 0.0)),
    ];
    let numbers = [f64::NAN, f64::NEG_INFINITY, -1.0, -0.0, 0.0, f64::MIN_POSITIVE, 1.0, 5.0, f64::INFINITY];
    for (ray, span) in &mut rays {
        if draw.one_in(40) {
            *ray = draw.pick(&odd);
        }
        if draw.one_in(10) {
            *span = Interval::new(draw.pick(&numbers), draw.pick(&numbers));
        }
    }
    rays
}

/// Bit-identical results, and equal counters.
#[test]
fn small_sets_equal_brute_force() {
    let seed = Draw::run_seed();
    println!("batches: seed {seed}");
    let draw = &mut Draw::new(seed);
    let mut n_hits = 0;
    for round in 0..60 {
        let n = 1 + draw.below(SmallSet::CAPACITY);
        let pool = match round % 4 {
            0 => Soup::mixed(draw).0.into_iter().chain(Soup::facets(draw).0).collect(),
            1 => Soup::facets(draw).0,
            2 => Soup::spheres(n as u64, draw).0,
            _ => Soup::marbles(draw).0.into_iter().chain(Soup::facets(draw).0).collect(),
        };
        let soup = Soup((0..n).map(|_| draw.pick(&pool)).collect()).rounded();
        let scale = draw.pick(&[1.0, 1e-3, 1e12, 1e-30]);
        let mut soup = soup.scaled(scale).moved(DVec3::new(1.0, -0.7, 0.3) * draw.pick(&[0.0, 1e4]));
        // Two that coincide, and one without bounds.
        if n > 2 {
            soup.0[n - 1] = soup.0[0];
            soup.0[1] = draw.pick(&[soup.0[1], Solid::Ground { height: -0.4 * scale }]);
        }
        let chosen: Vec<u32> = (0..n as u32).filter(|_| draw.one_in(2)).collect();
        let smaller = Soup(chosen.iter().map(|&index| soup.0[index as usize]).collect());
        let rays = with_odd_ones(bundles(&soup, 1000, draw), draw);
        for level in levels() {
            let all = SmallSet::new(0..n as u32).unwrap().with_level(level);
            let some = SmallSet::new(chosen.iter().rev().copied()).unwrap().with_level(level);
            let linear = Linear::build(&soup).unwrap().with_level(level);
            let mut counted = [Counters::default(); 3];
            let (mut expected, mut expected_of_some) = (Counters::default(), Counters::default());
            let mut first = 0;
            while first < rays.len() {
                let len = draw.pick(&[1, 3, 5, 8, 13, 64, 300]).min(rays.len() - first);
                let rays = &rays[first..first + len];
                let (of_all, blocked) = trace_batch!(all, &soup, rays, &mut counted[0]);
                let (of_linear, blocked_by_linear) = trace_batch!(linear, &soup, rays, &mut counted[1]);
                let (of_some, blocked_by_some) = trace_batch!(some, &soup, rays, &mut counted[2]);
                for (i, (ray, span)) in rays.iter().enumerate() {
                    let name = format!("round {round}, {}, {ray:?} {span:?}", level.name());
                    let hit = brute_force::closest(&soup, ray, *span, &mut expected);
                    assert_eq!(key(of_all[i]), key(hit), "{name}");
                    assert_eq!(key(of_linear[i]), key(hit), "{name}");
                    let is_blocked = brute_force::occluded(&soup, ray, *span, &mut expected);
                    assert_eq!((blocked[i], blocked_by_linear[i]), (is_blocked, is_blocked), "{name}");
                    let hit_on_some = brute_force::closest(&smaller, ray, *span, &mut expected_of_some);
                    let is_blocked_by_some = brute_force::occluded(&smaller, ray, *span, &mut expected_of_some);
                    assert_eq!(blocked_by_some[i], is_blocked_by_some, "{name}");
                    let renamed = hit_on_some.map(|hit| Hit { primitive: chosen[hit.primitive as usize], ..hit });
                    assert_eq!(key(of_some[i]), key(renamed), "{name}");
                    n_hits += usize::from(hit.is_some());
                }
                first += len;
            }
            let expected = [expected, expected, expected_of_some].map(|counters| counters.total());
            assert_eq!(counted.map(|counters| counters.total()), expected, "round {round}");
        }
    }
    assert!(n_hits > 10_000, "{n_hits} hits");
    assert!(SmallSet::new(0..=SmallSet::CAPACITY as u32).is_none());
}

/// A set with instances, with primitives that cast no shadow, and with hits that carry instance ids.
struct Yard<'t, T> {
    things: Vec<Thing<'t, T>>,
    /// Single-ray queries of instances.
    n_single: AtomicU32,
}

struct Thing<'t, T> {
    soup: &'t Soup,
    /// Accelerator of an instance; without one, the only solid of the soup.
    structure: Option<&'t T>,
    blocks: bool,
}

impl<T: Accelerator> Primitives for Yard<'_, T> {
    fn len(&self) -> usize {
        self.things.len()
    }
    fn bounds(&self, index: u32) -> Option<Aabb> {
        let bounds = self.things[index as usize].soup.0.iter().map(Solid::bounds);
        bounds.reduce(|all, one| Some(all?.union(one?))).flatten()
    }
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.intersect_with_stats(index, ray, span, &mut NoProbe)
    }
    fn occludes(&self, index: u32, ray: &Ray, span: Interval) -> bool {
        self.occludes_with_stats(index, ray, span, &mut NoProbe)
    }
    fn intersect_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, probe: &mut S) -> Option<Hit> {
        let Thing { soup, structure, .. } = self.things[index as usize];
        let hit = match structure {
            Some(structure) => {
                self.n_single.fetch_add(1, Ordering::Relaxed);
                structure.closest(soup, ray, span, probe)
            }
            None => soup.intersect(0, ray, span),
        };
        hit.map(|hit| Hit { instance: index, ..hit })
    }
    fn occludes_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        let Thing { soup, structure, blocks } = self.things[index as usize];
        blocks
            && match structure {
                Some(structure) => {
                    self.n_single.fetch_add(1, Ordering::Relaxed);
                    structure.occluded(soup, ray, span, probe)
                }
                None => soup.occludes(0, ray, span),
            }
    }
    fn batch_kernel(&self, index: u32) -> BatchKernel {
        let Thing { soup, structure, .. } = self.things[index as usize];
        if structure.is_some() { BatchKernel::Instance } else { soup.batch_kernel(0) }
    }
    fn hit_ids(&self, index: u32) -> [u32; 2] {
        [index, 0]
    }
    fn blocks(&self, index: u32) -> bool {
        self.things[index as usize].blocks
    }
    fn intersect_batch<S: Probe>(&self, index: u32, rays: &[(Ray, Interval)], hits: &mut [Option<Hit>], probe: &mut S) {
        let Thing { soup, structure, .. } = self.things[index as usize];
        structure.unwrap().closest_batch(soup, rays, hits, probe);
        hits.iter_mut().flatten().for_each(|hit| hit.instance = index);
    }
    fn occludes_batch<S: Probe>(&self, index: u32, rays: &[(Ray, Interval)], blocked: &mut [bool], probe: &mut S) {
        let Thing { soup, structure, blocks } = self.things[index as usize];
        if blocks {
            structure.unwrap().occluded_batch(soup, rays, blocked, probe);
        } else {
            blocked.fill(false);
        }
    }
}

/// Compares small sets and trees that contain instances with brute force.
fn compare_yards<T: Accelerator>(seed: u64, build: fn(&Soup) -> T, counts: bool) {
    let draw = &mut Draw::new(seed);
    let mut n_hits = 0;
    for round in 0..40 {
        let scale = draw.pick(&[1.0, 1e-3, 1e12]);
        let offset = DVec3::new(1.0, -0.7, 0.3) * draw.pick(&[0.0, 1e4]);
        let pool = Soup::mixed(draw).0.into_iter().chain(Soup::facets(draw).0).collect::<Vec<_>>();
        let soups: Vec<Soup> = (0..1 + draw.below(SmallSet::CAPACITY))
            .map(|_| {
                let n = draw.pick(&[1, 1, 30]);
                Soup((0..n).map(|_| draw.pick(&pool)).collect()).rounded().scaled(scale).moved(offset)
            })
            .collect();
        let structures: Vec<T> = soups.iter().map(build).collect();
        let things = soups
            .iter()
            .zip(&structures)
            .map(|(soup, structure)| Thing {
                soup,
                structure: (soup.0.len() > 1 || draw.one_in(8)).then_some(structure),
                blocks: !draw.one_in(4),
            })
            .collect();
        let yard = Yard { things, n_single: AtomicU32::new(0) };
        let everything = Soup(soups.iter().flat_map(|soup| soup.0.clone()).collect());
        let rays = with_odd_ones(bundles(&everything, 600, draw), draw);
        for level in levels() {
            let small_set = SmallSet::new(0..yard.len() as u32).unwrap().with_level(level);
            let wide = WideBvh::build(&yard).unwrap().with_level(level);
            let [mut counted, mut expected] = [Counters::default(); 2];
            for rays in rays.chunks(draw.pick(&[1, 5, 13, 64, 300])) {
                let (hits, blocked) = trace_batch!(small_set, &yard, rays, &mut counted);
                let (wide_hits, wide_blocked) = trace_batch!(wide, &yard, rays, &mut Counters::default());
                for (i, (ray, span)) in rays.iter().enumerate() {
                    let name = format!("round {round}, {}, {ray:?} {span:?}", level.name());
                    let hit = brute_force::closest(&yard, ray, *span, &mut expected);
                    assert_eq!([key(hits[i]), key(wide_hits[i])], [key(hit); 2], "{name}");
                    let is_blocked = brute_force::occluded(&yard, ray, *span, &mut expected);
                    assert_eq!([blocked[i], wide_blocked[i]], [is_blocked; 2], "{name}");
                    n_hits += usize::from(hit.is_some());
                }
            }
            assert!(!counts || counted.total() == expected.total(), "round {round}: {counted:?} {expected:?}");
        }
    }
    assert!(n_hits > 5000, "{n_hits} hits");
}

/// Bit-identical results; equal counters where the instances' accelerator counts batches as single rays.
#[test]
fn batches_through_instances_equal_single_queries() {
    let seed = Draw::run_seed();
    println!("batches: seed {seed}");
    compare_yards(seed, |soup| Bvh::build(soup).unwrap(), true);
    compare_yards(seed, |soup| WideBvh::build(soup).unwrap(), false);
}

/// Results do not depend on batches of instances, so this test counts single-ray queries.
#[test]
fn packets_enter_instances_together() {
    let draw = &mut Draw::new(3);
    let place = |i: usize| DVec3::new((i % 4) as f64, 0.0, (i / 4) as f64) * 2.5;
    let soups: Vec<Soup> = (0..12).map(|i| Soup::facets(draw).moved(place(i))).collect();
    let structures: Vec<WideBvh> = soups.iter().map(|soup| WideBvh::build(soup).unwrap()).collect();
    let thing = |(soup, structure)| Thing { soup, structure: Some(structure), blocks: true };
    let yard = Yard { things: soups.iter().zip(&structures).map(thing).collect(), n_single: AtomicU32::new(0) };
    // Groups of sixteen neighbouring rays, as those of a pixel, and five more at the end.
    let eye = DVec3::new(3.7, 9.0, -6.0);
    let rays: Vec<_> = (0..16 * 400 + 5)
        .map(|i: u64| {
            let at = |k: u64| rt_math::random::unit(rt_math::random::hash(&[5, i / 16, k]));
            let neighbour = DVec3::new((i % 4) as f64, 0.0, (i / 4 % 4) as f64) * 1e-3;
            (Ray::new(eye, DVec3::new(8.0 * at(0), 0.0, 6.0 * at(1)) + neighbour - eye), Interval::FORWARD)
        })
        .collect();
    for level in levels() {
        let tree = WideBvh::build(&yard).unwrap().with_level(level);
        let small_set = SmallSet::new(0..12).unwrap().with_level(level);
        // A batch of four is a packet of four.
        for (wide, together) in [(true, rays.len()), (true, 4), (false, rays.len())] {
            yard.n_single.store(0, Ordering::Relaxed);
            let (mut hits, mut blocked) = (Vec::new(), Vec::new());
            for rays in rays.chunks(together) {
                let counters = &mut Counters::default();
                let (h, b) = if wide {
                    trace_batch!(tree, &yard, rays, counters)
                } else {
                    trace_batch!(small_set, &yard, rays, counters)
                };
                hits.extend(h);
                blocked.extend(b);
            }
            let n_single = yard.n_single.load(Ordering::Relaxed);
            for (i, (ray, span)) in rays.iter().enumerate() {
                let hit = brute_force::closest(&yard, ray, *span, &mut NoProbe);
                assert_eq!((key(hits[i]), blocked[i]), (key(hit), hit.is_some()));
            }
            let n_hits = hits.iter().flatten().count();
            assert!(n_hits > 2000 && (n_single as usize) < rays.len() / 4, "{n_hits} hits, {n_single} single queries");
        }
    }
}

/// Padding lanes would be counted if they were traced.
#[test]
fn padding_lanes_do_nothing() {
    let soups = [Soup::facets(&mut Draw::new(4)), Soup::spheres(300, &mut Draw::new(4)).rounded()];
    for soup in soups {
        for level in levels() {
            let tree = WideBvh::build(&soup).unwrap().with_level(level);
            let (mut single, mut together, mut n_hits) = (Counters::default(), Counters::default(), 0);
            for i in 0..500 {
                let at = |k: u64| rt_math::random::unit(rt_math::random::hash(&[6, i, k])) - 0.5;
                let eye = DVec3::new(0.4, 2.0, 3.0);
                let ray = |k: u64| Ray::new(eye, DVec3::new(at(0) + 1e-6 * k as f64, at(1), at(2)) - eye);
                let rays = [0, 1, 2, 3].map(|k| (ray(k), Interval::FORWARD));
                let rays = if i % 2 == 0 { &rays[..] } else { &rays[..3] };
                let mut hits = vec![None; rays.len()];
                tree.closest_batch(&soup, rays, &mut hits, &mut together);
                for ((ray, span), hit) in rays.iter().zip(hits) {
                    assert_eq!(key(hit), key(tree.closest(&soup, ray, *span, &mut single)));
                    n_hits += usize::from(hit.is_some());
                }
            }
            let (single, together) = (single.total(), together.total());
            assert!(n_hits > 200, "{n_hits} hits");
            assert!(
                4 * together.tests < 5 * single.tests && 4 * together.nodes < 5 * single.nodes,
                "{single:?} {together:?}"
            );
        }
    }
}

#[test]
fn surplus_rays_and_outputs_stay_unchanged() {
    let soup = Soup::spheres(5, &mut Draw::new(3)).rounded();
    let rays = bundles(&soup, 20, &mut Draw::new(4));
    let small_set = SmallSet::new(0..5).unwrap();
    for n in 0..20 {
        let mut hits = vec![None; n];
        small_set.closest_batch(&soup, &rays, &mut hits, &mut NoProbe);
        let mut more = vec![None; 30];
        small_set.closest_batch(&soup, &rays[..n], &mut more, &mut NoProbe);
        for (i, (ray, span)) in rays.iter().enumerate().take(n) {
            let expected = key(small_set.closest(&soup, ray, *span, &mut NoProbe));
            assert_eq!((key(hits[i]), key(more[i])), (expected, expected));
        }
        assert!(more[n..].iter().all(Option::is_none));
    }
}

/// Plain arithmetic hits the sliver far outside its padded bounds, and a neighbour starts next to its plane. The side test
/// of the first ray once depended on the second.
#[test]
fn hits_on_a_sliver_do_not_depend_on_neighbouring_rays() {
    let vertices = [
        [2.6940758228302, 3.7117247581481934, -0.0024276815820485353],
        [2.6944515705108643, 3.994624376296997, -0.0027274370659142733],
        [2.69555401802063, -1.656948447227478, -0.003933731932193041],
    ];
    let soup = Soup(vec![Solid::Facet(vertices.map(|vertex| DVec3::from(vertex).as_vec3()))]);
    let sliver = Ray::new(
        DVec3::new(2.694509517098264, 2.528108834411083, -0.0028498073984306017),
        DVec3::new(2.2761795169135013e-5, 0.00013634008051077728, -1.901559655846305e-5),
    );
    let neighbour =
        Ray::new(DVec3::new(2.694728059667251, 2.121473740525947, -0.0030527670320567414), DVec3::new(-0.5, 1.0, -0.6));
    for level in levels() {
        let small_set = SmallSet::new([0]).unwrap().with_level(level);
        let rays: Vec<_> = (0..8).map(|i| (if i == 3 { sliver } else { neighbour }, Interval::FORWARD)).collect();
        let mut hits = vec![None; 8];
        small_set.closest_batch(&soup, &rays, &mut hits, &mut NoProbe);
        for (i, (ray, span)) in rays.iter().enumerate() {
            assert_eq!(key(hits[i]), key(brute_force::closest(&soup, ray, *span, &mut NoProbe)), "ray {i}");
        }
        assert!(hits[3].is_some());
    }
}

/// Counts scalar tests.
struct Counting<'a>(&'a Soup, AtomicU32);

impl Primitives for Counting<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.0.bounds(index)
    }
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.intersect(index, ray, span)
    }
    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        self.0.geometry(index)
    }
}

/// Results do not depend on SIMD lanes, so this test counts scalar tests.
#[test]
fn few_rays_need_the_scalar_test() {
    let draw = &mut Draw::new(11);
    // An oblique floor, and two spheres above it.
    let corner = |x: f32, z: f32| Vec3::new(x, 0.1 * x - 0.05 * z, z);
    let floor = [
        [corner(-5.0, -5.0), corner(5.0, -5.0), corner(5.0, 5.0)],
        // Turned the other way.
        [corner(5.0, 5.0), corner(-5.0, -5.0), corner(-5.0, 5.0)],
    ];
    let sphere = |x: f64| SphereKernel { centre: DVec3::new(x, 1.5, 0.2), radius: 0.9 };
    let (one, other) = (sphere(-1.0), sphere(1.0));
    let soup = Soup(vec![Solid::Facet(floor[0]), Solid::Round(one), Solid::Facet(floor[1]), Solid::Round(other)]);
    let up = DVec3::new(-0.1, 1.0, 0.05).normalize();
    // From the eye, the floor, the spheres, and from inside them.
    let mut rays: Vec<(Ray, Interval)> = Vec::new();
    for _ in 0..400 {
        let eye = DVec3::new(0.3, 4.0, 6.0);
        rays.push((Ray::new(eye, DVec3::new(0.0, 0.5, 0.0) + draw.point() * 4.0 - eye), Interval::FORWARD));
    }
    for _ in 0..400 {
        let (x, z) = (draw.between(-4.0, 4.0), draw.between(-4.0, 4.0));
        let up = up * draw.pick(&[1.0, -1.0]);
        let origin = DVec3::new(x, 0.1 * x - 0.05 * z, z) + up * 1e-6;
        rays.push((Ray::new(origin, up + draw.point() * 0.5), Interval::SPAWNED));
    }
    for _ in 0..400 {
        let normal = draw.point().normalize();
        let origin = one.centre + normal * (one.radius * (1.0 + 1e-14));
        rays.push((Ray::new(origin, normal + draw.point() * 0.5), Interval::SPAWNED));
    }
    for _ in 0..400 {
        rays.push((Ray::new(other.centre + draw.point() * 0.4, draw.point()), Interval::SPAWNED));
    }
    for level in levels() {
        let small_set = SmallSet::new(0..4).unwrap().with_level(level);
        let counting = Counting(&soup, AtomicU32::new(0));
        let mut hits = vec![None; rays.len()];
        small_set.closest_batch(&counting, &rays, &mut hits, &mut NoProbe);
        small_set.occluded_batch(&counting, &rays, &mut vec![false; rays.len()], &mut NoProbe);
        for (hit, (ray, span)) in hits.iter().zip(&rays) {
            assert_eq!(key(*hit), key(brute_force::closest(&soup, ray, *span, &mut NoProbe)), "{ray:?} {span:?}");
        }
        let n_hits = hits.iter().flatten().count();
        let n_single = counting.1.load(Ordering::Relaxed);
        assert!(n_hits > 700 && n_single < 16, "{n_hits} hits, {n_single} of {} scalar tests", 8 * rays.len());
    }
}

/// Rays outside the range of the filters, or not finite, among others.
#[test]
fn batches_with_odd_rays_equal_single_queries() {
    let soup = Soup::facets(&mut Draw::new(5));
    const N: usize = 72;
    let wide = WideBvh::build(&soup).unwrap();
    // Neighbours start at an offset, so that the bundle is wider than a line.
    let good = Ray::new(DVec3::new(0.1, 3.0, 0.2), DVec3::NEG_Y);
    let neighbour = |at: usize| Ray { origin: good.origin + DVec3::X * (0.01 * at as f64), ..good };
    let odd = [
        Ray::new(DVec3::new(0.1, 1e30, 0.2), DVec3::NEG_Y),
        Ray::new(good.origin, DVec3::ZERO),
        Ray::new(good.origin, DVec3::NEG_Y * 1e-300),
        Ray::new(DVec3::splat(f64::NAN), DVec3::NEG_Y),
        Ray::new(good.origin, DVec3::new(0.0, f64::NEG_INFINITY, 0.0)),
    ];
    for (i, odd) in odd.into_iter().enumerate() {
        for place in (0..8).chain([30, 63, 64]) {
            for span in
                [Interval::FORWARD, Interval::new(-1.0, 5.0), Interval::new(2.0, 1.0), Interval::new(f64::NAN, 1.0)]
            {
                let rays: Vec<_> = (0..N)
                    .map(|at| if at == place { (odd, span) } else { (neighbour(at), Interval::FORWARD) })
                    .collect();
                let mut hits = vec![None; N];
                wide.closest_batch(&soup, &rays, &mut hits, &mut NoProbe);
                for (at, (ray, span)) in rays.iter().enumerate() {
                    let expected = wide.closest(&soup, ray, *span, &mut NoProbe);
                    assert_eq!(key(hits[at]), key(expected), "odd ray {i} at {place}, {span:?}");
                }
            }
        }
    }
}
