//! Degenerate sets of primitives.

use rt_accel::{
    Aabb, Accelerator, AcceleratorKind, AnyAccelerator, Bih, BspTree, CylinderTree, DVec3, Hit, Interval, KdTree,
    LazyBih, NoProbe, Primitives, Ray, SphereTree, brute_force,
};

use super::{FORWARD, down, exp2, rays_at, unit_box};
use crate::soup::accelerators::{Accelerators, tests_per_ray};
use crate::soup::{Solid, Soup, sheet};
use rt_tests::Draw;

#[test]
fn nothing_is_never_hit() {
    let soup = Soup::default();
    let all = Accelerators::build(&soup);
    assert_eq!(all.closest(&soup, &down(0.0, 0.0), FORWARD), None);
    assert_eq!(all.bvh().build_stats().leaves, 0);
    assert_eq!(all.closest(&soup, &Ray::new(DVec3::NAN, DVec3::NAN), FORWARD), None);
}

#[test]
fn one_primitive_is_hit() {
    let soup = Soup(vec![unit_box(DVec3::ZERO)]);
    let all = Accelerators::build(&soup);
    assert_eq!(all.closest(&soup, &down(0.5, 0.5), FORWARD).unwrap().t, 9.0);
    assert_eq!(all.closest(&soup, &down(2.0, 0.5), FORWARD), None);
    assert_eq!((all.bvh().build_stats().nodes, all.bvh().build_stats().leaves), (0, 1));
}

#[test]
fn of_identical_primitives_the_first_wins() {
    for count in [2, 3, 9, 100] {
        let soup = Soup(vec![unit_box(DVec3::ZERO); count]);
        let all = Accelerators::build(&soup);
        let hit = all.closest(&soup, &down(0.5, 0.5), FORWARD).unwrap();
        assert_eq!((hit.t, hit.primitive), (9.0, 0));
    }
}

#[test]
fn equal_t_goes_to_the_lower_instance_before_the_lower_primitive() {
    /// Reports its members as primitive 0 of ever lower instances.
    struct Reversed(Soup);
    impl Primitives for Reversed {
        fn len(&self) -> usize {
            self.0.len()
        }
        fn bounds(&self, index: u32) -> Option<Aabb> {
            self.0.bounds(index)
        }
        fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
            let hit = self.0.intersect(index, ray, span)?;
            Some(Hit { instance: 100 - index, primitive: index, ..hit })
        }
    }
    let set = Reversed(Soup(vec![unit_box(DVec3::ZERO); 50]));
    let hit = Accelerators::build(&set).closest(&set, &down(0.5, 0.5), FORWARD).unwrap();
    assert_eq!((hit.instance, hit.primitive), (51, 49));
}

#[test]
fn identical_centroids_are_halved_into_small_leaves() {
    let soup = Soup(vec![Solid::Ghost(Aabb::new(DVec3::ONE, DVec3::splat(2.0))); 200_000]);
    let all = Accelerators::build(&soup);
    let stats = all.bvh().build_stats();
    assert!(stats.leaves >= 200_000 / 8 && stats.max_depth <= 16, "{stats:?}");
    let grid = all.grid().build_stats();
    assert!(grid.references <= 17 * 200_000, "{grid:?}");

    // The same centroid, but all of different size.
    let nested = |i: u64| Aabb::new(DVec3::splat(-(i as f64)), DVec3::splat(i as f64));
    let soup = Soup((1..3000).map(|i| Solid::Box(nested(i))).collect());
    let all = Accelerators::build(&soup);
    assert_eq!(all.closest(&soup, &Ray::new(DVec3::ZERO, DVec3::X), FORWARD).unwrap().primitive, 0);
    assert_eq!(all.closest(&soup, &Ray::new(DVec3::X * 1e4, DVec3::NEG_X), FORWARD).unwrap().primitive, 2998);
}

#[test]
fn a_million_identical_boxes_are_one_leaf_of_a_partition() {
    let soup = Soup(vec![Solid::Ghost(Aabb::new(DVec3::ONE, DVec3::splat(2.0))); 1_000_000]);
    for stats in [KdTree::build(&soup).unwrap().build_stats(), BspTree::build(&soup).unwrap().build_stats()] {
        assert_eq!((stats.nodes, stats.leaves, stats.references), (0, 1, 1_000_000));
    }
    // With something else around, it is cut off.
    let mut soup = Soup(vec![Solid::Ghost(Aabb::new(DVec3::ONE, DVec3::splat(2.0))); 10_000]);
    soup.0.extend([unit_box(DVec3::splat(50.0)), unit_box(DVec3::splat(-50.0))]);
    let all = Accelerators::build(&soup);
    for accelerator in &all.0[1..] {
        assert!(tests_per_ray(accelerator, &soup, &[down(50.5, 50.5)]) < 20.0, "{}", accelerator.kind().name());
    }
}

#[test]
fn boxes_around_each_other_take_no_more_than_the_budget() {
    let nested = |i: u32| Aabb::new(DVec3::splat(-f64::from(i)), DVec3::splat(f64::from(i)));
    let soup = Soup((1..20_000).map(|i| Solid::Ghost(nested(i))).collect());
    for stats in [KdTree::build(&soup).unwrap().build_stats(), BspTree::build(&soup).unwrap().build_stats()] {
        assert!(stats.references + stats.nodes <= 16 * 20_000 + 4096 && stats.max_depth <= 60, "{stats:?}");
    }
}

#[test]
fn denormal_and_huge_coordinates_are_divided_where_they_can_be() {
    for scale in [5e-324, 1e-310, 1e-300, 1e300, 1e306] {
        let corner = |i: u64| DVec3::new((i % 20) as f64, (i / 20 % 20) as f64, (i / 400) as f64);
        let boxes = (0..2000).map(|i| Aabb::new(corner(i) * scale, (corner(i) + 1.0) * scale));
        let soup = Soup(boxes.map(Solid::Box).collect());
        for &kind in AcceleratorKind::ALL {
            let tree = AnyAccelerator::build(kind, &soup).unwrap();
            assert_eq!(tree.validate(&soup), Ok(()), "{} at {scale}", kind.name());
            assert!(tree.build_stats().max_depth <= 60);
            // Boxes of the smallest number have no plane between them.
            let may_be_divided = kind == AcceleratorKind::Kd && scale > 5e-324;
            assert!(!may_be_divided || tree.build_stats().leaves > 100, "{:?}", tree.build_stats());
            for i in 0..200 {
                let origin = corner(i * 7) * scale;
                let ray = Ray::new(origin, DVec3::splat(2.2) * scale - origin);
                let expected = brute_force::closest(&soup, &ray, FORWARD, &mut NoProbe);
                let found = tree.closest(&soup, &ray, FORWARD, &mut NoProbe);
                assert_eq!(found, expected, "{}, scale {scale}: {ray:?}", kind.name());
            }
        }
    }
}

#[test]
fn flat_scenes_are_divided_along_the_plane() {
    for flat in [|x, z| DVec3::new(x, 0.0, z), |x, z| DVec3::new(x, z, 0.0), |x, z| DVec3::new(-3.0, x, z)] {
        let soup = Soup(sheet(40, flat).collect());
        let all = Accelerators::build(&soup);
        let resolution = all.grid().resolution();
        assert!(resolution.contains(&1) && resolution.iter().max() > Some(&40), "{resolution:?}");
        let world = Aabb::from_points(soup.0.iter().filter_map(Solid::bounds).flat_map(|b| b.corners()));
        let rays = rays_at(&world, 500);
        let n_hits = rays.iter().filter(|ray| all.closest(&soup, ray, FORWARD).is_some()).count();
        assert!(n_hits > 490, "{n_hits}");
        assert!(tests_per_ray(all.bvh(), &soup, &rays) < 12.0 && tests_per_ray(all.grid(), &soup, &rays) < 40.0);
        // Within the plane: every triangle is seen edge-on, and every cell wall too.
        let inside = Ray::new(world.min, world.extent());
        all.closest(&soup, &inside, FORWARD);
    }
}

#[test]
fn scenes_on_a_line_are_divided_along_it() {
    let soup = Soup((0..1000).map(|i| unit_box(DVec3::new(0.0, 0.0, 3.0 * f64::from(i)))).collect());
    let all = Accelerators::build(&soup);
    assert!(all.grid().resolution()[2] > 500, "{:?}", all.grid().resolution());
    let along = Ray::new(DVec3::new(0.5, 0.5, 1e4), DVec3::NEG_Z);
    assert_eq!(all.closest(&soup, &along, FORWARD).unwrap().primitive, 999);
    let opposite = Ray::new(DVec3::new(0.5, 0.5, -1e4), DVec3::Z);
    for ray in [along, opposite] {
        // The near end comes first and hides the rest, whichever end that is.
        assert!(tests_per_ray(all.bvh(), &soup, &[ray]) < 9.0 && tests_per_ray(all.grid(), &soup, &[ray]) < 9.0);
    }
    for i in 0..1000 {
        let hit = all.closest(&soup, &down(0.5, 3.0 * f64::from(i) + 0.5), FORWARD).unwrap();
        assert_eq!(hit.primitive, i as u32);
        assert_eq!(all.closest(&soup, &down(0.5, 3.0 * f64::from(i) + 2.0), FORWARD), None);
    }
}

#[test]
fn a_teapot_in_a_stadium_costs_the_tree_little() {
    let mut draw = Draw::new(4);
    let stadium = Aabb::new(DVec3::splat(-5e5), DVec3::splat(5e5));
    let mut soup = Soup(vec![Solid::Box(stadium)]);
    for _ in 0..20_000 {
        let corner = draw.point();
        soup.0.push(Solid::Box(Aabb::new(corner, corner + 1e-3)));
    }
    let all = Accelerators::build(&soup);
    let mut rays = rays_at(&Aabb::new(DVec3::splat(-1.0), DVec3::ONE), 50);
    rays.extend(rays_at(&stadium, 50));
    for ray in &rays {
        all.closest(&soup, ray, FORWARD);
    }
    let (tree, grid) = (tests_per_ray(all.bvh(), &soup, &rays), tests_per_ray(all.grid(), &soup, &rays));
    println!("teapot in a stadium: {tree} tests per ray in the tree, {grid} in the grid");
    assert!(tree < 10.0, "{tree}");
}

#[test]
fn trees_over_powers_of_two_stay_shallow() {
    let at = |x: f64| Solid::Box(Aabb::new(DVec3::new(x, 0.0, 0.0), DVec3::new(x, 1e-3 * x.abs(), 0.0)));
    let one_sided = Soup((0..1075).map(|i| at(exp2(-i))).collect());
    // Around the centre of the tree all of f32's exponents are there to split by, and each place is crowded.
    let two_sided = Soup((-140..120).flat_map(|i| [exp2(i), -exp2(i)]).flat_map(|x| [at(x); 50]).collect());
    for (soup, min_depth) in [(one_sided, 10), (two_sided, 45)] {
        let all = Accelerators::build(&soup);
        let depth = all.bvh().build_stats().max_depth;
        assert!((min_depth..=60).contains(&depth), "depth {depth}");
        for i in -140..0 {
            all.closest(&soup, &Ray::new(DVec3::new(exp2(i), 1.0, 0.0), DVec3::NEG_Y), FORWARD).unwrap();
        }
    }
}

#[test]
fn unbounded_primitives_are_found_behind_and_before_others() {
    let mut soup = Soup::spheres(50, &mut Draw::new(6));
    soup.0.insert(10, Solid::Ground { height: 0.0 });
    soup.0.push(Solid::Ground { height: 0.0 });
    let all = Accelerators::build(&soup);
    assert_eq!(all.bvh().build_stats().unbounded, 2);
    assert_eq!(all.grid().build_stats().unbounded, 2);
    assert_eq!(all.linear().build_stats().unbounded, 2);
    let mut grounds = 0;
    for ray in rays_at(&Aabb::new(DVec3::splat(-1.0), DVec3::ONE), 500) {
        let hit = all.closest(&soup, &ray, FORWARD);
        grounds += usize::from(hit.is_some_and(|hit| hit.primitive == 10));
        assert!(hit.is_none_or(|hit| hit.primitive != 51), "the first of two equal grounds wins");
    }
    assert!((50..450).contains(&grounds), "{grounds}");

    let only = Soup(vec![Solid::Ground { height: 1.0 }]);
    assert_eq!(Accelerators::build(&only).closest(&only, &down(1e9, -1e9), FORWARD).unwrap().t, 9.0);
}

#[test]
fn culling_is_as_good_far_from_the_origin_as_at_it() {
    for offset in [0.0, 1e3, 1e5, 1e7] {
        let offset = DVec3::new(1.0, -0.7, 0.3) * offset;
        let soup = Soup::spheres(5000, &mut Draw::new(8)).moved(offset);
        let all = Accelerators::build(&soup);
        let rays = rays_at(&Aabb::new(offset - 1.0, offset + 1.0), 200);
        for ray in &rays {
            all.closest(&soup, ray, FORWARD);
        }
        let (tree, grid) = (tests_per_ray(all.bvh(), &soup, &rays), tests_per_ray(all.grid(), &soup, &rays));
        println!("offset {offset}: {tree} tests per ray in the tree, {grid} in the grid");
        assert!(tree < 9.0 && grid < 30.0, "offset {offset}: {tree} {grid}");
    }
}

#[test]
fn no_leaf_of_any_tree_is_too_deep_or_too_full() {
    let at = |x: f64| Solid::Box(Aabb::new(DVec3::new(x, 0.0, 0.0), DVec3::new(x, 1e-3 * x.abs(), 0.0)));
    let same = Soup(vec![unit_box(DVec3::ONE); 20_000]);
    let powers = Soup((0..1075).map(|i| at(exp2(-i))).collect());
    let crowded = Soup((-1000..1000).flat_map(|i| [exp2(i), -exp2(i)]).flat_map(|x| [at(x); 20]).collect());
    for soup in [same, powers, crowded] {
        let [spheres, cylinders] =
            [SphereTree::build(&soup).unwrap().build_stats(), CylinderTree::build(&soup).unwrap().build_stats()];
        let lazy = LazyBih::build(&soup).unwrap();
        lazy.complete();
        let bih = Bih::build(&soup).unwrap().build_stats();
        assert_eq!(lazy.build_stats(), bih);
        for (stats, most) in [(spheres, 8), (cylinders, 8), (bih, 4)] {
            assert!(stats.max_depth <= 60 && stats.leaves >= soup.len() / most, "{stats:?}");
        }
    }
}
