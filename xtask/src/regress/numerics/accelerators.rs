//! Extreme scenes for accelerators.

use std::{f64::consts::FRAC_1_SQRT_2, time::Instant};

use rt_accel::{Accelerator, AcceleratorKind, AnyAccelerator, LazyBih, UniformGrid};
use rt_geometry::{Counters, Cuboid, Hit, NoProbe, Primitives, Shape, Sphere, Triangle};
use rt_math::{Aabb, DVec3, Interval, Ray, transcendental::exp2};
use rt_tests::{Draw, ShapeSet};

use super::{
    Case, Checks, Conditions, Fallible, cases,
    scenes::{all_accelerators, key},
};

cases! {
    "S37", "nothing, in all accelerators", "no hit", "bits", nothing;
    "S38", "one primitive", "the hits of brute force", "bits", one;
    "S39", "1e6 identical spheres", "the first; depth ≤ 60, built in less than 2 s", "bits", identical;
    "S40", "centroids at 2^−i, i ≤ 1074", "the hits of brute force; depth ≤ 60", "bits", powers_of_two;
    "S41", "all in one plane", "the hits of brute force", "bits", flat;
    "S42", "teapot in a stadium: 1e6 boxes in one 1e9 times as large",
        "the hits of brute force; visits are printed", "bits", stadium;
    "S43", "rays in the planes that accelerators split by", "the hits of brute force", "bits", split_planes;
    "S44", "rays through the corners of 256³ cells", "the hits of brute force", "bits", cell_corners;
    "S45", "a walk through 1e5 cells of a grid", "each sheet in its turn, at its place", "1e-3 cells", long_walk;
    "S48", "the lazy hierarchy asked by 64 threads, 100 runs", "the same tree as by one", "bits", lazy_threads;
}

/// Deepest leaf that a tree may have.
const MAX_DEPTH: usize = 60;
const BUILD_SECONDS: f64 = 2.0;

fn sphere(centre: DVec3, radius: f64) -> Result<Shape, rt_geometry::ShapeError> {
    Sphere::new(centre, radius).map(Shape::Sphere)
}

fn solid(min: DVec3, max: DVec3) -> Result<Shape, rt_geometry::ShapeError> {
    Cuboid::new(min, max).map(Shape::Cuboid)
}

/// All accelerators against the first, which is brute force.
fn agree<P: Primitives>(
    accelerators: &[AnyAccelerator],
    primitives: &P,
    ray: &Ray,
    checks: &mut Checks,
) -> Option<Hit> {
    let (linear, others) = accelerators.split_first()?;
    let expected = linear.closest(primitives, ray, Interval::FORWARD, &mut NoProbe);
    for accelerator in others {
        let found = accelerator.closest(primitives, ray, Interval::FORWARD, &mut NoProbe);
        checks.check(key(found) == key(expected), || {
            format!("{}: {found:?} instead of {expected:?} for {ray:?}", accelerator.kind().name())
        });
    }
    expected
}

/// From a sphere around a box towards a random point of it.
fn ray_at(target: &Aabb, draw: &mut Draw) -> Ray {
    let origin = target.centre() + draw.direction() * target.extent().length();
    let point = target.centre() + draw.point() * 0.5 * target.extent();
    Ray::new(origin, point - origin)
}

fn shallow(accelerators: &[AnyAccelerator], checks: &mut Checks) {
    for accelerator in accelerators {
        let depth = accelerator.build_stats().max_depth;
        checks.check(depth <= MAX_DEPTH, || format!("{}: depth {depth}", accelerator.kind().name()));
    }
}

fn nothing(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let set = ShapeSet::default();
    let accelerators = all_accelerators(&set)?;
    checks.draw_all(conditions.count(2_000, 100_000), 37, |draw, checks| {
        let ray = Ray::new(draw.point(), draw.point() * draw.pick(&[0.0, 1.0, f64::INFINITY, f64::NAN]));
        for accelerator in &accelerators {
            let hit = accelerator.closest(&set, &ray, Interval::FORWARD, &mut NoProbe);
            let occluded = accelerator.occluded(&set, &ray, Interval::FORWARD, &mut NoProbe);
            checks.check(hit.is_none() && !occluded, || format!("{}: {hit:?}", accelerator.kind().name()));
        }
    });
    Ok(())
}

fn one(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for shape in [sphere(DVec3::X, 0.7)?, solid(DVec3::NEG_ONE, DVec3::ONE)?] {
        let set = ShapeSet::of_shapes([shape]);
        let accelerators = all_accelerators(&set)?;
        let target = Aabb::new(DVec3::splat(-1.2), DVec3::splat(1.8));
        checks.of_all(conditions.count(5_000, 500_000), |index, checks| {
            agree(&accelerators, &set, &ray_at(&target, &mut Draw::of(38, index)), checks);
        });
    }
    Ok(())
}

fn identical(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let count = conditions.count(100_000, 1_000_000) as usize;
    let set = ShapeSet::of_shapes(vec![sphere(DVec3::ONE, 0.5)?; count]);
    let mut accelerators = Vec::new();
    for &kind in AcceleratorKind::ALL {
        let started = Instant::now();
        let accelerator = AnyAccelerator::build(kind, &set)?;
        let seconds = started.elapsed().as_secs_f64();
        checks.note(format!("{}: built in {seconds:.2} s, depth {}", kind.name(), accelerator.build_stats().max_depth));
        checks.check(seconds < BUILD_SECONDS, || format!("{}: built in {seconds:.1} s", kind.name()));
        accelerators.push(accelerator);
    }
    shallow(&accelerators, checks);
    for index in 0..10 {
        let mut draw = Draw::of(39, index);
        let origin = draw.direction() * 9.0;
        let ray = Ray::new(origin, DVec3::ONE + draw.point() * 0.2 - origin);
        for accelerator in &accelerators {
            let first = accelerator.closest(&set, &ray, Interval::FORWARD, &mut NoProbe).map(|hit| hit.primitive);
            checks.same(first, Some(0), accelerator.kind().name());
        }
    }
    Ok(())
}

fn powers_of_two(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    // Boxes need not be as large as shapes must.
    let at = |i: i32| {
        let x = exp2(f64::from(-i));
        Aabb::new(DVec3::new(x, 0.0, 0.0), DVec3::new(x, 1e-3 * x, 0.0))
    };
    let boxes: Vec<Aabb> = (0..=1074).map(at).collect();
    let set = rt_accel::Boxes(&boxes);
    let accelerators = all_accelerators(&set)?;
    checks.of_all(conditions.count(1075 * 4, 1075 * 200), |index, checks| {
        let mut draw = Draw::of(40, index);
        let x = exp2(-((index % 1075) as f64));
        let aim = DVec3::new(x, draw.unit() * 1e-3 * x, 0.0);
        let direction = DVec3::new(draw.pick(&[0.0, -0.0, x, 0.1]), draw.pick(&[-1.0, -x]), draw.pick(&[0.0, 0.5]));
        agree(&accelerators, &set, &Ray::new(aim - direction, direction), checks);
    });
    shallow(&accelerators, checks);
    Ok(())
}

fn flat(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let side = 24;
    let corner = |i: usize, j: usize| {
        let place = |k: usize| 2.0 * k as f64 / side as f64 - 1.0;
        DVec3::new(place(i), place(j), 0.0)
    };
    let mut shapes = Vec::new();
    for (i, j) in (0..side * side).map(|cell| (cell % side, cell / side)) {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        shapes.push(Shape::Triangle(Triangle::new([a, b, c])?));
        shapes.push(if (i + j) % 3 == 0 { solid(a, c)? } else { Shape::Triangle(Triangle::new([a, c, d])?) });
    }
    let set = ShapeSet::of_shapes(shapes);
    let accelerators = all_accelerators(&set)?;
    checks.draw_all(conditions.count(2_000, 200_000), 41, |draw, checks| {
        let aim = corner(draw.below(side + 1), draw.below(side + 1));
        let origin = match draw.below(4) {
            // Within the plane, straight above, and anywhere.
            0 => DVec3::new(draw.between(-2.0, 2.0), draw.between(-2.0, 2.0), 0.0),
            1 => aim + DVec3::Z,
            _ => draw.point() * 3.0,
        };
        let aim = if draw.one_in(2) { aim } else { aim + DVec3::new(draw.unit(), draw.unit(), 0.0) * 0.1 };
        agree(&accelerators, &set, &Ray::new(origin, aim - origin), checks);
    });
    Ok(())
}

fn stadium(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let count = conditions.count(20_000, 1_000_000);
    let mut draw = Draw::new(42);
    let mut boxes = vec![Aabb::new(DVec3::splat(-5e5), DVec3::splat(5e5))];
    boxes.extend((0..count).map(|_| {
        let corner = draw.point();
        Aabb::new(corner, corner + 1e-3)
    }));
    // Solid boxes: a ray that starts in the stadium meets it from inside, behind all the others.
    let shapes: Result<Vec<Shape>, _> = boxes.iter().map(|b| solid(b.min, b.max)).collect();
    let set = ShapeSet::of_shapes(shapes?);
    let accelerators = all_accelerators(&set)?;
    let crowd = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
    let ray = |index: u64| {
        let mut draw = Draw::of(42, index);
        if index.is_multiple_of(2) { ray_at(&crowd, &mut draw) } else { ray_at(&boxes[0], &mut draw) }
    };
    let count = conditions.count(100, 400);
    checks.of_all(count, |index, checks| {
        agree(&accelerators, &set, &ray(index), checks);
    });
    let rays: Vec<Ray> = (0..count.min(50)).map(ray).collect();
    for accelerator in &accelerators {
        let mut counters = Counters::default();
        for ray in &rays {
            accelerator.closest(&set, ray, Interval::FORWARD, &mut counters);
        }
        let per_ray = (counters.total().nodes + counters.total().tests) as f64 / rays.len() as f64;
        checks.note(format!("{}: {per_ray:.0} nodes and primitives per ray", accelerator.kind().name()));
    }
    Ok(())
}

/// Rays along a face of a node's box, with an origin in the face or one step off it.
fn split_planes(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let mut draw = Draw::new(43);
    let mut shapes = Vec::new();
    for index in 0..60 {
        let centre = (draw.point() * 4.0).round() / 4.0;
        shapes.push(if index % 2 == 0 { sphere(centre, 0.25)? } else { solid(centre, centre + 0.25)? });
    }
    let set = ShapeSet::of_shapes(shapes);
    let accelerators = all_accelerators(&set)?;
    let mut planes: [Vec<f64>; 3] = Default::default();
    for accelerator in &accelerators {
        accelerator.for_each_box(|node, _| {
            for (axis, planes) in planes.iter_mut().enumerate() {
                planes.extend([node.min[axis], node.max[axis]].iter().filter(|x| x.is_finite()));
            }
        });
    }
    for planes in &mut planes {
        planes.sort_by(f64::total_cmp);
        planes.dedup();
    }
    checks.draw_all(conditions.count(20_000, 1_000_000), 43, |draw, checks| {
        let axis = draw.below(3);
        let mut origin = draw.point() * 2.0;
        let mut direction = draw.point() * 0.6 - origin;
        origin[axis] = draw.pick(&planes[axis]);
        direction[axis] = draw.pick(&[0.0, -0.0, 0.0, 5e-324, -1e-300, 1e-20]);
        if draw.one_in(4) {
            origin[axis] = draw.neighbour(origin[axis]);
        }
        if draw.one_in(3) {
            // In two planes at once: along an edge.
            let other = (axis + 1) % 3;
            origin[other] = draw.pick(&planes[other]);
            direction[other] = 0.0;
        }
        agree(&accelerators, &set, &Ray::new(origin, direction), checks);
    });
    checks.note(format!("{} planes", planes.iter().map(Vec::len).sum::<usize>()));
    Ok(())
}

fn cell_corners(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const CELLS: u32 = 256;
    let mut draw = Draw::new(44);
    let mut shapes = vec![solid(DVec3::ZERO, DVec3::splat(1.0 / 64.0))?, solid(DVec3::splat(63.0 / 64.0), DVec3::ONE)?];
    for _ in 0..60 {
        // Faces of boxes and poles of spheres lie in walls of cells.
        let corner = (draw.point() * 31.0).round() / 64.0 + 0.5;
        shapes.push(solid(corner, corner + 1.0 / 64.0)?);
        shapes.push(sphere(corner, 1.0 / 128.0)?);
    }
    let set = ShapeSet::of_shapes(shapes);
    let mut accelerators = all_accelerators(&set)?;
    let fine = UniformGrid::with_resolution(&set, [CELLS; 3])?;
    accelerators.push(AnyAccelerator::Grid(fine));
    checks.draw_all(conditions.count(10_000, 1_000_000), 44, |draw, checks| {
        let through = DVec3::from([(); 3].map(|()| draw.below(CELLS as usize + 1) as f64)) / f64::from(CELLS);
        let direction = DVec3::from([(); 3].map(|()| draw.pick(&[1.0, -1.0, 1.0, -1.0, 0.0, 0.5, 2.0])));
        let back = draw.pick(&[2.0, 1.0, 0.5, 3.0 / 256.0]);
        agree(&accelerators, &set, &Ray::new(through - direction * back, direction), checks);
    });
    Ok(())
}

/// An upright sheet in the middle of each cell, met in turn by a ray that is not aligned with anything.
fn long_walk(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const CELLS: u32 = 100_000;
    let at = |i: u32| DVec3::new(f64::from(i) + 0.5, (f64::from(i) + 0.5) * 1e-3, 0.0);
    let reach = DVec3::new(0.0, 0.05, 0.05);
    let sheets: Result<Vec<Shape>, _> = (0..CELLS).map(|i| solid(at(i) - reach, at(i) + reach)).collect();
    let set = ShapeSet::of_shapes(sheets?);
    let grid = UniformGrid::with_resolution(&set, [CELLS, 1, 1])?;
    for direction in [DVec3::new(1.0, 1e-3, 0.0), DVec3::new(FRAC_1_SQRT_2, FRAC_1_SQRT_2 * 1e-3, 0.0)] {
        for forwards in [true, false] {
            let direction = if forwards { direction } else { -direction };
            let start = if forwards { at(0) - direction * 10.0 } else { at(CELLS - 1) - direction * 10.0 };
            let ray = Ray::new(start, direction);
            let mut hits = Vec::new();
            let mut counters = Counters::default();
            grid.all_hits(&set, &ray, Interval::FORWARD, &mut hits, &mut counters);
            checks.same(hits.len(), CELLS as usize, "sheets met");
            for (turn, hit) in (0..CELLS).zip(&hits) {
                let expected = if forwards { turn } else { CELLS - 1 - turn };
                checks.same(hit.primitive, expected, "sheet");
                checks.limit(ray.at(hit.t).x - at(expected).x, 1e-3, format_args!("sheet {expected}"));
            }
            let nodes = counters.total().nodes;
            checks.check(nodes <= u64::from(CELLS) + 2, || format!("{nodes} cells were visited"));
        }
    }
    Ok(())
}

fn lazy_threads(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const THREADS: u64 = 64;
    let runs = conditions.count(8, 100);
    let mut draw = Draw::new(48);
    let shapes: Result<Vec<Shape>, _> = (0..2_000).map(|_| sphere(draw.point(), draw.between(0.001, 0.03))).collect();
    let set = ShapeSet::of_shapes(shapes?);
    let rays: Vec<Ray> =
        (0..THREADS * 16).map(|i| ray_at(&Aabb::new(DVec3::NEG_ONE, DVec3::ONE), &mut Draw::of(48, i))).collect();
    let ask = |accelerator: &LazyBih, rays: &mut dyn Iterator<Item = &Ray>| {
        rays.map(|ray| key(accelerator.closest(&set, ray, Interval::FORWARD, &mut NoProbe))).collect::<Vec<_>>()
    };
    let alone = LazyBih::build(&set)?;
    let expected = ask(&alone, &mut rays.iter());
    let partly = alone.build_stats();
    for run in 0..runs {
        let accelerator = LazyBih::build(&set)?;
        // Each thread starts elsewhere in the same list, and so comes to the same nodes in another order.
        let answers: Vec<_> = std::thread::scope(|scope| {
            let start = |thread: u64| (thread * 16 + run * 5) as usize % rays.len();
            let spawn = |thread: u64| {
                let (accelerator, rays) = (&accelerator, &rays);
                let answered = rays.iter().cycle().skip(start(thread)).take(rays.len());
                scope.spawn(move || (start(thread), ask(accelerator, &mut answered.into_iter())))
            };
            let threads: Vec<_> = (0..THREADS).map(spawn).collect();
            threads.into_iter().map(std::thread::ScopedJoinHandle::join).collect()
        });
        for answer in answers {
            let right = answer.is_ok_and(|(start, mut found)| {
                found.rotate_right(start);
                found == expected
            });
            checks.check(right, || format!("run {run}: a thread got other hits"));
        }
        checks.check(accelerator == alone, || format!("run {run}: another tree"));
    }
    alone.complete();
    checks.note(format!("{} nodes of {} were split", partly.nodes, alone.build_stats().nodes));
    Ok(())
}
