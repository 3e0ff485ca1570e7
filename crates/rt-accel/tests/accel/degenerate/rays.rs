//! Degenerate rays and spans.

use rt_accel::wide::{BuildParams, SimdLevel};
use rt_accel::{
    Aabb, Accelerator, AcceleratorKind, AnyAccelerator, DVec3, Interval, NoProbe, Ray, SphereKernel, UniformGrid,
    WideBvh, brute_force,
};
use rt_math::Vec3;

use super::{FORWARD, down, rays_at, unit_box};
use crate::soup::accelerators::Accelerators;
use crate::soup::{Solid, Soup};
use rt_tests::Draw;

#[test]
fn rays_in_the_planes_of_a_tree_miss_nothing() {
    let soup = Soup::mixed(&mut Draw::new(31));
    let all = Accelerators::build(&soup);
    let mut draw = Draw::new(32);
    for kind in [AcceleratorKind::Kd, AcceleratorKind::Bsp] {
        let mut cells = Vec::new();
        all.0.iter().find(|accelerator| accelerator.kind() == kind).unwrap().for_each_box(|cell, _| cells.push(cell));
        assert!(cells.len() > 300, "{}", cells.len());
        for _ in 0..4000 {
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
fn rays_in_walls_and_through_corners_of_cells_miss_nothing() {
    // Unit boxes that fill 8³ cells; walls, edges and corners of cells and of nodes coincide with theirs.
    let corners = (0..512).map(|i| DVec3::new(f64::from(i % 8), f64::from(i / 8 % 8), f64::from(i / 64)));
    let soup = Soup(corners.map(unit_box).collect());
    let mut all = Accelerators::build(&soup);
    let directions = [-1.0, -0.0, 0.0, 1.0, 0.5];
    for n in [8, 4, 7] {
        all.0.retain(|accelerator| accelerator.kind() != AcceleratorKind::Grid);
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
    let all = Accelerators::build(&soup);
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
    let all = Accelerators::build(&soup);
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -f64::MAX, 0.0, -0.0, 5e-324, 1e-310, 1.0];
    let mut draw = Draw::new(12);
    for _ in 0..4000 {
        let mut vector = || DVec3::new(draw.pick(&odd), draw.pick(&odd), draw.pick(&odd));
        let ray = Ray::new(vector(), vector());
        all.closest(&soup, &ray, FORWARD);
        all.closest(&soup, &ray, Interval::new(-1.0, 1.0));
        all.closest(&soup, &ray, Interval::new(f64::NEG_INFINITY, 0.0));
    }
}

#[test]
fn streams_equal_single_queries() {
    let soup = Soup::mixed(&mut Draw::new(21));
    let all = Accelerators::build(&soup);
    let rays: Vec<_> =
        rays_at(&Aabb::new(DVec3::splat(-1.0), DVec3::ONE), 100).into_iter().map(|ray| (ray, FORWARD)).collect();
    let hits = closest!(all.bvh(), &soup, &rays, &mut NoProbe);
    let occluded = occluded!(all.bvh(), &soup, &rays, &mut NoProbe);
    for (i, (ray, span)) in rays.iter().enumerate() {
        assert_eq!(hits[i], all.closest(&soup, ray, *span));
        assert_eq!(occluded[i], hits[i].is_some());
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
                let occluded = tree.occluded(&soup, &ray, span, &mut NoProbe);
                assert_eq!(occluded, is_hit, "{aside} of {scale}");
            }
        }
    }
}

#[test]
fn triangles_whose_products_vanish_are_hit_and_where_they_are() {
    let far = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|v| v + Vec3::splat(50.0));
    let skew = [[7.4e-16, 1.45e-15, 1.77e-15], [2.65e-15, 1.44e-15, 2.53e-15], [-2.83e-15, -2.1e-16, 2.66e-15]];
    for scale in [1.0, 1e-8, 1e-11, 1e-12, 1e-14, 1e-20, 1e-24] {
        let small = [[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [-1.0, 2.0, 0.0]].map(|v| Vec3::from(v) * scale);
        for (facet, origin, direction) in [
            (small, DVec3::NEG_Z * 100.0 * f64::from(scale), DVec3::Z),
            (small, DVec3::new(0.3, 0.2, -7.0) * f64::from(scale), DVec3::new(-0.1, 0.05, 1.0)),
            (skew.map(Vec3::from), DVec3::NEG_Z * 1e-14, DVec3::new(-0.009, 0.063, 1.0)),
        ] {
            let soup = Soup(vec![Solid::Facet(facet), Solid::Facet(far)]);
            let ray = Ray::new(origin, direction);
            let expected = brute_force::closest(&soup, &ray, FORWARD, &mut NoProbe);
            assert!(expected.is_some());
            for &level in SimdLevel::ALL {
                let params = BuildParams { max_leaf: 1, ..BuildParams::default() };
                let tree = WideBvh::build_with(&soup, &params).expect("two triangles").with_level(level);
                let found = tree.closest(&soup, &ray, FORWARD, &mut NoProbe);
                assert_eq!(found, expected, "{facet:?} at {scale}");
            }
        }
    }
}
