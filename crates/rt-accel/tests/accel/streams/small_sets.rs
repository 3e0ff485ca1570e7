//! Streams of rays through small sets.

use std::sync::atomic::{AtomicU32, Ordering};

use rt_accel::wide::{SimdLevel, SmallSet};
use rt_accel::{
    Aabb, Accelerator, Counters, DVec3, Hit, Interval, Linear, NoProbe, PacketKernel, Primitives, Ray, SlabRay,
    SphereKernel, WideBvh, brute_force,
};
use rt_geometry::{InsideRule, Polygon, STREAM_CAPACITY};
use rt_math::Vec3;

use super::{Counting, bundles, key, levels, stream_of, with_odd_ones};
use crate::soup::{Solid, Soup, run_seed};
use rt_tests::Draw;

/// Bit-identical results, and equal counters.
#[test]
fn small_sets_equal_brute_force() {
    let seed = run_seed();
    println!("small sets: seed {seed}");
    let draw = &mut Draw::new(seed);
    let mut n_hits = 0;
    for round in 0..40 {
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
                let len = draw.pick(&[1, 3, 5, 8, 13, 64, STREAM_CAPACITY]).min(rays.len() - first);
                let rays = &rays[first..first + len];
                let of_all = closest!(all, &soup, rays, &mut counted[0]);
                let occluded = occluded!(all, &soup, rays, &mut counted[0]);
                let of_linear = closest!(linear, &soup, rays, &mut counted[1]);
                let occluded_by_linear = occluded!(linear, &soup, rays, &mut counted[1]);
                let of_some = closest!(some, &soup, rays, &mut counted[2]);
                let occluded_by_some = occluded!(some, &soup, rays, &mut counted[2]);
                for (i, (ray, span)) in rays.iter().enumerate() {
                    let name = format!("round {round}, {}, {ray:?} {span:?}", level.name());
                    let hit = brute_force::closest(&soup, ray, *span, &mut expected);
                    assert_eq!(key(of_all[i]), key(hit), "{name}");
                    assert_eq!(key(of_linear[i]), key(hit), "{name}");
                    let is_occluded = brute_force::occluded(&soup, ray, *span, &mut expected);
                    assert_eq!((occluded[i], occluded_by_linear[i]), (is_occluded, is_occluded), "{name}");
                    let hit_on_some = brute_force::closest(&smaller, ray, *span, &mut expected_of_some);
                    let is_occluded_by_some = brute_force::occluded(&smaller, ray, *span, &mut expected_of_some);
                    assert_eq!(occluded_by_some[i], is_occluded_by_some, "{name}");
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
    assert!(n_hits > 7_000, "{n_hits} hits");
    assert!(SmallSet::new(0..=SmallSet::CAPACITY as u32).is_none());
}

/// Primitives that are intersected ray by ray, and whose hits have ids of their own.
struct Renamed<'a>(&'a Soup);

impl Primitives for Renamed<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.0.bounds(index)
    }
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.0.intersect(index, ray, span).map(|hit| Hit { instance: 7, primitive: 100 + index, ..hit })
    }
    fn packet_kernel(&self, _: u32) -> PacketKernel {
        PacketKernel::Single
    }
}

#[test]
fn hits_of_primitives_without_a_kernel_keep_their_ids() {
    let soup = Soup::spheres(5, &mut Draw::new(3));
    let rays = bundles(&soup, 100, &mut Draw::new(4));
    let renamed = Renamed(&soup);
    for level in levels() {
        let small_set = SmallSet::new(0..5).unwrap().with_level(level);
        let hits = closest!(small_set, &renamed, &rays, &mut NoProbe);
        for (hit, (ray, span)) in hits.iter().zip(&rays) {
            assert_eq!(key(*hit), key(small_set.closest(&renamed, ray, *span, &mut NoProbe)), "{ray:?}");
        }
        assert!(hits.iter().flatten().any(|hit| hit.instance == 7 && hit.primitive >= 100));
    }
}

#[test]
fn results_beyond_the_slice_are_dropped() {
    let soup = Soup::spheres(5, &mut Draw::new(3)).rounded();
    let rays = stream_of(&bundles(&soup, 20, &mut Draw::new(4)));
    let (small_set, tree) = (SmallSet::new(0..5).unwrap(), WideBvh::build(&soup).unwrap());
    let mut all = [[false; 20]; 2];
    small_set.occluded_stream(&soup, &rays, &mut all[0], &mut NoProbe);
    tree.occluded_stream(&soup, &rays, &mut all[1], &mut NoProbe);
    for n in 0..20 {
        let mut fewer = vec![false; n];
        small_set.occluded_stream(&soup, &rays, &mut fewer, &mut NoProbe);
        assert_eq!(fewer, all[0][..n]);
        fewer.fill(false);
        tree.occluded_stream(&soup, &rays, &mut fewer, &mut NoProbe);
        assert_eq!(fewer, all[1][..n]);
    }
}

/// Rounded areas place the hit on the sliver far off, and a neighbour starts next to its plane. The side test of the first ray once
/// depended on the second.
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
        DVec3::new(-2.2761795169135013e-5, -0.00013634008051077728, 1.901559655846305e-5),
    );
    let neighbour =
        Ray::new(DVec3::new(2.694728059667251, 2.121473740525947, -0.0030527670320567414), DVec3::new(-0.5, 1.0, -0.6));
    for level in levels() {
        let small_set = SmallSet::new([0]).unwrap().with_level(level);
        let rays: Vec<_> = (0..8).map(|i| (if i == 3 { sliver } else { neighbour }, Interval::FORWARD)).collect();
        let hits = closest!(small_set, &soup, &rays, &mut NoProbe);
        for (i, (ray, span)) in rays.iter().enumerate() {
            assert_eq!(key(hits[i]), key(brute_force::closest(&soup, ray, *span, &mut NoProbe)), "ray {i}");
        }
        // 0.97588 by rational arithmetic.
        assert!(hits[3].is_some_and(|hit| (hit.t - 0.97588).abs() < 1e-5), "{:?}", hits[3]);
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
        let hits = closest!(small_set, &counting, &rays, &mut NoProbe);
        occluded!(small_set, &counting, &rays, &mut NoProbe);
        for (hit, (ray, span)) in hits.iter().zip(&rays) {
            assert_eq!(key(*hit), key(brute_force::closest(&soup, ray, *span, &mut NoProbe)), "{ray:?} {span:?}");
        }
        let n_hits = hits.iter().flatten().count();
        let n_single = counting.1.load(Ordering::Relaxed);
        assert!(n_hits > 700 && n_single < 16, "{n_hits} hits, {n_single} of {} scalar tests", 8 * rays.len());
    }
}

/// Kernels of these shapes run for rays that pass their padded bounds only, and those of planes for none.
#[test]
fn bounds_and_planes_are_tested_without_the_scalar_test() {
    let draw = &mut Draw::new(12);
    let boxes: Vec<Aabb> = (0..6).map(|_| Aabb::from_points([draw.point(), draw.point() * 0.5])).collect();
    let soup =
        Soup([Solid::Ground { height: -0.4 }].into_iter().chain(boxes.iter().map(|&own| Solid::Sloppy(own))).collect());
    // Some along the axes, also in the planes of padded sides: there the slab test has NaN.
    let rays: Vec<(Ray, Interval)> = (0..800)
        .map(|i| {
            let axis = draw.pick(&[DVec3::X, DVec3::NEG_Y, DVec3::Z]);
            let direction = if i % 4 == 0 { axis } else { draw.point() };
            let origin = if i % 8 == 0 { draw.pick(&boxes).padded().min } else { draw.point() * 4.0 };
            (Ray::new(origin, direction), Interval::FORWARD)
        })
        .collect();
    let pass = |(ray, span): &(Ray, Interval)| {
        boxes.iter().filter(|own| own.padded().clip(&SlabRay::new(ray), *span).is_some()).count()
    };
    let n_passed: usize = rays.iter().map(pass).sum();
    // Rays along an axis are tested with all boxes.
    let n_allowed = n_passed + rays.len() / 4 * boxes.len();
    for level in levels() {
        let small_set = SmallSet::new(0..7).unwrap().with_level(level);
        let counting = Counting(&soup, AtomicU32::new(0));
        let hits = closest!(small_set, &counting, &rays, &mut NoProbe);
        for (hit, (ray, span)) in hits.iter().zip(&rays) {
            assert_eq!(key(*hit), key(brute_force::closest(&soup, ray, *span, &mut NoProbe)), "{ray:?} {span:?}");
        }
        let n_single = counting.1.load(Ordering::Relaxed) as usize;
        assert!(n_single <= n_allowed && n_allowed < 2 * rays.len(), "{n_single} scalar tests, {n_allowed} allowed");
    }
}

/// Polygons as primitives, with the kernel of those that have one. Counts scalar tests.
struct Polygons(Vec<Polygon>, AtomicU32);

impl Primitives for Polygons {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn bounds(&self, index: u32) -> Option<Aabb> {
        Some(self.0[index as usize].bounds())
    }
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.1.fetch_add(1, Ordering::Relaxed);
        let hit = self.0[index as usize].intersect(ray, span)?;
        let [instance, primitive] = self.hit_ids(index);
        Some(Hit { t: hit.t, instance, primitive, uv: hit.uv })
    }
    fn occludes(&self, index: u32, ray: &Ray, span: Interval) -> bool {
        self.casts_shadow(index) && self.intersect(index, ray, span).is_some()
    }
    fn hit_ids(&self, index: u32) -> [u32; 2] {
        [7, 100 + index]
    }
    fn casts_shadow(&self, index: u32) -> bool {
        index != 2
    }
    fn packet_kernel(&self, index: u32) -> PacketKernel {
        let polygon = &self.0[index as usize];
        let corners = polygon.convex_quadrilateral();
        corners.map_or(PacketKernel::Single, |corners| PacketKernel::Quadrilateral(*polygon.plane(), corners))
    }
}

/// Rays to the insides, edges and corners of quadrilaterals of any kind, or next to them, also in and along their planes.
#[test]
fn quadrilaterals_equal_brute_force() {
    const SHARES: [f64; 7] = [0.0, 0.0, 1.0, 0.5, 1e-12, -1e-12, 1.5];
    let seed = run_seed();
    println!("quadrilaterals: seed {seed}");
    let draw = &mut Draw::new(seed);
    let mut n_hits = 0;
    for round in 0..60 {
        let scale = draw.pick(&[1.0, 1.0, 1e-3, 1e12, 1e-30]);
        let offset = DVec3::new(1.0, -0.7, 0.3) * draw.pick(&[0.0, 0.0, 1e4]);
        let mut polygons = Vec::new();
        while polygons.len() < 8 {
            let (origin, mut u, mut v) = (draw.point() + offset, draw.point(), draw.point());
            match draw.below(4) {
                0 => (u, v) = (DVec3::X * u.x, DVec3::Z * v.z),
                // A sliver.
                1 => v = u * 0.3 + v * draw.pick(&[1e-3, 1e-9]),
                _ => {}
            }
            // A parallelogram or a trapezium; some have a fifth corner, or the rule of concave polygons.
            let mut outline = vec![origin, origin + u, origin + u * draw.pick(&[1.0, 0.5]) + v, origin + v];
            if draw.one_in(8) {
                outline.insert(1, origin + u * 0.5);
            }
            outline.iter_mut().for_each(|corner| *corner *= scale);
            let rule = draw.pick(&[InsideRule::Convex, InsideRule::Convex, InsideRule::Convex, InsideRule::EvenOdd]);
            polygons.extend(Polygon::new(outline, Vec::new(), rule));
        }
        // Two coincide.
        polygons[5] = polygons[1].clone();
        let polygons = Polygons(polygons, AtomicU32::new(0));
        let mut rays = Vec::new();
        for _ in 0..600 {
            let polygon = &polygons.0[draw.below(8)];
            let ring = polygon.rings().next().unwrap();
            let [a, b, d] = [ring[0], ring[1], ring[ring.len() - 1]];
            let mut share = || if draw.one_in(2) { draw.between(0.0, 1.0) } else { draw.pick(&SHARES) };
            let target = a + (b - a) * share() + (d - a) * share();
            let any = draw.point();
            let out = draw.pick(&[any, polygon.normal(), (b - a) / scale, DVec3::Y]) * scale;
            let origin = target - out * draw.pick(&[1.0, 30.0, 1e-9, 0.0]);
            let span = draw.pick(&[Interval::FORWARD, Interval::SEGMENT, Interval::new(0.5, 1.0)]);
            rays.push((Ray::new(origin, draw.pick(&[out, target - origin])), span));
        }
        let rays = with_odd_ones(rays, draw);
        for level in levels() {
            let small_set = SmallSet::new(0..8).unwrap().with_level(level);
            let tree = WideBvh::build(&polygons).unwrap().with_level(level);
            let [mut counted, mut expected] = [Counters::default(); 2];
            let hits = closest!(small_set, &polygons, &rays, &mut counted);
            let occluded = occluded!(small_set, &polygons, &rays, &mut counted);
            let of_tree = closest!(tree, &polygons, &rays, &mut NoProbe);
            let occluded_by_tree = occluded!(tree, &polygons, &rays, &mut NoProbe);
            for (i, (ray, span)) in rays.iter().enumerate() {
                let name = format!("round {round}, {}, {ray:?} {span:?}", level.name());
                let hit = brute_force::closest(&polygons, ray, *span, &mut expected);
                assert_eq!([key(hits[i]), key(of_tree[i])], [key(hit); 2], "{name}");
                let is_occluded = brute_force::occluded(&polygons, ray, *span, &mut expected);
                assert_eq!([occluded[i], occluded_by_tree[i]], [is_occluded; 2], "{name}");
                n_hits += u32::from(hit.is_some());
            }
            assert_eq!(counted.total(), expected.total(), "round {round}, {}", level.name());
        }
    }
    assert!(n_hits > 20_000, "{n_hits} hits");
}

/// Results do not depend on SIMD lanes, so this test counts scalar tests.
#[test]
fn insides_of_quadrilaterals_need_no_scalar_test() {
    let draw = &mut Draw::new(13);
    let corners = [DVec3::ZERO, DVec3::new(3.0, 0.1, 0.2), DVec3::new(2.5, 0.3, 2.0), DVec3::new(0.2, 0.2, 2.2)];
    let on_floor = |corner: DVec3| DVec3 { y: 0.5 * corner.x - 0.25 * corner.z, ..corner };
    let outlines =
        [corners.map(on_floor), [[0.0, 3.0], [4.0, 3.0], [4.0, 6.0], [0.0, 6.0]].map(|[x, z]| DVec3::new(x, 1.0, z))];
    let polygon = |outline: &[DVec3; 4]| Polygon::new(outline.to_vec(), Vec::new(), InsideRule::Convex).unwrap();
    let polygons = Polygons(outlines.iter().map(polygon).collect(), AtomicU32::new(0));
    let rays: Vec<_> = (0..800)
        .map(|i| {
            let [a, b, c, d] = outlines[i % 2];
            let [u, v] = [draw.between(0.05, 0.95), draw.between(0.05, 0.95)];
            let target = a.lerp(b, u).lerp(d.lerp(c, u), v);
            let origin = target + DVec3::new(0.3, 2.0, -0.4) + draw.point();
            (Ray::new(origin, target - origin), draw.pick(&[Interval::FORWARD, Interval::new(0.0, 0.9)]))
        })
        .collect();
    for level in levels().filter(|level| *level != SimdLevel::Portable) {
        let small_set = SmallSet::new(0..2).unwrap().with_level(level);
        polygons.1.store(0, Ordering::Relaxed);
        let hits = closest!(small_set, &polygons, &rays, &mut NoProbe);
        let occluded = occluded!(small_set, &polygons, &rays, &mut NoProbe);
        let n_single = polygons.1.load(Ordering::Relaxed);
        let [n_hits, n_occluded] =
            [hits.iter().flatten().count(), occluded.iter().filter(|occluded| **occluded).count()];
        assert!(n_hits > 300 && n_occluded == n_hits && n_single < 16, "{n_hits} hits, {n_single} scalar tests");
    }
}
