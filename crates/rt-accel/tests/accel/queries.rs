//! Every query has the same answer whatever the accelerator, and it is the one that the definition gives.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use crate::soup::accelerators::Accelerators;
use crate::soup::rays::{Query, adversarial};
use crate::soup::{Solid, Soup};
use rt_accel::{
    Aabb, Accelerator, AcceleratorKind, AnyAccelerator, Boxes, Bvh, ClosestPoint, DVec3, Frustum, Hit, Interval,
    NoProbe, Primitives, Ray, Region, SphereRegion, SplitMethod,
};
use rt_tests::Draw;

fn scene(seed: u64) -> Soup {
    let mut soup = Soup::mixed(&mut Draw::new(seed));
    soup.0.insert(30, Solid::Ground { height: -0.4 });
    soup.0.push(Solid::Ghost(Aabb::new(DVec3::splat(-2.0), DVec3::splat(-1.5))));
    soup
}

fn key(hit: &Hit) -> (u64, u32, u32) {
    (hit.t.to_bits(), hit.instance, hit.primitive)
}

fn queries(soup: &Soup, count: usize, seed: u64) -> Vec<Query> {
    let world = Aabb::new(DVec3::splat(-1.5), DVec3::splat(1.5));
    let mut draw = Draw::new(seed);
    (0..count).map(|_| adversarial(soup, &world, &mut draw)).collect()
}

#[test]
fn all_hits_are_those_of_each_primitive_by_itself() {
    let soup = scene(1);
    let all = Accelerators::build(&soup);
    let (mut hits, mut n_hits) = (Vec::new(), 0);
    for Query { ray, span } in queries(&soup, 4000, 2) {
        all.0[0].all_hits(&soup, &ray, span, &mut hits, &mut NoProbe);
        let expected: Vec<_> = hits.iter().map(key).collect();
        assert!(hits.windows(2).all(|pair| pair[0].precedes(&pair[1])), "in order, each once: {hits:?}");
        let first = all.0[0].closest(&soup, &ray, span, &mut NoProbe);
        assert_eq!(hits.first().map(key), first.as_ref().map(key));
        n_hits += hits.len();
        for accelerator in &all.0 {
            accelerator.all_hits(&soup, &ray, span, &mut hits, &mut NoProbe);
            assert_eq!(hits.iter().map(key).collect::<Vec<_>>(), expected, "{}: {ray:?}", accelerator.kind().name());
        }
    }
    assert!(n_hits > 8000, "{n_hits}");
}

#[test]
fn a_sphere_is_met_twice_and_a_list_of_hits_is_reused() {
    let soup = Soup(vec![
        Solid::Sphere { centre: DVec3::Z * 10.0, radius: 1.0 },
        Solid::Sphere { centre: DVec3::Z * 10.0, radius: 2.0 },
    ]);
    let ray = Ray::new(DVec3::ZERO, DVec3::Z);
    for accelerator in &Accelerators::build(&soup).0 {
        let mut hits = Vec::with_capacity(8);
        let capacity = hits.capacity();
        for _ in 0..2 {
            accelerator.all_hits(&soup, &ray, Interval::FORWARD, &mut hits, &mut NoProbe);
            let found: Vec<_> = hits.iter().map(|hit| (hit.t.round(), hit.primitive)).collect();
            assert_eq!(found, [(8.0, 1), (9.0, 0), (11.0, 0), (12.0, 1)]);
        }
        assert_eq!(hits.capacity(), capacity);
    }
}

#[test]
fn first_hits_are_the_beginning_of_all_hits() {
    let soup = scene(3);
    let all = Accelerators::build(&soup);
    let mut hits = Vec::new();
    for (i, Query { ray, span }) in queries(&soup, 4000, 4).into_iter().enumerate() {
        all.0[0].all_hits(&soup, &ray, span, &mut hits, &mut NoProbe);
        let capacity = i % 6;
        let expected: Vec<_> = hits.iter().take(capacity).map(key).collect();
        for accelerator in &all.0 {
            let mut first = [None; 5];
            let found = accelerator.first_hits(&soup, &ray, span, &mut first[..capacity], &mut NoProbe);
            let first: Vec<_> = first.iter().flatten().map(key).collect();
            assert_eq!((found, &first), (expected.len(), &expected), "{}: {ray:?}", accelerator.kind().name());
        }
    }
}

#[test]
fn something_that_fills_space_does_not_report_forever() {
    let boxes = [Aabb::new(DVec3::ZERO, DVec3::ONE)];
    let ray = Ray::new(DVec3::splat(0.5), DVec3::X);
    for accelerator in &Accelerators::build(&Boxes(&boxes)).0 {
        let mut hits = Vec::new();
        accelerator.all_hits(&Boxes(&boxes), &ray, Interval::FORWARD, &mut hits, &mut NoProbe);
        assert!((1..20).contains(&hits.len()), "{hits:?}");
    }
}

/// Regression: such hits passed every comparison with a span, so that they were reported without end.
#[test]
fn hits_without_a_number_are_misses() {
    /// Planes through the origin, which divide zero by zero, before a box that is hit.
    struct Planes;

    impl Primitives for Planes {
        fn len(&self) -> usize {
            3
        }
        fn bounds(&self, index: u32) -> Option<Aabb> {
            (index > 0).then_some(Aabb::new(DVec3::new(1.0, -1.0, -1.0), DVec3::new(2.0, 1.0, 1.0)))
        }
        fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
            let t = if index == 2 { 1.5 } else { -ray.origin.z / ray.direction.z };
            let is_outside = t < span.min || t > span.max;
            (!is_outside).then_some(Hit { t, instance: 0, primitive: index, uv: [0.0; 2] })
        }
    }

    let ray = Ray::new(DVec3::ZERO, DVec3::X);
    let all = Accelerators::build(&Planes);
    assert_eq!(all.closest(&Planes, &ray, Interval::FORWARD).map(|hit| hit.t), Some(1.5));
    for accelerator in &all.0 {
        let name = accelerator.kind().name();
        let mut hits = Vec::new();
        accelerator.all_hits(&Planes, &ray, Interval::FORWARD, &mut hits, &mut NoProbe);
        assert_eq!(hits.iter().map(key).collect::<Vec<_>>(), [(1.5f64.to_bits(), 0, 2)], "{name}");
        let mut first = [None; 4];
        assert_eq!(accelerator.first_hits(&Planes, &ray, Interval::FORWARD, &mut first, &mut NoProbe), 1, "{name}");
        let closest = closest!(accelerator, &Planes, &[(ray, Interval::FORWARD); 9], &mut NoProbe);
        assert!(closest.iter().all(|hit| hit.is_some_and(|hit| hit.t == 1.5)), "{name}");
    }
}

/// A callback that knows the geometry finds what the kernels find.
#[test]
fn candidates_for_a_callback_contain_the_closest_hit() {
    let soup = scene(5);
    for (accelerator, Query { ray, span }) in queries(&soup, 2000, 6)
        .into_iter()
        .flat_map(|query| AcceleratorKind::ALL.iter().map(move |&kind| (kind, query)))
        .map({
            let all = Accelerators::build(&soup);
            move |(kind, query)| (all.0.iter().find(|s| s.kind() == kind).unwrap().clone(), query)
        })
    {
        let expected = accelerator.closest(&soup, &ray, span, &mut NoProbe);
        let mut best: Option<Hit> = None;
        accelerator.visit_candidates(
            &soup,
            &ray,
            span,
            |index, inside| {
                assert!(span.min <= inside.min && inside.max <= span.max);
                let slab_ray = rt_accel::SlabRay::new(&ray);
                if let Some(hit) = rt_geometry::intersect_primitive(&soup, index, &slab_ray, span, &mut NoProbe)
                    && best.is_none_or(|nearest| hit.precedes(&nearest))
                {
                    best = Some(hit);
                }
                ControlFlow::Continue(best.map_or(f64::INFINITY, |hit| hit.t))
            },
            &mut NoProbe,
        );
        assert_eq!(best.as_ref().map(key), expected.as_ref().map(key), "{}: {ray:?}", accelerator.kind().name());
    }
}

fn overlapping(accelerator: &AnyAccelerator, soup: &Soup, region: &impl Region) -> BTreeSet<u32> {
    let mut found = BTreeSet::new();
    accelerator.visit_overlapping(soup, region, |index| {
        assert!(found.insert(index), "{}: {index} is visited twice", accelerator.kind().name());
        ControlFlow::Continue(())
    });
    found
}

fn frustum(draw: &mut Draw) -> Frustum {
    let (apex, size) = (draw.point() * 1.5, draw.between(0.1, 1.0));
    let corners = std::array::from_fn(|i| {
        let depth = if i & 4 == 0 { 0.2 } else { 2.0 };
        let side = |bit: usize| if i & bit == 0 { -size } else { size };
        apex + DVec3::new(side(1), side(2), -1.0) * depth
    });
    Frustum::from_corners(corners).unwrap()
}

#[test]
fn overlaps_are_found_once_each() {
    let soup = scene(7);
    let all = Accelerators::build(&soup);
    let mut draw = Draw::new(8);
    let mut n_found = 0;
    for _ in 0..1500 {
        let corner = draw.point() * 1.2;
        let aabb = if draw.one_in(4) {
            // Touches a box exactly.
            let bounds = soup.0[draw.below(30)].bounds().unwrap();
            Aabb::new(bounds.max, bounds.max + draw.point().abs() * 0.1)
        } else {
            Aabb::new(corner, corner + draw.point().abs() * draw.pick(&[0.0, 0.1, 2.0]))
        };
        let sphere = SphereRegion { centre: draw.point() * 1.5, radius: draw.pick(&[-1.0, 0.0, 0.1, 0.5, 3.0]) };
        let frustum = frustum(&mut draw);
        let expect = |overlaps: &dyn Fn(&Aabb) -> bool| -> BTreeSet<u32> {
            (0..soup.len() as u32).filter(|&i| soup.bounds(i).is_none_or(|bounds| overlaps(&bounds))).collect()
        };
        let expected = [
            expect(&|bounds| aabb.overlaps(bounds)),
            expect(&|bounds| sphere.overlaps(bounds)),
            expect(&|bounds| frustum.overlaps(bounds)),
        ];
        n_found += expected.iter().map(BTreeSet::len).sum::<usize>();
        for accelerator in &all.0 {
            let found = [
                overlapping(accelerator, &soup, &aabb),
                overlapping(accelerator, &soup, &sphere),
                overlapping(accelerator, &soup, &frustum),
            ];
            assert_eq!(found, expected, "{}: {aabb:?} {sphere:?} {frustum:?}", accelerator.kind().name());
        }
    }
    assert!(n_found > 100_000, "{n_found}");
}

/// A primitive that several leaves list is found once all the same.
#[test]
fn spatial_splits_do_not_repeat_overlaps() {
    let sticks = Soup::sticks(300, &mut Draw::new(21)).moved(DVec3::splat(1e6));
    let bvh = AnyAccelerator::Bvh(Bvh::build_with(&sticks, SplitMethod::Spatial).unwrap());
    let linear = AnyAccelerator::build(AcceleratorKind::Linear, &sticks).unwrap();
    let mut draw = Draw::new(22);
    let mut n_found = 0;
    for _ in 0..3000 {
        let sphere = SphereRegion { centre: DVec3::splat(1e6) + draw.point(), radius: draw.pick(&[0.0, 0.01, 0.3]) };
        // Touches the corner of a stick's box.
        let corner = sticks.bounds(draw.below(300) as u32).unwrap().max;
        for region in [sphere.bounds(), Aabb::new(corner, corner)] {
            let expected = overlapping(&linear, &sticks, &region);
            n_found += expected.len();
            assert_eq!(overlapping(&bvh, &sticks, &region), expected, "{region:?}");
        }
        assert_eq!(overlapping(&bvh, &sticks, &sphere), overlapping(&linear, &sticks, &sphere));
        assert_eq!(bvh.nearest_point(&sticks, sphere.centre, 9.0), linear.nearest_point(&sticks, sphere.centre, 9.0));
    }
    assert!(n_found > 10_000, "{n_found}");
}

#[test]
fn pairs_are_found_once_each_in_order() {
    let soup = scene(9);
    let overlaps = |i: u32, j: u32| match (soup.bounds(i), soup.bounds(j)) {
        (Some(a), Some(b)) => a.overlaps(&b),
        _ => true,
    };
    let n = soup.len() as u32;
    let expected: Vec<_> =
        (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))).filter(|&(i, j)| overlaps(i, j)).collect();
    assert!(expected.len() > 500);
    for accelerator in &Accelerators::build(&soup).0 {
        let mut pairs = Vec::new();
        accelerator.visit_overlapping_pairs(&soup, |i, j| {
            pairs.push((i, j));
            ControlFlow::Continue(())
        });
        assert!(pairs.is_sorted_by_key(|&(i, _)| i));
        pairs.sort_unstable();
        assert_eq!(pairs, expected, "{}", accelerator.kind().name());
        let mut n_visited = 0;
        accelerator.visit_overlapping_pairs(&soup, |_, _| {
            n_visited += 1;
            if n_visited == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(n_visited, 3, "{} goes on after a break", accelerator.kind().name());
    }
}

#[test]
fn nearest_points_are_those_of_exhaustive_search() {
    for offset in [0.0, 1e7] {
        let soup = scene(11).moved(DVec3::splat(offset));
        let all = Accelerators::build(&soup);
        let mut draw = Draw::new(12);
        let mut n_found = 0;
        for _ in 0..3000 {
            let point = DVec3::splat(offset) + draw.point() * draw.pick(&[0.5, 1.5, 30.0]);
            let radius = draw.pick(&[0.0, 0.05, 0.4, 5.0, f64::INFINITY, -1.0, f64::NAN]);
            let expected = all.0[0].nearest_point(&soup, point, radius);
            let smallest = (0..soup.len() as u32)
                .filter_map(|i| Some(soup.nearest_point(i, point)?.distance(point)))
                .fold(f64::INFINITY, f64::min);
            match expected {
                Some(hit) => {
                    assert!((hit.distance - smallest).abs() <= 1e-12 * (1.0 + offset) && hit.distance <= radius)
                }
                None => assert!(!(smallest < radius * (1.0 - 1e-12)), "{smallest} within {radius}"),
            }
            n_found += usize::from(expected.is_some());
            for accelerator in &all.0 {
                let found = accelerator.nearest_point(&soup, point, radius);
                assert_eq!(found, expected, "{}: {point} within {radius}", accelerator.kind().name());
            }
        }
        assert!(n_found > 1000, "{n_found}");
    }
}

/// Regression: a NaN counted as the distance of the bounds, which is 0 within them.
#[test]
fn nearest_points_without_a_number_are_passed_over() {
    struct Centres([DVec3; 2]);

    impl Primitives for Centres {
        fn len(&self) -> usize {
            2
        }
        fn bounds(&self, index: u32) -> Option<Aabb> {
            Some(Aabb::new(self.0[index as usize] - 1.0, self.0[index as usize] + 1.0))
        }
        fn intersect(&self, _: u32, _: &Ray, _: Interval) -> Option<Hit> {
            None
        }
    }

    impl ClosestPoint for Centres {
        fn nearest_point(&self, index: u32, point: DVec3) -> Option<DVec3> {
            let centre = self.0[index as usize];
            Some(centre + (point - centre) / (point - centre).length())
        }
    }

    let spheres = Centres([DVec3::ZERO, DVec3::X * 5.0]);
    for accelerator in &Accelerators::build(&spheres).0 {
        let name = accelerator.kind().name();
        let found = accelerator.nearest_point(&spheres, DVec3::ZERO, f64::INFINITY);
        assert_eq!(found.map(|hit| (hit.primitive, hit.distance)), Some((1, 4.0)), "{name}");
        for point in [DVec3::NAN, DVec3::X * f64::INFINITY] {
            assert_eq!(accelerator.nearest_point(&spheres, point, f64::INFINITY), None, "{name}");
        }
    }
}

/// Regression: the grid passed over boxes within a rounding error of a sphere, which others found.
#[test]
fn boxes_next_to_a_sphere_overlap_it_in_every_accelerator() {
    // Their padding is less than the rounding of the radius.
    let beyond = |k: u32| DVec3::new(f64::from(k) * -1e-16, 5e-10, 5e-10);
    let boxes = (1..16).map(|k| Solid::Ghost(Aabb::new(DVec3::new(-1e-9, -5e-10, -5e-10), beyond(k))));
    let soup = Soup(boxes.collect());
    let region = SphereRegion { centre: DVec3::X, radius: 1.0 };
    let all = Accelerators::build(&soup);
    let expected = overlapping(&all.0[0], &soup, &region);
    assert!(!expected.is_empty() && expected.len() < soup.len(), "{expected:?}");
    for accelerator in &all.0 {
        assert_eq!(overlapping(accelerator, &soup, &region), expected, "{}", accelerator.kind().name());
    }
}

/// Regression: the rounded square of the radius was less than the squared distance of the box.
#[test]
fn a_box_that_touches_a_sphere_overlaps_it() {
    let mut draw = Draw::new(15);
    for _ in 0..20_000 {
        // Offset and radius are (2, 3, 6) and 7 times a number of few digits, so that the box touches the sphere exactly.
        let size = (draw.unit() * 1024.0).floor() / 64.0 + 0.25;
        let sign = DVec3::from_array([(); 3].map(|()| if draw.unit() < 0.5 { -1.0 } else { 1.0 }));
        let near = sign * DVec3::new(2.0, 3.0, 6.0) * size;
        let touching = Aabb::new(near.min(near + sign), near.max(near + sign));
        assert!(SphereRegion { centre: DVec3::ZERO, radius: 7.0 * size }.overlaps(&touching), "{size}");
        // Rounded radius of a random corner.
        let corner = draw.point();
        let radius = corner.length().next_up().next_up();
        let around = Aabb::new(corner.min(corner * 2.0), corner.max(corner * 2.0));
        assert!(SphereRegion { centre: DVec3::ZERO, radius }.overlaps(&around), "{corner}");
    }
    // Found by an exact comparison.
    let centre = DVec3::new(-0.8390472862190976, 0.37690630120797963, 0.035983030180049);
    let min = DVec3::new(-0.1291094749954389, 0.48048938808394204, 0.1752992166723467);
    assert!(SphereRegion { centre, radius: 0.7308557665576356 }.overlaps(&Aabb::new(min, min + 1.0)));
}

/// Regression: the square of the distance, rounded, was less than the squared distance.
#[test]
fn a_point_exactly_at_the_maximum_distance_is_found() {
    let unit = Soup(vec![Solid::Triangle([DVec3::ZERO, DVec3::X, DVec3::Y])]);
    for accelerator in &Accelerators::build(&unit).0 {
        let name = accelerator.kind().name();
        let radius = 3f64.sqrt();
        let found = accelerator.nearest_point(&unit, DVec3::NEG_ONE, radius);
        assert_eq!(found.map(|hit| (hit.distance, hit.point)), Some((radius, DVec3::ZERO)), "{name}");
        assert_eq!(accelerator.nearest_point(&unit, DVec3::NEG_ONE, radius.next_down()), None, "{name}");
        let mut draw = Draw::new(14);
        for _ in 0..1000 {
            let point = draw.point() * draw.pick(&[1e-160, 1e-9, 1.0, 1e60]) - DVec3::Z * 1e-300;
            let Some(distance) = accelerator.nearest_point(&unit, point, f64::INFINITY).map(|hit| hit.distance) else {
                panic!("{name}: no point near {point}")
            };
            let found = accelerator.nearest_point(&unit, point, distance).map(|hit| hit.distance);
            assert_eq!(found, Some(distance), "{name}: {point}");
            let nearer = accelerator.nearest_point(&unit, point, distance.next_down());
            assert!(distance == 0.0 || nearer.is_none(), "{name}: {point}");
        }
    }
}

/// A query must not look at everything: that is what the accelerator is for.
#[test]
fn queries_look_at_a_small_part_only() {
    struct Counting<'a>(&'a Soup, std::sync::atomic::AtomicUsize);
    impl Primitives for Counting<'_> {
        fn len(&self) -> usize {
            self.0.len()
        }
        fn bounds(&self, index: u32) -> Option<Aabb> {
            self.1.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            self.0.bounds(index)
        }
        fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
            self.0.intersect(index, ray, span)
        }
    }
    impl ClosestPoint for Counting<'_> {
        fn nearest_point(&self, index: u32, point: DVec3) -> Option<DVec3> {
            self.0.nearest_point(index, point)
        }
    }
    let soup = Soup::spheres(20_000, &mut Draw::new(13));
    let counting = Counting(&soup, Default::default());
    for accelerator in &Accelerators::build(&counting).0 {
        if accelerator.kind() == AcceleratorKind::Linear {
            continue;
        }
        let looked_at = |query: &dyn Fn()| {
            counting.1.store(0, std::sync::atomic::Ordering::Relaxed);
            query();
            counting.1.load(std::sync::atomic::Ordering::Relaxed)
        };
        let nearest =
            looked_at(&|| assert!(accelerator.nearest_point(&counting, DVec3::splat(0.1), f64::INFINITY).is_some()));
        let sphere = SphereRegion { centre: DVec3::splat(0.2), radius: 0.03 };
        let overlaps = looked_at(&|| accelerator.visit_overlapping(&counting, &sphere, |_| ControlFlow::Continue(())));
        let name = accelerator.kind().name();
        assert!(nearest < 400 && overlaps < 800, "{name}: {nearest} for the nearest, {overlaps} for a ball");
    }
}
