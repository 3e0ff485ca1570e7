//! Batches answer as single queries do: bundles of rays that go the same way, rays that do not, and a mix of both; in
//! trees that the nearest caches hold, and in others.

#![allow(clippy::unwrap_used, reason = "tests fail by panicking")]

mod soup;

use std::sync::atomic::{AtomicU32, Ordering};

use rt_accel::wide::{SimdLevel, SmallSet};
use rt_accel::{
    Aabb, Accelerator, AcceleratorQueries, BatchKernel, Bvh, Counters, DVec3, Hit, Interval, Linear, NoProbe,
    PrimitiveGeometry, Primitives, Probe, Ray, SphereKernel, WideBvh, brute_force,
};
use rt_math::Vec3;
use soup::draw::Draw;
use soup::rays::{Query, adversarial};
use soup::{Solid, Soup, sheet};

/// Rays in bundles of one to twenty, or of a hundred and more: each bundle starts as one ray, of which the others are
/// neighbours, from the same place or from around it.
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
        // In proportion to each component, or to the greatest, so that signs change.
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

/// Compares batches of all sizes with single queries.
fn compare<A: AcceleratorQueries>(name: &str, structure: &A, soup: &Soup, n_rays: usize, draw: &mut Draw) {
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
    // What is looked at once for many rays is counted once, so that batches may do much less.
    let is_no_more = |batched: u64, single: u64| batched as f64 <= 1.5 * single as f64 && 16 * batched > single;
    assert!(
        is_no_more(batched.nodes, single.nodes) && is_no_more(batched.tests, single.tests),
        "{name}: {single:?} {batched:?}"
    );
    // Each answer has been decided about, and hardly anything else.
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

/// The answers would be the same without shafts, and so would be counts of more than a fifth.
#[test]
fn what_none_of_many_rays_meets_is_looked_at_once() {
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

/// The answers would be the same without memory, and counts of nodes ten times as high: all rays start below a roof, or next
/// to it, whether they agree or not. Of so few spheres nothing is found out by shafts.
#[test]
fn what_blocks_a_ray_is_asked_about_the_next() {
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

/// The answers would be the same otherwise: triangles are put off that are hit for sure, and the sphere before them is not.
#[test]
fn what_others_have_beaten_is_not_decided_about() {
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

/// Through trees of more than 8 MiB rays go side by side.
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

/// Rays for which no lanes are made, among others.
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

/// The last bit and the last test.
#[test]
fn handfuls_answer_and_count_as_brute_force() {
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
        // Two at one place, and something without an end.
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
                let [mut of_all, mut of_some, mut of_linear] = [const { Vec::new() }; 3].map(|mut hits: Vec<_>| {
                    hits.resize(len, None);
                    hits
                });
                let mut blocked = vec![false; len];
                all.closest_batch(&soup, rays, &mut of_all, &mut counted[0]);
                all.occluded_batch(&soup, rays, &mut blocked, &mut counted[0]);
                linear.closest_batch(&soup, rays, &mut of_linear, &mut counted[1]);
                let mut blocked_by_linear = vec![false; len];
                linear.occluded_batch(&soup, rays, &mut blocked_by_linear, &mut counted[1]);
                some.closest_batch(&soup, rays, &mut of_some, &mut counted[2]);
                let mut blocked_by_some = vec![false; len];
                some.occluded_batch(&soup, rays, &mut blocked_by_some, &mut counted[2]);
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

/// A set of which some are structures themselves, some block nothing, and hits are named by instances.
struct Yard<'t, T> {
    things: Vec<Thing<'t, T>>,
    /// How often a structure was asked for one ray.
    n_asked: AtomicU32,
}

struct Thing<'t, T> {
    soup: &'t Soup,
    /// The structure over the soup; without one the thing is the soup's only solid.
    structure: Option<&'t T>,
    blocks: bool,
}

impl<T: AcceleratorQueries> Primitives for Yard<'_, T> {
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
                self.n_asked.fetch_add(1, Ordering::Relaxed);
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
                    self.n_asked.fetch_add(1, Ordering::Relaxed);
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

/// As [`handfuls_answer_and_count_as_brute_force`], with structures among the members; trees over them answer alike.
fn compare_yards<T: AcceleratorQueries>(seed: u64, build: fn(&Soup) -> T, counts: bool) {
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
        let yard = Yard { things, n_asked: AtomicU32::new(0) };
        let everything = Soup(soups.iter().flat_map(|soup| soup.0.clone()).collect());
        let rays = with_odd_ones(bundles(&everything, 600, draw), draw);
        for level in levels() {
            let handful = SmallSet::new(0..yard.len() as u32).unwrap().with_level(level);
            let wide = WideBvh::build(&yard).unwrap().with_level(level);
            let [mut counted, mut expected] = [Counters::default(); 2];
            for rays in rays.chunks(draw.pick(&[1, 5, 13, 64, 300])) {
                let mut hits = vec![None; rays.len()];
                let mut blocked = vec![false; rays.len()];
                handful.closest_batch(&yard, rays, &mut hits, &mut counted);
                handful.occluded_batch(&yard, rays, &mut blocked, &mut counted);
                let mut wide_hits = vec![None; rays.len()];
                let mut wide_blocked = vec![false; rays.len()];
                wide.closest_batch(&yard, rays, &mut wide_hits, &mut NoProbe);
                wide.occluded_batch(&yard, rays, &mut wide_blocked, &mut NoProbe);
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

/// The last bit; where a structure does the same for batches as for rays, the last test as well.
#[test]
fn structures_among_primitives_are_asked_for_batches_with_the_answers_of_single_queries() {
    let seed = Draw::run_seed();
    println!("batches: seed {seed}");
    compare_yards(seed, |soup| Bvh::build(soup).unwrap(), true);
    compare_yards(seed, |soup| WideBvh::build(soup).unwrap(), false);
}

/// The answers would be the same if rays were passed on one by one.
#[test]
fn packets_go_into_structures_together() {
    let draw = &mut Draw::new(3);
    let place = |i: usize| DVec3::new((i % 4) as f64, 0.0, (i / 4) as f64) * 2.5;
    let soups: Vec<Soup> = (0..12).map(|i| Soup::facets(draw).moved(place(i))).collect();
    let structures: Vec<WideBvh> = soups.iter().map(|soup| WideBvh::build(soup).unwrap()).collect();
    let thing = |(soup, structure)| Thing { soup, structure: Some(structure), blocks: true };
    let yard = Yard { things: soups.iter().zip(&structures).map(thing).collect(), n_asked: AtomicU32::new(0) };
    // Sixteen rays at a time that run beside each other, as those of a pixel do, and five more at the end.
    let eye = DVec3::new(3.7, 9.0, -6.0);
    let rays: Vec<_> = (0..16 * 400 + 5)
        .map(|i: u64| {
            let at = |k: u64| rt_math::random::unit(rt_math::random::hash(&[5, i / 16, k]));
            let beside = DVec3::new((i % 4) as f64, 0.0, (i / 4 % 4) as f64) * 1e-3;
            (Ray::new(eye, DVec3::new(8.0 * at(0), 0.0, 6.0 * at(1)) + beside - eye), Interval::FORWARD)
        })
        .collect();
    for level in levels() {
        let tree = WideBvh::build(&yard).unwrap().with_level(level);
        let handful = SmallSet::new(0..12).unwrap().with_level(level);
        // A batch of four is a packet of four.
        for (wide, together) in [(true, rays.len()), (true, 4), (false, rays.len())] {
            yard.n_asked.store(0, Ordering::Relaxed);
            let (mut hits, mut blocked) = (vec![None; rays.len()], vec![false; rays.len()]);
            let answers = hits.chunks_mut(together).zip(blocked.chunks_mut(together));
            for (rays, (hits, blocked)) in rays.chunks(together).zip(answers) {
                if wide {
                    tree.closest_batch(&yard, rays, hits, &mut NoProbe);
                    tree.occluded_batch(&yard, rays, blocked, &mut NoProbe);
                } else {
                    handful.closest_batch(&yard, rays, hits, &mut NoProbe);
                    handful.occluded_batch(&yard, rays, blocked, &mut NoProbe);
                }
            }
            let n_asked = yard.n_asked.load(Ordering::Relaxed);
            for (i, (ray, span)) in rays.iter().enumerate() {
                let hit = brute_force::closest(&yard, ray, *span, &mut NoProbe);
                assert_eq!((key(hits[i]), blocked[i]), (key(hit), hit.is_some()));
            }
            let n_hits = hits.iter().flatten().count();
            assert!(n_hits > 2000 && (n_asked as usize) < rays.len() / 4, "{n_hits} hits, {n_asked} asked alone");
        }
    }
}

/// Lanes without a ray would be counted if they went on.
#[test]
fn lanes_without_a_ray_do_nothing() {
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
fn rays_beyond_the_answers_are_left_alone() {
    let soup = Soup::spheres(5, &mut Draw::new(3)).rounded();
    let rays = bundles(&soup, 20, &mut Draw::new(4));
    let handful = SmallSet::new(0..5).unwrap();
    for n in 0..20 {
        let mut hits = vec![None; n];
        handful.closest_batch(&soup, &rays, &mut hits, &mut NoProbe);
        let mut more = vec![None; 30];
        handful.closest_batch(&soup, &rays[..n], &mut more, &mut NoProbe);
        for (i, (ray, span)) in rays.iter().enumerate().take(n) {
            let expected = key(handful.closest(&soup, ray, *span, &mut NoProbe));
            assert_eq!((key(hits[i]), key(more[i])), (expected, expected));
        }
        assert!(more[n..].iter().all(Option::is_none));
    }
}

/// The sliver is met far outside of its own box by plain arithmetic, and a neighbour starts next to its plane: whether the
/// kernel has to look at the start of the first ray was once decided by the second.
#[test]
fn hits_on_a_sliver_do_not_depend_on_the_rays_beside() {
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
    let beside =
        Ray::new(DVec3::new(2.694728059667251, 2.121473740525947, -0.0030527670320567414), DVec3::new(-0.5, 1.0, -0.6));
    for level in levels() {
        let handful = SmallSet::new([0]).unwrap().with_level(level);
        let rays: Vec<_> = (0..8).map(|i| (if i == 3 { sliver } else { beside }, Interval::FORWARD)).collect();
        let mut hits = vec![None; 8];
        handful.closest_batch(&soup, &rays, &mut hits, &mut NoProbe);
        for (i, (ray, span)) in rays.iter().enumerate() {
            assert_eq!(key(hits[i]), key(brute_force::closest(&soup, ray, *span, &mut NoProbe)), "ray {i}");
        }
        assert!(hits[3].is_some());
    }
}

/// Counts how often it is asked.
struct Busy<'a>(&'a Soup, AtomicU32);

impl Primitives for Busy<'_> {
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

/// The answers would be the same if lanes settled nothing.
#[test]
fn lanes_leave_little_to_be_decided_ray_by_ray() {
    let draw = &mut Draw::new(11);
    // A floor that is no coordinate plane, and two balls above it.
    let corner = |x: f32, z: f32| Vec3::new(x, 0.1 * x - 0.05 * z, z);
    let floor = [
        [corner(-5.0, -5.0), corner(5.0, -5.0), corner(5.0, 5.0)],
        // Turned the other way.
        [corner(5.0, 5.0), corner(-5.0, -5.0), corner(-5.0, 5.0)],
    ];
    let ball = |x: f64| SphereKernel { centre: DVec3::new(x, 1.5, 0.2), radius: 0.9 };
    let (one, other) = (ball(-1.0), ball(1.0));
    let soup = Soup(vec![Solid::Facet(floor[0]), Solid::Round(one), Solid::Facet(floor[1]), Solid::Round(other)]);
    let up = DVec3::new(-0.1, 1.0, 0.05).normalize();
    // From the eye, from the floor, from the balls, and from within them.
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
        let handful = SmallSet::new(0..4).unwrap().with_level(level);
        let busy = Busy(&soup, AtomicU32::new(0));
        let mut hits = vec![None; rays.len()];
        handful.closest_batch(&busy, &rays, &mut hits, &mut NoProbe);
        handful.occluded_batch(&busy, &rays, &mut vec![false; rays.len()], &mut NoProbe);
        for (hit, (ray, span)) in hits.iter().zip(&rays) {
            assert_eq!(key(*hit), key(brute_force::closest(&soup, ray, *span, &mut NoProbe)), "{ray:?} {span:?}");
        }
        let n_hits = hits.iter().flatten().count();
        let n_asked = busy.1.load(Ordering::Relaxed);
        assert!(n_hits > 700 && n_asked < 16, "{n_hits} hits, {n_asked} of {} asked ray by ray", 8 * rays.len());
    }
}

/// Rays that no filter is proven for, or that are not finite, among others.
#[test]
fn batches_with_odd_rays_equal_single_queries() {
    let soup = Soup::facets(&mut Draw::new(5));
    const N: usize = 72;
    let wide = WideBvh::build(&soup).unwrap();
    // Its neighbours start beside it, so that what they have in common is more than a line.
    let good = Ray::new(DVec3::new(0.1, 3.0, 0.2), DVec3::NEG_Y);
    let beside = |at: usize| Ray { origin: good.origin + DVec3::X * (0.01 * at as f64), ..good };
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
                let rays: Vec<_> =
                    (0..N).map(|at| if at == place { (odd, span) } else { (beside(at), Interval::FORWARD) }).collect();
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
