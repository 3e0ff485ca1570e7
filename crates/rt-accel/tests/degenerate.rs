//! Sets of primitives, spans and rays that break accelerators which were only tried on pleasant ones.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests fail by panicking and print what they tried")]

mod soup;

use rt_accel::{
    Aabb, Accelerator, AcceleratorKind, AnyAccelerator, Bih, BspTree, BuildError, CylinderTree, DVec3, Hit, Interval,
    KdTree, LazyBih, Linear, NoProbe, Primitives, Ray, SphereKernel, SphereTree, UniformGrid, ValidationError, WideBvh,
    brute_force,
    wide::{BuildParams, SimdLevel},
};
use soup::draw::Draw;
use soup::structures::{Structures, tests_per_ray};
use soup::{Solid, Soup, sheet};

const FORWARD: Interval = Interval::FORWARD;

fn unit_box(corner: DVec3) -> Solid {
    Solid::Box(Aabb::new(corner, corner + 1.0))
}

fn down(x: f64, z: f64) -> Ray {
    Ray::new(DVec3::new(x, 10.0, z), DVec3::NEG_Y)
}

/// Rays from a sphere around the box to random points of it.
fn rays_at(target: &Aabb, count: usize) -> Vec<Ray> {
    let mut draw = Draw::new(9);
    let radius = target.extent().length();
    (0..count)
        .map(|_| {
            let origin = target.centre() + draw.point().normalize_or(DVec3::X) * radius;
            let point = target.centre() + draw.point() * 0.5 * target.extent();
            Ray::new(origin, point - origin)
        })
        .collect()
}

#[test]
fn nothing_is_never_hit() {
    let soup = Soup::default();
    let all = Structures::build(&soup);
    assert_eq!(all.closest(&soup, &down(0.0, 0.0), FORWARD), None);
    assert_eq!(all.bvh().build_stats().leaves, 0);
    assert_eq!(all.closest(&soup, &Ray::new(DVec3::NAN, DVec3::NAN), FORWARD), None);
}

#[test]
fn one_primitive_is_hit() {
    let soup = Soup(vec![unit_box(DVec3::ZERO)]);
    let all = Structures::build(&soup);
    assert_eq!(all.closest(&soup, &down(0.5, 0.5), FORWARD).unwrap().t, 9.0);
    assert_eq!(all.closest(&soup, &down(2.0, 0.5), FORWARD), None);
    assert_eq!((all.bvh().build_stats().nodes, all.bvh().build_stats().leaves), (0, 1));
}

#[test]
fn of_identical_primitives_the_first_wins() {
    for count in [2, 3, 9, 100] {
        let soup = Soup(vec![unit_box(DVec3::ZERO); count]);
        let all = Structures::build(&soup);
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
    let hit = Structures::build(&set).closest(&set, &down(0.5, 0.5), FORWARD).unwrap();
    assert_eq!((hit.instance, hit.primitive), (51, 49));
}

#[test]
fn identical_centroids_are_halved_into_small_leaves() {
    let soup = Soup(vec![Solid::Ghost(Aabb::new(DVec3::ONE, DVec3::splat(2.0))); 200_000]);
    let all = Structures::build(&soup);
    let stats = all.bvh().build_stats();
    assert!(stats.leaves >= 200_000 / 8 && stats.max_depth <= 16, "{stats:?}");
    let grid = all.grid().build_stats();
    assert!(grid.references <= 17 * 200_000, "{grid:?}");

    // The same centroid, but all of different size.
    let nested = |i: u64| Aabb::new(DVec3::splat(-(i as f64)), DVec3::splat(i as f64));
    let soup = Soup((1..3000).map(|i| Solid::Box(nested(i))).collect());
    let all = Structures::build(&soup);
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
    let all = Structures::build(&soup);
    for structure in &all.0[1..] {
        assert!(tests_per_ray(structure, &soup, &[down(50.5, 50.5)]) < 20.0, "{}", structure.kind().name());
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
fn rays_in_the_planes_of_a_tree_miss_nothing() {
    let soup = Soup::mixed(&mut Draw::new(31));
    let all = Structures::build(&soup);
    let mut draw = Draw::new(32);
    for kind in [AcceleratorKind::Kd, AcceleratorKind::Bsp] {
        let mut cells = Vec::new();
        all.0.iter().find(|structure| structure.kind() == kind).unwrap().for_each_box(|cell, _| cells.push(cell));
        assert!(cells.len() > 300, "{}", cells.len());
        for _ in 0..20_000 {
            let cell = draw.pick(&cells);
            let axis = draw.below(3);
            let mut origin = draw.point() * 2.0;
            let mut direction = draw.pick(&cell.corners()) - origin;
            origin[axis] =
                draw.pick(&[cell.min[axis], cell.max[axis], cell.max[axis].next_up(), cell.min[axis].next_down()]);
            direction[axis] = draw.pick(&[0.0, -0.0, 5e-324, -1e-310, 1e-17]);
            all.closest(&soup, &Ray::new(origin, direction), FORWARD);
            all.closest(&soup, &Ray::new(origin, direction), Interval::new(-1.0, 1.0));
        }
    }
}

#[test]
fn flat_scenes_are_divided_along_the_plane() {
    for flat in [|x, z| DVec3::new(x, 0.0, z), |x, z| DVec3::new(x, z, 0.0), |x, z| DVec3::new(-3.0, x, z)] {
        let soup = Soup(sheet(40, flat).collect());
        let all = Structures::build(&soup);
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
    let all = Structures::build(&soup);
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
    for _ in 0..100_000 {
        let corner = draw.point();
        soup.0.push(Solid::Box(Aabb::new(corner, corner + 1e-3)));
    }
    let all = Structures::build(&soup);
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
    let two_sided = Soup((-140..120).flat_map(|i| [exp2(i), -exp2(i)]).flat_map(|x| [at(x); 100]).collect());
    for (soup, min_depth) in [(one_sided, 10), (two_sided, 45)] {
        let all = Structures::build(&soup);
        let depth = all.bvh().build_stats().max_depth;
        assert!((min_depth..=60).contains(&depth), "depth {depth}");
        for i in -140..0 {
            all.closest(&soup, &Ray::new(DVec3::new(exp2(i), 1.0, 0.0), DVec3::NEG_Y), FORWARD).unwrap();
        }
    }
}

fn exp2(exponent: i32) -> f64 {
    rt_math::transcendental::exp2(f64::from(exponent))
}

#[test]
fn bounds_that_are_no_boxes_are_refused_by_index() {
    let good = Aabb::new(DVec3::ZERO, DVec3::ONE);
    let bad = [
        (Aabb::new(DVec3::new(0.0, f64::NAN, 0.0), DVec3::ONE), "NaN"),
        (Aabb::new(DVec3::ZERO, DVec3::NAN), "NaN"),
        (Aabb::new(DVec3::ONE, DVec3::ZERO), "min exceeds max"),
        (Aabb::EMPTY, "min exceeds max"),
        (Aabb::new(DVec3::NEG_INFINITY, DVec3::INFINITY), "return `None`"),
        (Aabb::new(DVec3::ZERO, DVec3::new(1.0, f64::INFINITY, 1.0)), "return `None`"),
        (Aabb::new(DVec3::ZERO, DVec3::splat(f64::MAX)), "return `None`"),
    ];
    for (bounds, reason) in bad {
        let mut soup = Soup(vec![Solid::Ghost(good); 9]);
        soup.0[7] = Solid::Ghost(bounds);
        soup.0[8] = Solid::Ghost(bounds);
        let of_kinds = AcceleratorKind::ALL.iter().map(|&kind| AnyAccelerator::build(kind, &soup).unwrap_err());
        for error in of_kinds.chain([UniformGrid::with_resolution(&soup, [2; 3]).unwrap_err()]) {
            assert!(matches!(error, BuildError::BadBounds { index: 7, .. }), "{error:?}");
            assert!(error.to_string().contains("primitive 7") && error.to_string().contains(reason), "{error}");
        }
    }
}

#[test]
fn too_many_primitives_or_cells_are_refused() {
    struct Endless;
    impl Primitives for Endless {
        fn len(&self) -> usize {
            u32::MAX as usize
        }
        fn bounds(&self, _: u32) -> Option<Aabb> {
            None
        }
        fn intersect(&self, _: u32, _: &Ray, _: Interval) -> Option<Hit> {
            None
        }
    }
    let expected = BuildError::TooMany { count: u64::from(u32::MAX), limit: u64::from(u32::MAX - 1) };
    for &kind in AcceleratorKind::ALL {
        assert_eq!(AnyAccelerator::build(kind, &Endless).unwrap_err(), expected, "{}", kind.name());
    }

    let soup = Soup(vec![unit_box(DVec3::ONE); 100]);
    for resolution in [[4096; 3], [u32::MAX; 3], [300; 3]] {
        let error = UniformGrid::with_resolution(&soup, resolution).unwrap_err();
        assert!(matches!(error, BuildError::TooMany { .. }), "{error:?}");
    }
}

#[test]
fn unbounded_primitives_are_found_behind_and_before_others() {
    let mut soup = Soup::spheres(50, &mut Draw::new(6));
    soup.0.insert(10, Solid::Ground { height: 0.0 });
    soup.0.push(Solid::Ground { height: 0.0 });
    let all = Structures::build(&soup);
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
    assert_eq!(Structures::build(&only).closest(&only, &down(1e9, -1e9), FORWARD).unwrap().t, 9.0);
}

#[test]
fn rays_in_walls_and_through_corners_of_cells_miss_nothing() {
    // Unit boxes that fill 8³ cells; walls, edges and corners of cells and of nodes coincide with theirs.
    let corners = (0..512).map(|i| DVec3::new(f64::from(i % 8), f64::from(i / 8 % 8), f64::from(i / 64)));
    let soup = Soup(corners.map(unit_box).collect());
    let mut all = Structures::build(&soup);
    let directions = [-1.0, -0.0, 0.0, 1.0, 0.5];
    for n in [8, 4, 7] {
        all.0.retain(|structure| structure.kind() != AcceleratorKind::Grid);
        all.0.push(AnyAccelerator::Grid(UniformGrid::with_resolution(&soup, [n; 3]).unwrap()));
        for i in 0..125 {
            let direction = DVec3::new(directions[i % 5], directions[i / 5 % 5], directions[i / 25]);
            for corner in [DVec3::splat(4.0), DVec3::new(0.0, 3.0, 8.0), DVec3::new(1.0, 2.5, 8.0)] {
                for back in [0.0, 20.0, 0.5] {
                    let ray = Ray::new(corner - direction * back, direction);
                    let hit = all.closest(&soup, &ray, FORWARD);
                    assert!(hit.is_some() || direction == DVec3::ZERO, "{ray:?}");
                }
            }
        }
    }
}

#[test]
fn spans_are_closed_and_may_be_points() {
    let soup = Soup(vec![unit_box(DVec3::ZERO), unit_box(DVec3::new(0.0, -5.0, 0.0))]);
    let all = Structures::build(&soup);
    let ask = |min, max| all.closest(&soup, &down(0.5, 0.5), Interval::new(min, max)).map(|hit| hit.t);
    assert_eq!(ask(9.0, 9.0), Some(9.0));
    assert_eq!(ask(0.0, 9.0), Some(9.0));
    assert_eq!(ask(0.0, 9.0f64.next_down()), None);
    assert_eq!(ask(0.0, 0.0), None);
    assert_eq!(ask(11.0, 13.0), None);
    assert_eq!(ask(14.0, 14.0), Some(14.0));
    assert_eq!(ask(2.0, 1.0), None);
    assert_eq!(ask(f64::NAN, 20.0), None);
    assert_eq!(ask(0.0, f64::NAN), None);
    let touching = Ray::new(DVec3::new(0.5, 1.0, 0.5), DVec3::NEG_Y);
    assert_eq!(all.closest(&soup, &touching, Interval::new(0.0, 0.0)).unwrap().t, 0.0);
}

#[test]
fn rays_that_are_no_rays_get_the_same_answer_everywhere() {
    let soup = Soup::mixed(&mut Draw::new(11));
    let all = Structures::build(&soup);
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -f64::MAX, 0.0, -0.0, 5e-324, 1.0];
    let mut draw = Draw::new(12);
    for _ in 0..20_000 {
        let mut vector = || DVec3::new(draw.pick(&odd), draw.pick(&odd), draw.pick(&odd));
        let ray = Ray::new(vector(), vector());
        all.closest(&soup, &ray, FORWARD);
        all.closest(&soup, &ray, Interval::new(-1.0, 1.0));
    }
}

#[test]
fn culling_is_as_good_far_from_the_origin_as_at_it() {
    for offset in [0.0, 1e3, 1e5, 1e7] {
        let offset = DVec3::new(1.0, -0.7, 0.3) * offset;
        let soup = Soup::spheres(20_000, &mut Draw::new(8)).moved(offset);
        let all = Structures::build(&soup);
        let rays = rays_at(&Aabb::new(offset - 1.0, offset + 1.0), 200);
        for ray in &rays {
            all.closest(&soup, ray, FORWARD);
        }
        let (tree, grid) = (tests_per_ray(all.bvh(), &soup, &rays), tests_per_ray(all.grid(), &soup, &rays));
        println!("offset {offset}: {tree} tests per ray in the tree, {grid} in the grid");
        assert!(tree < 12.0 && grid < 40.0, "offset {offset}: {tree} {grid}");
    }
}

#[test]
fn memory_is_what_the_parts_add_up_to() {
    let soup = Soup::spheres(10_000, &mut Draw::new(2));
    let all = Structures::build(&soup);
    let (tree, grid) = (all.bvh().build_stats(), all.grid().build_stats());
    assert_eq!(tree.references, 10_000);
    assert_eq!(tree.leaves, tree.nodes + 1);
    let tree_bytes = 64 * tree.nodes + 4 * tree.references;
    assert!((tree_bytes..tree_bytes + 512).contains(&all.bvh().memory()), "{} {tree:?}", all.bvh().memory());
    assert!(all.bvh().memory() < 64 * 10_000);
    let grid_bytes = 4 * (grid.nodes + 1 + grid.references);
    assert!((grid_bytes..grid_bytes + 512).contains(&all.grid().memory()), "{} {grid:?}", all.grid().memory());
    assert!((16 * 10_000..17 * 10_000).contains(&all.linear().memory()), "{}", all.linear().memory());
    let grounds = Soup(vec![Solid::Ground { height: 0.0 }; 1000]);
    assert!(Linear::build(&grounds).unwrap().memory() < 256, "nothing is copied");
}

#[test]
fn structures_notice_that_primitives_have_changed() {
    let mut soup = Soup::spheres(300, &mut Draw::new(1));
    let all = Structures::build(&soup);
    let verdicts = |soup: &Soup| all.0[1..].iter().map(|structure| structure.validate(soup)).collect::<Vec<_>>();
    let each = |verdict| vec![verdict; all.0.len() - 1];

    let last = soup.0.pop().unwrap();
    let fewer = ValidationError::Count { built: 300, given: 299 };
    assert_eq!(verdicts(&soup), each(Err(fewer)));
    assert_eq!(all.linear().validate(&soup), Err(fewer));
    soup.0.push(Solid::Ground { height: 0.0 });
    assert_eq!(all.linear().validate(&soup), Err(ValidationError::Outside { primitive: 299 }));
    assert_eq!(verdicts(&soup), each(Err(ValidationError::Misplaced { primitive: 299 })));
    soup.0[299] = Solid::Box(Aabb::new(DVec3::splat(5.0), DVec3::splat(6.0)));
    assert_eq!(verdicts(&soup), each(Err(ValidationError::Outside { primitive: 299 })));
    assert_eq!(all.linear().validate(&soup), Err(ValidationError::Outside { primitive: 299 }));
    soup.0[299] = last;
    assert_eq!(verdicts(&soup), each(Ok(())));
    assert_eq!(all.linear().validate(&soup), Ok(()));
}

#[test]
fn batches_equal_single_queries() {
    let soup = Soup::mixed(&mut Draw::new(21));
    let all = Structures::build(&soup);
    let rays: Vec<_> =
        rays_at(&Aabb::new(DVec3::splat(-1.0), DVec3::ONE), 100).into_iter().map(|ray| (ray, FORWARD)).collect();
    let mut hits = vec![None; 100];
    let mut blocked = vec![false; 100];
    all.bvh().closest_batch(&soup, &rays, &mut hits, &mut NoProbe);
    all.bvh().occluded_batch(&soup, &rays, &mut blocked, &mut NoProbe);
    for (i, (ray, span)) in rays.iter().enumerate() {
        assert_eq!(hits[i], all.closest(&soup, ray, *span));
        assert_eq!(blocked[i], hits[i].is_some());
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

/// In single precision the ray passes through the centre, although it misses it by a hundred radii.
#[test]
fn a_ray_through_the_rounded_centre_of_a_tiny_sphere_misses_it() {
    let sphere = |centre: [f64; 3], radius: f64| Solid::Sphere { centre: centre.into(), radius };
    let soup = Soup(vec![
        sphere([-2.0, 0.0, 0.0], 0.25),
        sphere([2.0, 0.0, 0.0], 0.25),
        sphere([0.0, 0.0, -1.0], 0.1),
        sphere([0.5, 0.0, 1.0], 0.1),
        sphere([0.5 + 1e-10, 0.0, 0.0], 1e-12),
    ]);
    let ray = Ray::new(DVec3::new(0.5, 0.0, -3.0), DVec3::Z);
    for level in SimdLevel::ALL.iter().copied().filter(|level| level.is_available()) {
        let wide = WideBvh::build(&soup).unwrap().with_level(level);
        let hit = wide.closest(&soup, &ray, FORWARD, &mut NoProbe).map(|hit| hit.primitive);
        assert_eq!(hit, Some(3), "{level:?}");
        assert!(!wide.occluded(&soup, &ray, Interval::new(0.0, 3.5), &mut NoProbe), "{level:?}");
    }
}

/// Rays that miss the centre or the sphere, also where the squares of such distances underflow in `f32`. Spans are
/// whole, end between both intersections, or begin there.
#[test]
fn spheres_whose_squares_vanish_are_hit_and_missed_as_they_are() {
    let sphere = |centre: DVec3, radius: f64| Solid::Round(SphereKernel { centre, radius });
    for scale in [1.0, 1e-8, 1e-12, 1e-16, 1e-20, 1e-24, 1e-30] {
        // The centre of the tree is that of the little sphere.
        let soup =
            Soup(vec![sphere(DVec3::ZERO, scale), sphere(DVec3::X * 50.0, 1.0), sphere(DVec3::NEG_X * 50.0, 1.0)]);
        let spans = [Interval::FORWARD, Interval::new(0.0, 6.99 * scale), Interval::new(7.01 * scale, f64::INFINITY)];
        let asides = [(0.0, true), (0.5, true), (0.99, true), (1.01, false), (1.5, false)];
        for (span, (aside, is_hit)) in spans.into_iter().flat_map(|span| asides.map(|aside| (span, aside))) {
            let ray = Ray::new(DVec3::new(0.0, aside, -7.0) * scale, DVec3::Z);
            let expected = brute_force::closest(&soup, &ray, span, &mut NoProbe);
            assert_eq!(expected.is_some(), is_hit, "{aside} of {scale}");
            for &level in SimdLevel::ALL {
                let params = BuildParams { max_leaf: 1, ..BuildParams::default() };
                let tree = WideBvh::build_with(&soup, &params).expect("three spheres").with_level(level);
                let found = tree.closest(&soup, &ray, span, &mut NoProbe);
                assert_eq!(found, expected, "{aside} of {scale}");
                let blocked = tree.occluded(&soup, &ray, span, &mut NoProbe);
                assert_eq!(blocked, is_hit, "{aside} of {scale}");
            }
        }
    }
}
