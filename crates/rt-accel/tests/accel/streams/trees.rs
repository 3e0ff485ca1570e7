//! Streams of rays through trees.

use std::sync::atomic::{AtomicU32, Ordering};

use rt_accel::wide::SimdLevel;
use rt_accel::{Accelerator, Counters, DVec3, Interval, NoProbe, Ray, SphereKernel, WideBvh, brute_force};
use rt_math::Vec3;

use super::{Counting, bundles, key, levels};
use crate::soup::{Solid, Soup, run_seed, sheet};
use rt_tests::Draw;

/// Compares streams of all sizes with single queries.
fn compare(name: &str, accelerator: &WideBvh, soup: &Soup, n_rays: usize, draw: &mut Draw) {
    let rays = bundles(soup, n_rays, draw);
    let (mut n_hits, mut first) = (0, 0);
    let (mut single, mut streamed) = (Counters::default(), Counters::default());
    while first < rays.len() {
        let n = draw.pick(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12, 64, 1000]).min(rays.len() - first);
        let rays = &rays[first..first + n];
        let hits = closest!(accelerator, soup, rays, &mut streamed);
        let occluded = occluded!(accelerator, soup, rays, &mut NoProbe);
        for (i, (ray, span)) in rays.iter().enumerate() {
            let expected = accelerator.closest(soup, ray, *span, &mut single);
            assert_eq!(key(hits[i]), key(expected), "{name}, ray {}: {ray:?} {span:?}", first + i);
            assert_eq!(occluded[i], expected.is_some(), "{name}, ray {}: {ray:?} {span:?}", first + i);
            n_hits += usize::from(expected.is_some());
        }
        first += n;
    }
    assert!(n_hits > n_rays / 10, "{name}: {n_hits} hits");
    let (single, streamed) = (single.total(), streamed.total());
    // Work shared by many rays is counted once, so streams may do much less.
    let is_no_more = |streamed: u64, single: u64| streamed as f64 <= 1.5 * single as f64 && 16 * streamed > single;
    assert!(
        is_no_more(streamed.nodes, single.nodes) && is_no_more(streamed.tests, single.tests),
        "{name}: {single:?} {streamed:?}"
    );
    // Few exact hits are computed beyond the results.
    assert!(
        streamed.hits >= n_hits as u64 && streamed.hits as f64 <= 1.1 * single.hits as f64,
        "{name}: {n_hits} hits, {single:?} {streamed:?}"
    );
}

#[test]
fn streams_through_small_trees_equal_single_queries() {
    let seed = run_seed();
    println!("trees: seed {seed}");
    type Kind = (&'static str, fn(&mut Draw) -> Soup);
    let kinds: [Kind; 11] = [
        ("facets", Soup::facets),
        ("triangles", Soup::triangles),
        ("facets and others", |draw| Soup::facets(draw).with_others(draw)),
        ("spheres", |draw| Soup::spheres(300, draw)),
        ("round spheres", |draw| Soup::spheres(300, draw).rounded()),
        ("round spheres on a floor", |draw| Soup::spheres(300, draw).rounded().with_floor()),
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
                    compare(&name, &wide, &soup, 2000, draw);
                }
            }
        }
    }
}

/// Results do not depend on packets, so this test counts scalar tests. Without them, each of these rays tests the two triangles.
#[test]
fn packets_test_a_floor_among_spheres_together() {
    let soup = Soup::spheres(300, &mut Draw::new(7)).rounded().moved(DVec3::Y * 2.0).with_floor();
    // Next to the spheres: down to the floor, and away from it.
    let grid = |from: DVec3, along: DVec3| {
        (0..64).map(move |at| {
            let aside = DVec3::new(f64::from(at % 8) * 0.01, 0.0, f64::from(at / 8) * 0.01);
            (Ray::new(from, along + aside), Interval::FORWARD)
        })
    };
    let down = grid(DVec3::new(1.2, 0.5, 1.2), DVec3::NEG_Y);
    let rays: Vec<_> = down.chain(grid(DVec3::new(1.2, -0.29, 1.2), DVec3::new(1.0, 0.3, 1.0))).collect();
    for level in levels().filter(|level| *level != SimdLevel::Portable) {
        let wide = WideBvh::build(&soup).unwrap().with_level(level);
        let counting = Counting(&soup, AtomicU32::new(0));
        let occluded = occluded!(wide, &counting, &rays, &mut NoProbe);
        for (occluded, (ray, span)) in occluded.iter().zip(&rays) {
            assert_eq!(*occluded, brute_force::occluded(&soup, ray, *span, &mut NoProbe), "{ray:?}");
        }
        let n_single = counting.1.load(Ordering::Relaxed);
        assert!(n_single < 16, "{n_single} scalar tests of {} rays", rays.len());
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
            closest!(wide, &soup, rays, &mut counters);
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
            let occluded: Vec<_> = (0..512).map(|i| ray(i, 0.0)).collect();
            let nodes_of = |n_together: usize| {
                let mut counters = Counters::default();
                for rays in occluded.chunks(n_together) {
                    assert!(occluded!(tree, soup, rays, &mut counters).iter().all(|occluded| *occluded));
                }
                counters.total().nodes
            };
            let (apart, together) = (nodes_of(8), nodes_of(512));
            assert!(10 * together < apart, "{} {turned}: {together} nodes instead of {apart}", level.name());

            let mixed: Vec<_> = (0..512).map(|i| ray(i, if i / 20 % 2 == 0 { 0.0 } else { 40.0 })).collect();
            let answers = occluded!(tree, soup, &mixed, &mut NoProbe);
            for (i, ((ray, span), occluded)) in mixed.iter().zip(answers).enumerate() {
                assert_eq!(occluded, brute_force::occluded(soup, ray, *span, &mut NoProbe), "ray {i}");
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
            let mut counters = Counters::default();
            let hits = closest!(wide, &soup, &rays, &mut counters);
            assert!(hits.iter().all(|hit| hit.is_some_and(|hit| hit.primitive == place as u32)), "{hits:?}");
            assert_eq!(counters.total().hits, 8, "{}, sphere {place} of 8", level.name());
        }
    }
}

/// Rays are interleaved in trees of more than 8 MiB.
#[test]
fn streams_through_large_trees_equal_single_queries() {
    let seed = run_seed();
    println!("trees: seed {seed}");
    let bumps = |x: f64, z: f64| DVec3::new(x, 0.1 * (20.0 * x * z).fract(), z);
    let triangles = || Soup(sheet(280, bumps).collect());
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
    let spheres = || Soup::spheres(150_000, &mut Draw::new(seed));
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
            compare(&format!("{} {name}", level.name()), &wide, &soup, 2000, &mut Draw::new(seed + 1));
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
                let hits = closest!(tree, &soup, rays, &mut together);
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

/// Rays outside the range of the filters, or not finite, among others.
#[test]
fn streams_with_odd_rays_equal_single_queries() {
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
                let hits = closest!(wide, &soup, &rays, &mut NoProbe);
                let occluded = occluded!(wide, &soup, &rays, &mut NoProbe);
                for (at, (ray, span)) in rays.iter().enumerate() {
                    let expected = wide.closest(&soup, ray, *span, &mut NoProbe);
                    assert_eq!(key(hits[at]), key(expected), "odd ray {i} at {place}, {span:?}");
                    assert_eq!(occluded[at], expected.is_some(), "odd ray {i} at {place}, {span:?}");
                }
            }
        }
    }
}
